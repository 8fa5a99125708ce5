// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
// Which kind the next frame has to be or should be; version1_encoder.cpp codes it.
#include "codec/frame_limits.h"
#include "stream/version1_encoder.h"
#include "voxels/voxel_block.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

bool
haveSameFields(const std::vector<FrameField>& fields,
               const std::vector<FieldDescription>& descriptions)
{
  return std::equal(fields.begin(),
                    fields.end(),
                    descriptions.begin(),
                    descriptions.end(),
                    [](const FieldDescription& one, const FieldDescription& other) {
                      return one == other;
                    });
}

bool
areSame(const std::shared_ptr<const MessageLayout>& one,
        const std::shared_ptr<const MessageLayout>& other)
{
  return one == other || (one && other && *one == *other);
}

} // namespace

void
Version1Encoder::addReasons(const VoxelFrame& frame,
                            const std::optional<FrameStamp>& stamp,
                            IFrameReasons& reasons)
{
  reasons.has_other_content = hasOtherContent(frame);
  reasons.has_far_stamp = hasFarStamp(stamp);
  if (reasons.any())
    return;
  // That of a moving sensor.
  reasons.has_long_history = hasLongHistory(frame.size(), countBlocks(frame.keys));
  reasons.repeats_fine_voxels =
      !reasons.has_long_history && state_.content.refinement_levels > 0 &&
      !hasFewChanges(frame) && refinement_choice_.endsWith(frame);
}

bool
Version1Encoder::hasLongHistory(std::size_t voxels, std::size_t blocks)
{
  return coder().trackedVoxels() > maxTracked(voxels) ||
         coder().trackedBlocks() > maxTracked(blocks) ||
         !fitsHistory(coder().trackedBlocks(), voxels);
}

void
Version1Encoder::addReasons(const scan::ScanFrame& scan,
                            const std::optional<FrameStamp>& stamp,
                            IFrameReasons& reasons) const
{
  reasons.has_other_content = !state_.content.has_scan || scan.grid != state_.grid ||
                              scan.intensity_scale != state_.intensity_scale ||
                              scan.colour_bits != state_.content.colour_bits ||
                              !haveSameFields(scan.fields, state_.fields) ||
                              !areSame(scan.layout, state_.layout) ||
                              !scan.mayFollow(state_.scan);
  reasons.has_far_stamp = hasFarStamp(stamp);
}

bool
Version1Encoder::hasOtherContent(const VoxelFrame& frame) const
{
  return state_.content.has_scan || frame.grid != state_.grid ||
         frame.intensity_scale != state_.intensity_scale ||
         frame.depth_model.has_value() != had_depth_model_ ||
         frame.colour_bits != state_.content.colour_bits ||
         frame.has_point_counts != state_.content.has_point_counts ||
         !haveSameFields(frame.fields, state_.fields) ||
         !areSame(frame.layout, state_.layout);
}

/** \brief Whether the change of a stamp takes more bytes than the stamp. */
bool
Version1Encoder::hasFarStamp(const std::optional<FrameStamp>& stamp) const
{
  constexpr std::int64_t far = std::int64_t{1} << 27;
  const std::int64_t change = stamp ? state_.stampChange(stamp->stamp) : 0;
  return change >= far || change < -far;
}

bool
Version1Encoder::hasFewChanges(const VoxelFrame& frame)
{
  return state_.mayBeFollowedByChanges() &&
         mayHaveFewChanges(
             frame.size(), state_.changes->blockCount(), frame.depth_model) &&
         !state_.changes->hasOtherVoxels(frame) &&
         areFew(state_.changes->countChanges(work_, frame), frame.size());
}

/** \brief Whether a frame of so many voxels may be one of changes.
 * \param[in] blocks_before of the last frame */
bool
Version1Encoder::mayHaveFewChanges(std::size_t voxels,
                                   std::size_t blocks_before,
                                   const std::optional<DepthModel>& model) const
{
  // Smaller ones take few bytes and little time anyway.
  constexpr std::size_t least_voxels = 1024;
  return voxels >= least_voxels &&
         (!state_.depth_model || model == state_.depth_model) &&
         blocks_before <= maxTracked(voxels);
}

bool
Version1Encoder::areFew(std::size_t changes, std::size_t voxels) const
{
  // To begin with them takes fewer than to go on, as they leave the history behind.
  // The other efforts code many changes in fewer bytes with their history.
  const std::size_t share =
      (was_of_changes_ ? 4 : 8) * (effort_ == Effort::Fast ? 1 : 2);
  return changes <= voxels / share;
}

bool
Version1Encoder::takeChanges(const VoxelChanges& changes,
                             const std::optional<FrameStamp>& stamp)
{
  if (hasOtherContent(changes.came) || hasFarStamp(stamp) ||
      !state_.mayBeFollowedByChanges())
    return false;
  const std::size_t blocks_before = state_.changes->blockCount(); // less, once taken
  const auto taken = state_.changes->takeChanges(work_, changes);
  if (!taken)
    return false;
  taken_ = *taken;
  return taken_.voxels <= DecoderLimits::most_voxels && taken_.blocks <= most_blocks &&
         !hasLongHistory(taken_.voxels, taken_.blocks) &&
         mayHaveFewChanges(taken_.voxels, blocks_before, changes.came.depth_model) &&
         areFew(taken_.changes, taken_.voxels);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
