// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/version.h>

#include "support/text_parts.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view::test {

using pcl_ext::test::hasPart;

class RawConnection {
public:
  explicit RawConnection(std::uint16_t port);
  ~RawConnection();
  RawConnection(const RawConnection&) = delete;
  RawConnection&
  operator=(const RawConnection&) = delete;

  /** \brief Sends what the system takes; false if the connection was closed. */
  bool
  send(const std::string& bytes);

  /** \brief All bytes until the server closes the connection; nothing if it does
   * not. */
  std::optional<std::string>
  receiveAll();

  /** \brief Receives up to and with a text; fewer if the connection is closed. */
  std::string
  receiveUntil(const std::string& end);

  std::string
  receive(std::size_t count);

private:
  int socket_;
};

struct HttpAnswer {
  int status = 0;
  std::map<std::string, std::string> headers; ///< names in lower case
  std::string body;
};

/** \brief Sends a request.
 * \param[in] headers each with \r\n; Host is added if there is none
 */
HttpAnswer
request(std::uint16_t port,
        const std::string& target,
        const std::string& headers = {},
        const std::string& method = "GET");

/** \brief The status of a request for a WebSocket, with a correct key.
 * \param[in] headers besides; Host is added if there is none
 */
int
upgradeStatus(std::uint16_t port,
              const std::string& headers,
              const std::string& path = "/api/live");

struct LiveMessage {
  std::string text; ///< empty: a frame
  std::uint32_t stream = 0;
  std::uint32_t flags = 0;
  std::int64_t time = 0;
  std::vector<std::uint8_t> frame;
};

class LiveClient {
public:
  /** \brief Connects; a failure of the test if that fails.
   * \param[in] receive_buffer of the system, bytes; 0: as it is
   */
  explicit LiveClient(std::uint16_t port, int receive_buffer = 0);
  ~LiveClient();
  LiveClient(LiveClient&&) noexcept;

  /** \brief The next message that is not on the state of the streams; nothing if the
   * connection is closed, or after a long time. */
  std::optional<LiveMessage>
  next();

  /** \brief The next text on the state of the streams; empty if the connection is
   * closed. */
  std::string
  nextState();

  std::optional<LiveMessage>
  nextFrame();

  /** \brief Sends a text; false if the connection is closed. */
  bool
  send(const std::string& text);

  std::string
  protocol() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

struct ProcessUse {
  std::size_t descriptors = 0;
  std::size_t threads = 0;
};
ProcessUse
processUse();

} // namespace pcl_ext::PCL_EXT_ABI::view::test
