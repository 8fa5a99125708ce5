// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/stream_state.h"

#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

void
StreamState::complete(Version1Header& header) const
{
  header.grid = grid;
  header.intensity_scale = intensity_scale;
  header.depth_model = depth_model;
  // A frame of changes has none of it; that of the stream stays.
  if (!header.is_of_changes)
    header.content = content;
  header.fields = fields;
  header.viewpoint = viewpoint;
  header.scan = scan;
  header.layout = layout;
  if (header.placement)
    setPlacement(*header.placement, header.scan);
  if (!header.has_frame_id)
    header.frame_id = frame_id;
}

void
StreamState::prepareChanges(const Version1Header& header, const VoxelFrame& frame)
{
  keeps_frame_ = header.content.hasVoxelsAlone();
  if (!keeps_frame_)
    return;
  if (!changes)
    changes = std::make_unique<changes::ChangeCoder>();
  changes->prepare(frame);
}

void
StreamState::learn(Version1Header& header, std::uint32_t frame_checksum) noexcept
{
  frame_number = header.frame_number;
  checksum = frame_checksum;
  bytes_since_i_frame =
      header.payload_size + (header.is_i_frame ? 0 : bytes_since_i_frame);
  effort = header.effort;
  grid = header.grid;
  intensity_scale = header.intensity_scale;
  depth_model = header.depth_model;
  if (!header.is_of_changes)
    content = header.content;
  fields.swap(header.fields);
  viewpoint = header.viewpoint;
  std::swap(scan, header.scan);
  layout = header.layout;
  frame_id.swap(header.frame_id);
  stamp = stampOf(header);
  const bool has_supplement = content.hasSupplement() && header.voxel_count > 0;
  if (header.is_i_frame && supplement && !has_supplement)
    supplement->reset();
  if (header.is_i_frame && !content.has_scan)
    scans.reset();
  if (header.is_of_changes)
    return;
  if (keeps_frame_)
    changes->learnWhole(header.is_i_frame);
  else if (changes)
    changes->dropLastFrame();
  keeps_frame_ = false;
}

void
StreamState::forgetVoxels() noexcept
{
  coders.clear();
  changes.reset();
  supplement.reset();
  scans.reset();
}

void
StreamState::releaseMemory()
{
  coders.of(effort).releaseMemory();
  if (supplement)
    supplement->releaseMemory();
  if (scans)
    scans->releaseMemory();
  if (changes)
    changes->releaseMemory();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
