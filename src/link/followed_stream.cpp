#include "link/followed_stream.h"

#include <algorithm>

namespace pcl_ext {
namespace link {

bool
FollowedStream::accept(const FrameHeader& header, const FrameKind& frame)
{
  if (publisher_ != header.publisher) {
    // Another run of the publisher, or a second one. It begins anew with an I-frame; until
    // then the frames of the one before may go on.
    if (publisher_ && !frame.is_i_frame) {
      ++statistics.frames_skipped;
      ++frames_of_another_;
      return false;
    }
    publisher_ = header.publisher;
    ++statistics.publishers;
    number_ = header.number - 1;
    last_.reset();
  }
  if (header.number <= number_) {
    ++statistics.frames_late;
    return false;
  }
  const std::uint64_t lost = header.number - number_ - 1;
  statistics.frames_lost += lost;
  number_ = header.number;
  const bool continues = lost == 0 && last_ && frame.number == *last_ + 1;
  if (!frame.is_i_frame && !continues) {
    last_.reset();
    ++statistics.frames_skipped;
    return false;
  }
  last_ = frame.number;
  requests_in_a_row_ = 0;
  frames_of_another_ = 0;
  return true;
}

void
FollowedStream::drop()
{
  last_.reset();
  ++statistics.frames_dropped;
}

bool
FollowedStream::shouldRequest(Clock::time_point now, Clock::duration interval)
{
  if (now < next_request_)
    return false;
  constexpr unsigned int most_doublings = 4;
  next_request_ = now + interval * (1 << std::min(requests_in_a_row_, most_doublings));
  ++requests_in_a_row_;
  ++statistics.i_frame_requests;
  return true;
}

} // namespace link
} // namespace pcl_ext
