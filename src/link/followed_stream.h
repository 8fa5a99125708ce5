// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "codec/frame_order.h"
#include "link/frame_headers.h"
#include "link/whole_frame.h"
#include "stream/frame_chain.h"

#include <chrono>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief What is known of a stream that is received: which frame continues it, and when
 * an I-frame may be requested again. For one thread at a time. */
class FollowedStream {
public:
  using Clock = std::chrono::steady_clock;

  /** \brief Takes a frame that arrived into account.
   * \return true if it can be decoded after those that were accepted before
   */
  bool
  accept(const FrameHeader& header, const WholeFrame& frame);

  /** \brief An accepted frame was not kept: the next one cannot be decoded. */
  void
  drop();

  /** \brief True if no frame can be decoded before the next I-frame; also if all frames
   * that come are of another publisher, or late, as after a number that was too high. */
  bool
  needsIFrame() const
  {
    return !chain_.isWhole() || frames_of_another_ >= most_in_a_row ||
           late_in_a_row_ >= most_in_a_row;
  }

  /** \brief True if an I-frame is to be requested now; counts it.
   * \param[in] interval from one request to the next
   */
  bool
  shouldRequest(Clock::time_point now, Clock::duration interval);

  /** \brief Of this stream, but its name, bytes and age. */
  LinkStreamStatistics statistics;

  std::optional<Clock::time_point> last_arrival; ///< of a frame that was kept

private:
  static constexpr unsigned int most_in_a_row = 3;

  /** \brief More frames are not lost: the numbers are of another count. */
  static constexpr std::uint32_t most_lost = 1u << 24;

  /** \brief Counts a frame that came and cannot be decoded. */
  void
  skip();

  /** \brief True if a frame of the same publisher is not to be used. */
  bool
  isLate(const FrameHeader& header, std::uint32_t checksum, bool is_i_frame);

  /** \brief Begins to count the frames of a publisher. */
  void
  begin(std::uint64_t publisher, std::uint32_t number);

  std::optional<std::uint64_t> publisher_;
  std::uint32_t number_ = 0; // of its last frame, modulo 2^32
  Time time_{0};             // of that frame
  io::FrameOrder order_{true};
  io::FrameChain chain_;
  bool has_i_frame_ = false; // one was accepted
  // Since the last accepted frame:
  unsigned int frames_of_another_ = 0;
  unsigned int late_in_a_row_ = 0;
  unsigned int requests_in_a_row_ = 0;
  Clock::time_point next_request_{};
};

} // namespace pcl_ext::PCL_EXT_ABI::link
