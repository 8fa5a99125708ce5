// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What the server's connections share; used by the server's thread alone.
 */
#pragma once

#include <pcl_ext/view/view_server.h>

#include "view/live_streams.h"
#include "view/resource.h"

#include <boost/asio/ip/tcp.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <random>
#include <set>

namespace pcl_ext::PCL_EXT_ABI::view {

class LiveSession;

/** \brief What requests are answered with. Outlives all connections. */
struct ServedContent {
  explicit ServedContent(const ViewServerSettings& settings)
  : limits(settings.limits)
  , streams(settings.limits, static_cast<bool>(settings.request_i_frame))
  {}

  const ViewServerLimits limits;
  Resources resources;
  bool is_live = true;     ///< false: a recording
  bool is_loopback = true; ///< other machines cannot reach the server
  LiveStreams streams;
  std::set<LiveSession*> viewers; ///< connections that have been accepted as such
  std::function<void()> check_i_frame_requests;
  std::function<std::string()> metrics; ///< text for /metrics
  std::atomic<std::size_t> connections{0};
  std::mt19937_64 random{std::random_device()()};
};

/** \brief Counts a connection while it exists. */
class CountedConnection {
public:
  explicit CountedConnection(std::atomic<std::size_t>& count) : count_(count)
  {
    ++count_;
  }
  ~CountedConnection() { --count_; }
  CountedConnection(const CountedConnection&) = delete;
  CountedConnection&
  operator=(const CountedConnection&) = delete;

private:
  std::atomic<std::size_t>& count_;
};

using ConnectionToken = std::unique_ptr<CountedConnection>;

/** \brief Answers the requests of a connection until it is closed. */
void
serveConnection(boost::asio::ip::tcp::socket socket,
                ServedContent& content,
                ConnectionToken token);

/** \brief Sends a viewer what waits for it, if nothing is being sent. */
void
wake(LiveSession& viewer);

} // namespace pcl_ext::PCL_EXT_ABI::view
