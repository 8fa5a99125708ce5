// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup view
 * @{ */
/** \brief Shows recordings and live streams in browsers. */
namespace view {

/** \brief Outcomes of calls to a ViewServer. */
enum class ViewServerCode {
  Ok,
  InvalidArgument, ///< an unknown stream, no frame, no address, or a wrong order
  CannotListen,    ///< the port is taken, or the address is not one of this machine
  InputFailed,     ///< a file cannot be read
  OutOfMemory
};

/** \brief Outcome of a call to a ViewServer. */
using ViewServerStatus = Status<ViewServerCode>;

/** \brief Bounds on what viewers can take of the server. */
struct ViewServerLimits {
  /** \brief Connections at the same time; further ones are answered with 503. */
  std::size_t max_connections = 256;

  /** \brief Time in which the head of a request must arrive. */
  std::chrono::milliseconds header_timeout{10'000};

  /** \brief Time after which a connection is closed on which nothing moves: between two
   * requests, while a viewer takes nothing of an answer, or if it answers no ping. */
  std::chrono::milliseconds idle_timeout{30'000};

  /** \brief Frames of one stream that wait for one viewer. A viewer for which more
   * would wait is too slow: they are dropped, and it gets the stream from the next
   * I-frame on. */
  std::size_t max_queued_frames = 60;

  /** \brief The same in bytes, of all streams together; one frame is taken in any
   * case. */
  std::size_t max_queued_bytes = std::size_t{16} << 20;

  /** \brief Frames since the last I-frame that are kept for new viewers, of each
   * stream. Of streams with more an I-frame is requested for a new viewer. */
  std::size_t max_kept_frames = 300;

  /** \brief The same in bytes. */
  std::size_t max_kept_bytes = std::size_t{16} << 20;

  /** \brief Time between two requests for an I-frame of one stream. It doubles while
   * none comes, up to 16-fold. It is 10-fold for viewers that say that they have lost
   * step. */
  std::chrono::milliseconds i_frame_request_interval{100};
};

/** \brief Whether a text may be the viewer's page, as viewer/build.sh makes it: it has the
 * element in which the page's codec is. */
PCL_EXT_VIEW_EXPORT bool
isViewerPage(const std::string& page);

/** \brief What a ViewServer serves, and where. */
struct ViewServerSettings {
  /** \brief Address to listen on, in numbers. Empty: loopback, 127.0.0.1 and ::1 if
   * there is one. Whoever reaches another address sees the clouds. */
  std::string address;

  /** \brief Port; 0: a free one, see ViewServer::port(). */
  std::uint16_t port = 0;

  /** \brief The page, HTML; any is served, see isViewerPage(). */
  std::string page;

  /** \brief Name of the source, which the page shows. */
  std::string name;

  ViewServerLimits limits;

  /** \brief Called when a viewer needs an I-frame of a stream, which its encoder is to
   * make the next frame. Empty: viewers wait for the next one. Called by the server's
   * thread; must not wait, throw, or destroy the server. */
  std::function<void(std::size_t stream)> request_i_frame;

  /** \brief Figures of the program for /metrics, in Prometheus' text format 0.0.4, such
   * as nodes::streamMetrics(). The server's own, pcl_ext_view_..., follow. Empty: these
   * alone. Called by the server's thread; must not wait or throw. */
  std::function<std::string()> metrics;
};

/** \brief Figures of a ViewServer. */
struct ViewServerStatistics {
  std::size_t connections = 0;          ///< open now
  std::size_t viewers = 0;              ///< of these, with live streams
  std::uint64_t refused = 0;            ///< connections beyond the limit
  std::uint64_t frames = 0;             ///< published
  std::uint64_t frames_sent = 0;        ///< summed over the viewers
  std::uint64_t frames_skipped = 0;     ///< likewise; viewers were too slow for them
  std::size_t queued_bytes = 0;         ///< that wait now, summed over the viewers
  std::size_t largest_queue_bytes = 0;  ///< that ever waited for one viewer
  std::size_t largest_queue_frames = 0; ///< likewise
  std::size_t kept_bytes = 0;           ///< of the frames for new viewers
  std::uint64_t i_frame_requests = 0;   ///< calls of request_i_frame
};

/** \brief Serves the viewer's page over HTTP, with a recording, or with live streams
 * over a WebSocket. doc/viewing.md has the protocol.
 *
 * The server has one thread. What changes or shows streams may be called by any thread,
 * before start(), too; setRecording() only before it. Nothing throws or waits for a
 * viewer. Frames are shared between viewers.
 * \code
 * pcl_ext::view::ViewServerSettings settings;
 * settings.page = page; // the bytes of viewer.html
 * settings.request_i_frame = [&](std::size_t) { wants_i_frame = true; };
 * pcl_ext::view::ViewServer server(settings);
 * std::size_t stream = 0;
 * auto status = server.start();
 * if (status.ok())
 *   status = server.addStream("/sensor_1", {}, stream);
 * std::cout << server.url() << '\n';
 * // each frame:
 * server.publish(stream, time, bytes);
 * \endcode
 */
class PCL_EXT_VIEW_EXPORT ViewServer {
public:
  explicit ViewServer(const ViewServerSettings& settings);

  /** \brief Closes all connections. */
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer&
  operator=(const ViewServer&) = delete;

  /** \brief Serves a recording in place of live streams.
   * \param[in] paths its files: one, or those of a rosbag2 folder in their order. They
   * stay open
   * \return InputFailed if one cannot be read; InvalidArgument after start()
   */
  ViewServerStatus
  setRecording(const std::vector<std::string>& paths) noexcept;

  /** \brief Listens from now on. */
  ViewServerStatus
  start() noexcept;

  /** \brief The port; 0 before start(). */
  std::uint16_t
  port() const noexcept;

  /** \brief Address of the page for a browser on this machine; empty before start(). */
  std::string
  url() const;

  /** \brief True if only this machine reaches the server; also before start(). */
  bool
  isLoopback() const noexcept;

  /** \brief Adds a live stream.
   * \param[in] name for people, such as a topic
   * \param[in] metadata as that of a recording's channels
   * \param[out] stream number for publish(), from 0
   */
  ViewServerStatus
  addStream(const std::string& name,
            const std::map<std::string, std::string>& metadata,
            std::size_t& stream) noexcept;

  /** \brief Changes what viewers know of a stream. */
  ViewServerStatus
  setMetadata(std::size_t stream,
              const std::map<std::string, std::string>& metadata) noexcept;

  /** \brief Sends the next frame of a stream to all viewers.
   * \param[in] stream number of addStream()
   * \param[in] time of the cloud
   * \param[in] frame exactly one, of either format
   */
  ViewServerStatus
  publish(std::size_t stream,
          std::chrono::nanoseconds time,
          std::vector<std::uint8_t> frame) noexcept;

  /** \brief Tells viewers why frames may be missing, in one sentence that they show, such
   * as that a connection is lost. Empty: that is over. Viewers get to know the age of
   * each stream in any case. */
  void
  setProblem(const std::string& problem) noexcept;

  /** \brief Tells viewers that no frames will follow. */
  void
  end() noexcept;

  ViewServerStatistics
  statistics() const noexcept;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace view
/** @} */

} // namespace pcl_ext::PCL_EXT_ABI
