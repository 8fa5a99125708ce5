#include "recording/frame_source.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace recording {

/** \brief Numbers a frame as the next one of its stream. */
void
FrameSource::count(FramePlace& place)
{
  RecordedStream& of = streams_[place.stream];
  of.first_time = of.frames == 0 ? place.time : std::min(of.first_time, place.time);
  of.last_time = of.frames == 0 ? place.time : std::max(of.last_time, place.time);
  place.number = of.frames++;
}

void
FrameSource::addFrame(std::size_t stream, Time time, std::uint64_t at)
{
  places_.push_back({time, stream, 0, at});
  count(places_.back());
}

void
FrameSource::takeFrames(std::vector<FramePlace> places)
{
  places_ = std::move(places);
  for (FramePlace& place : places_)
    count(place);
}

} // namespace recording
} // namespace pcl_ext
