// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/frame_sequence.h"

#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief True if the bytes had no frame, so that no frame of the sender is lost. */
bool
wasNoFrame(io::CompressionCode code)
{
  return code == io::CompressionCode::NoFrame ||
         code == io::CompressionCode::EndOfStream;
}

} // namespace

void
FrameSequence::addDecoded(std::uint32_t frame_number, StreamHealth& health)
{
  follow(frame_number, health);
  ++health.frames_decoded;
}

void
FrameSequence::follow(std::uint32_t frame_number, StreamHealth& health)
{
  // A number that is not above the last one means that the sender was restarted.
  if (last_number_ && frame_number > *last_number_) {
    const std::size_t missing = frame_number - *last_number_ - 1;
    if (missing > unnumbered_)
      health.frames_lost += missing - unnumbered_;
  }
  last_number_ = frame_number;
  unnumbered_ = 0;
  failures_in_a_row_ = 0;
  dropped_in_a_row_ = 0;
  health.in_sync = true;
}

bool
FrameSequence::addDropped(StreamHealth& health)
{
  ++health.frames_dropped;
  // A restarted sender has old numbers. If its first frame was lost, all others are
  // dropped until it sends an I-frame.
  const bool wants_i_frame = ++dropped_in_a_row_ % 3 == 0;
  health.i_frame_requests += wants_i_frame ? 1 : 0;
  return wants_i_frame;
}

bool
FrameSequence::addFailed(io::CompressionStatus status,
                         std::optional<std::uint32_t> frame_number,
                         StreamHealth& health)
{
  ++health.frames_failed;
  const io::CompressionCode code = status.code();
  health.last_failure = std::move(status);
  if (frame_number) {
    follow(*frame_number, health);
    return false;
  }
  if (!wasNoFrame(code)) {
    ++unnumbered_;
    health.in_sync = false;
  }
  const bool wants_i_frame = wantsIFrame(code);
  health.i_frame_requests += wants_i_frame ? 1 : 0;
  return wants_i_frame;
}

bool
FrameSequence::wantsIFrame(io::CompressionCode code)
{
  switch (code) {
  case io::CompressionCode::MissingReference:
  case io::CompressionCode::Corrupt:
  case io::CompressionCode::Truncated:
  case io::CompressionCode::InputFailed:
  case io::CompressionCode::OutOfMemory:
    // Repeated, as a request may be lost; not every time, as the I-frame takes a while.
    return failures_in_a_row_++ % 3 == 0;
  default:
    return false;
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
