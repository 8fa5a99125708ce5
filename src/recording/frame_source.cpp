// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/frame_source.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Numbers a frame as the next one of its stream. */
void
FrameSource::count(IndexedFrame& indexed)
{
  RecordedStream& of = streams_[indexed.stream];
  of.first_time = of.frames == 0 ? indexed.time : std::min(of.first_time, indexed.time);
  of.last_time = of.frames == 0 ? indexed.time : std::max(of.last_time, indexed.time);
  indexed.number = of.frames++;
}

void
FrameSource::makeTimesRise(std::vector<IndexedFrame>& frames) const
{
  std::vector<Time> times_after(streams_.size(), Time::max());
  std::vector<IndexedFrame*> middle_frames(streams_.size(), nullptr);
  for (auto before = frames.rbegin(); before != frames.rend(); ++before) {
    Time& after = times_after[before->stream];
    IndexedFrame*& middle = middle_frames[before->stream];
    if (middle != nullptr) {
      if (middle->time > after && before->time <= after)
        middle->time = after;
      after = middle->time;
    }
    middle = &*before;
  }
  std::vector<Time> previous(streams_.size(), Time::min());
  for (IndexedFrame& frame : frames)
    frame.time = previous[frame.stream] = std::max(previous[frame.stream], frame.time);
}

void
FrameSource::takeFrames(std::vector<IndexedFrame> frames)
{
  frames_ = std::move(frames);
  for (IndexedFrame& indexed : frames_)
    count(indexed);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
