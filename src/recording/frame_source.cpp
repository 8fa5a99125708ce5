#include "recording/frame_source.h"

#include <algorithm>
#include <limits>

namespace pcl_ext {
namespace recording {

io::DecoderLimits
limitsOfReading()
{
  io::DecoderLimits limits;
  limits.max_frame_bytes = max_recorded_frame_bytes;
  limits.max_voxels = std::numeric_limits<std::uint32_t>::max();
  limits.max_points = std::numeric_limits<std::uint32_t>::max();
  return limits;
}

void
FrameSource::addFrame(std::size_t stream, Time time, std::uint64_t at)
{
  RecordedStream& of = streams_[stream];
  of.first_time = of.frames == 0 ? time : std::min(of.first_time, time);
  of.last_time = of.frames == 0 ? time : std::max(of.last_time, time);
  places_.push_back({time, stream, of.frames, at});
  ++of.frames;
}

} // namespace recording
} // namespace pcl_ext
