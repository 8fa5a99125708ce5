#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "link/frame_headers.h"
#include "link/frame_kind.h"

#include <chrono>
#include <cstdint>
#include <optional>

namespace pcl_ext {
namespace link {

/** \brief What is known of a stream that is received: which frame continues it, and when
 * an I-frame may be requested again. For one thread at a time. */
class FollowedStream {
public:
  using Clock = std::chrono::steady_clock;

  /** \brief Takes a frame that arrived into account.
   * \return true if it can be decoded after those that were accepted before
   */
  bool
  accept(const FrameHeader& header, const FrameKind& frame);

  /** \brief An accepted frame was not kept: the next one cannot be decoded. */
  void
  drop();

  /** \brief True if no frame can be decoded before the next I-frame; also if frames come
   * from another publisher alone, whose I-frame was lost. */
  bool
  needsIFrame() const
  {
    return !last_ || frames_of_another_ >= most_of_another;
  }

  /** \brief True if an I-frame is to be requested now; counts it.
   * \param[in] interval from one request to the next
   */
  bool
  shouldRequest(Clock::time_point now, Clock::duration interval);

  /** \brief Of this stream, but its name and bytes. */
  LinkStreamStatistics statistics;

private:
  static constexpr unsigned int most_of_another = 3;

  std::optional<std::uint64_t> publisher_;
  unsigned int frames_of_another_ = 0; // since the last accepted one
  std::uint64_t number_ = 0;           // of the last frame that arrived
  std::optional<std::uint32_t> last_; // the encoder's number of the last accepted frame
  Clock::time_point next_request_{};
  unsigned int requests_in_a_row_ = 0;
};

} // namespace link
} // namespace pcl_ext
