// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include "view/live_messages.h"
#include "view/viewer_queue.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief What a viewer is sent next: a text, or a frame with its head. */
struct OutgoingMessage {
  std::shared_ptr<const std::string> text; ///< null: a frame
  FrameHead head{};
  FrameBytes frame;
};

/** \brief Live streams and what waits for their viewers. Knows no connections.
 * Thread-safe; a call takes the time of some copies of pointers for each viewer. */
class LiveStreams {
public:
  using Clock = std::chrono::steady_clock;

  /** \param[in] limits on what is kept and queued
   * \param[in] can_request whether somebody makes I-frames that are asked for
   */
  LiveStreams(const ViewServerLimits& limits, bool can_request);

  std::size_t
  addStream(const LiveStream& stream);

  /** \return false if there is no such stream */
  bool
  setMetadata(std::size_t stream, const std::map<std::string, std::string>& metadata);

  /** \brief Queues a frame for all viewers. */
  ViewServerStatus
  publish(std::size_t stream,
          std::chrono::nanoseconds time,
          std::vector<std::uint8_t>&& frame);

  /** \brief Sets why frames may be missing, for people, and queues the message; empty:
   * no reason is known. */
  void
  setProblem(const std::string& problem);

  /** \brief Queues the message on how fresh the streams are, for all viewers; to be
   * called once a second. */
  void
  queueState();

  /** \brief Queues the message of the end for all viewers, also future ones. */
  void
  end();

  /** \brief A new viewer, which gets each stream from its last I-frame on. */
  std::shared_ptr<ViewerQueue>
  addViewer();

  void
  removeViewer(const std::shared_ptr<ViewerQueue>& viewer);

  /** \brief A viewer has lost step with a stream. Streams that do not exist are
   * ignored. */
  void
  restart(ViewerQueue& viewer, std::size_t stream);

  /** \brief Takes what a viewer is sent next; false if nothing waits. */
  bool
  next(ViewerQueue& viewer, OutgoingMessage& message);

  /** \brief True if an I-frame is to be requested now or later. */
  bool
  wantsIFrames() const;

  /** \brief The streams of which an I-frame is to be requested now; they count as
   * requested. */
  std::vector<std::size_t>
  dueIFrameRequests(Clock::time_point now);

  void
  addTo(ViewServerStatistics& statistics) const;

private:
  /** \brief A stream with its frames from the last I-frame on. */
  struct Stream {
    std::deque<QueuedFrame> kept;
    std::size_t kept_bytes = 0;
    bool is_kept = false; ///< kept is all since an I-frame
    std::uint32_t last_number = 0;
    std::optional<Clock::time_point> last_frame; ///< when it was published
    bool wants_i_frame = false;                  ///< a viewer has nothing to begin with
    bool is_asked = false;                       ///< by a viewer that has lost step
    Clock::time_point next_request{};            ///< not before
    Clock::time_point next_answer{};             ///< to viewers that have lost step
    std::chrono::milliseconds request_interval{0};

    void
    forget();

    bool
    needsIFrame() const
    {
      return wants_i_frame || is_asked;
    }
  };

  void
  keep(Stream& stream, const QueuedFrame& frame, std::uint32_t number);

  void
  updateMessage();

  std::string
  describeState(Clock::time_point now) const;

  const ViewServerLimits limits_;
  const bool can_request_;
  mutable std::mutex mutex_; // of all below
  std::vector<LiveStream> descriptions_;
  std::vector<Stream> streams_;
  std::vector<std::shared_ptr<ViewerQueue>> viewers_;
  std::shared_ptr<const std::string> streams_message_;
  const std::shared_ptr<const std::string> end_message_;
  std::string problem_; // see setProblem()
  bool has_ended_ = false;
  ViewServerStatistics statistics_; // without what is summed when it is asked for
};

} // namespace pcl_ext::PCL_EXT_ABI::view
