// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/merged_frame_encoder.h"

#include "bytes/exceptions.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr unsigned int most_bits = 16;

io::FrameStamp
stampOf(Time stamp, const std::string& frame_id)
{
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(stamp).count();
  return {static_cast<std::uint64_t>(std::max<std::int64_t>(0, microseconds)),
          frame_id};
}

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
  number_ = 0;
  return callOrElse(
      [&] {
        encoder_.setTime(stamp);
        return encoder_.encode(onHeldScale(merged, encoder_.isIFrameDue()),
                               stampOf(stamp, frame_id),
                               bytes);
      },
      outOfMemoryStatus<io::CompressionStatus>);
}

io::CompressionStatus
MergedFrameEncoder::encode(const MergedChanges& changes,
                           const Voxels& voxels,
                           Time stamp,
                           const std::string& frame_id,
                           std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  const std::size_t before = std::exchange(number_, 0);
  const bool follow = before != 0 && changes.number == before + 1;
  io::CompressionStatus status = callOrElse(
      [&]() -> io::CompressionStatus {
        const io::FrameStamp frame_stamp = stampOf(stamp, frame_id);
        encoder_.setTime(stamp);
        const bool is_i_frame_due = encoder_.isIFrameDue();
        if (const io::VoxelChanges* held =
                follow ? onHeldScale(changes.voxels) : nullptr)
          if (auto coded = encoder_.encode(*held, frame_stamp, bytes))
            return *coded;
        const io::VoxelFrame& merged =
            changes.voxels.is_from_nothing ? changes.voxels.came : voxels();
        return encoder_.encode(onHeldScale(merged, is_i_frame_due), frame_stamp, bytes);
      },
      outOfMemoryStatus<io::CompressionStatus>);
  if (status.ok())
    number_ = changes.number;
  return status;
}

/** \brief Changes on the scale of the last frame; null if that does not have their
 * intensities. */
const io::VoxelChanges*
MergedFrameEncoder::onHeldScale(const io::VoxelChanges& changes)
{
  const io::IntensityScale& scale = changes.came.intensity_scale;
  const std::vector<std::uint16_t>& numbers = changes.came.intensities;
  if (held_.offset != scale.offset || held_.step != scale.step ||
      std::any_of(numbers.begin(), numbers.end(), [this](std::uint16_t number) {
        return number > held_.maxSymbol();
      }))
    return nullptr;
  if (held_ == scale)
    return &changes;
  changes_ = changes;
  changes_.gone.intensity_scale = held_;
  changes_.came.intensity_scale = held_;
  return &changes_;
}

/** \brief A frame on the scale of the last one, if that has its intensities: another
 * scale would take an I-frame. */
const io::VoxelFrame&
MergedFrameEncoder::onHeldScale(const io::VoxelFrame& merged, bool is_i_frame_due)
{
  constexpr float most_times = 4.0f;
  const io::IntensityScale& scale = merged.intensity_scale;
  const bool has_same_numbers = held_.offset == scale.offset &&
                                held_.step == scale.step && held_.bits >= scale.bits;
  const bool has_coarser_steps = held_.offset == scale.offset &&
                                 held_.step > scale.step &&
                                 held_.step <= most_times * scale.step &&
                                 spansPowerOfTwo(held_) && spansPowerOfTwo(scale);
  if (is_i_frame_due || !(has_same_numbers || has_coarser_steps))
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
