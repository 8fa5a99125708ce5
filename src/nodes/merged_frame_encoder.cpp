// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/merged_frame_encoder.h"

#include "bytes/exceptions.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr unsigned int most_bits = 16;

/** \brief Whether a scale has no common step of its intensities, but spans them: from 0
 * to a power of two. */
bool
spansPowerOfTwo(const io::IntensityScale& scale)
{
  int exponent = 0;
  const double fraction =
      std::frexp(static_cast<double>(scale.step) * scale.maxSymbol(), &exponent);
  return scale.bits == most_bits && std::abs(fraction - 0.5) < 1e-6;
}

} // namespace

MergedFrameEncoder::MergedFrameEncoder(const io::StreamSettings& stream)
: encoder_(io::StreamFormat::Version1,
           stream.i_frame_rate,
           stream.effort,
           stream.first_frame_number,
           stream.i_frame_every)
{}

io::CompressionStatus
MergedFrameEncoder::encode(const io::VoxelFrame& merged,
                           Time stamp,
                           const std::string& frame_id,
                           std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(stamp).count();
  return callOrElse(
      [&] {
        encoder_.setTime(stamp);
        return encoder_.encode(
            onHeldScale(merged),
            io::FrameStamp{
                static_cast<std::uint64_t>(std::max<std::int64_t>(0, microseconds)),
                frame_id},
            bytes);
      },
      outOfMemoryStatus<io::CompressionStatus>);
}

/** \brief A frame on the scale of the last one, if that has its intensities: another
 * scale would take an I-frame. */
const io::VoxelFrame&
MergedFrameEncoder::onHeldScale(const io::VoxelFrame& merged)
{
  constexpr float most_times = 4.0f;
  const io::IntensityScale& scale = merged.intensity_scale;
  const bool has_same_numbers = held_.offset == scale.offset &&
                                held_.step == scale.step && held_.bits >= scale.bits;
  const bool has_coarser_steps = held_.offset == scale.offset &&
                                 held_.step > scale.step &&
                                 held_.step <= most_times * scale.step &&
                                 spansPowerOfTwo(held_) && spansPowerOfTwo(scale);
  if (encoder_.isIFrameDue() || !(has_same_numbers || has_coarser_steps))
    held_ = scale;
  if (held_ == scale)
    return merged;
  frame_ = merged;
  frame_.intensity_scale = held_;
  if (has_coarser_steps) {
    const double ratio =
        static_cast<double>(scale.step) / static_cast<double>(held_.step);
    for (std::uint16_t& number : frame_.intensities)
      number = static_cast<std::uint16_t>(static_cast<double>(number) * ratio + 0.5);
  }
  return frame_;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
