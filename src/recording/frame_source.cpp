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
FrameSource::addFrame(std::size_t stream, Time time, std::uint64_t at)
{
  frames_.push_back({time, stream, 0, at});
  count(frames_.back());
}

void
FrameSource::takeFrames(std::vector<IndexedFrame> frames)
{
  frames_ = std::move(frames);
  for (IndexedFrame& indexed : frames_)
    count(indexed);
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
