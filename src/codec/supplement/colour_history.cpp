// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/supplement/colour_history.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

namespace {

/** \brief A voxel is forgotten when this many frames did not have it. */
constexpr std::uint16_t longest_absence = 8;

FineColour
fineColour(const VoxelColour& colour)
{
  return {static_cast<std::uint16_t>(16 * colour.r),
          static_cast<std::uint16_t>(16 * colour.g),
          static_cast<std::uint16_t>(16 * colour.b)};
}

} // namespace

void
ColourHistory::prepare(const VoxelFrame& frame, bool is_i_frame)
{
  // Written by index into enough room, as push_back takes longer than the rest.
  const std::size_t most = frame.size() + (is_i_frame ? 0 : keys_.size());
  next_keys_.resize(most);
  next_records_.resize(most);
  std::size_t next = 0;
  const auto keep_absent = [&](std::size_t old) {
    Record record = records_[old];
    if (++record.absent == longest_absence)
      return;
    next_keys_[next] = keys_[old];
    next_records_[next++] = record;
  };
  const auto add = [&](std::size_t voxel, std::size_t old) {
    const FineColour colour = fineColour(frame.colours[voxel]);
    Record record{colour, 0};
    for (std::size_t channel = 0; old != not_in_list && channel < 3; ++channel)
      record.mean[channel] = static_cast<std::uint16_t>(
          (3 * records_[old].mean[channel] + colour[channel] + 2) / 4);
    next_keys_[next] = frame.keys[voxel];
    next_records_[next++] = record;
    return true;
  };
  if (!is_i_frame)
    walkSideBySide(keys_, frame.keys, keep_absent, add);
  else
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
      add(voxel, not_in_list);
  next_keys_.resize(next);
  next_records_.resize(next);
}

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
