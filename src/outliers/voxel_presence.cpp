// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/voxel_presence.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

/** \brief Of the voxels around one, tracked but not shown: where noise is usual. */
constexpr unsigned int least_seldom_neighbours = 2;
constexpr unsigned int most_seldom_neighbours = 5;

/** \brief One voxel of so many is asked whether the sensor can see it. */
constexpr std::size_t behind_sample_step = 32;

/** \brief A voxel is hidden when the sensor has seen through it for longer, ticks. In the
 * first of frames that follow sooner, most voxels that are empty are of a surface that is
 * in the next voxel there. */
constexpr unsigned int ticks_to_look = 4;

} // namespace

struct VoxelPresence::Persistence {
  std::uint32_t shown_above;  ///< occupancy
  std::uint32_t hidden_below; ///< occupancy
  unsigned int eighths;       ///< of the strength, that it may be empty
};

const VoxelPresence::Persistence VoxelPresence::dense = {
    certain * 3 / 5, certain * 3 / 10, 5};

/** \brief Where not each frame hits all voxels of a surface: they are shown sooner and
 * hidden later. */
const VoxelPresence::Persistence VoxelPresence::sparse = {
    least_frequent, certain / 7, 8};

/** \brief Where few of the shown voxels are hit, as noise is larger than they are. */
const VoxelPresence::Persistence VoxelPresence::noisy = {
    certain * 3 / 5, certain / 64, 32};

VoxelPresence::VoxelPresence(unsigned int frames, bool holds)
: frames_(frames)
, holds_(holds)
, rate_(0x10000 / std::max(frames, 1u))
, least_occupancy_(rate_ * 3 / 4)
{}

void
VoxelPresence::beginFrame(const io::VoxelFrame& frame,
                          const std::optional<std::array<double, 3>>& sensor_position,
                          const DirectionDepths& rays,
                          unsigned int ticks)
{
  ticks_ = ticks;
  fall_ = std::min(ticks * 0x10000 / (FrameTicks::usual * frames_), certain);
  look(frame, sensor_position);
  rays_ = &rays;
  surfaces_.learn(
      frame,
      [this](std::uint64_t key) { return distanceOf(key); },
      hit_shares_.isAnyNoisy());
}

void
VoxelPresence::beginVoxels()
{
  hit_shares_.age();
  until_sample_ = 0;
}

std::size_t
VoxelPresence::framesHeld() const
{
  return std::max(1u, dense.eighths * frames_ * FrameTicks::usual / 8 / ticks_);
}

/** \brief Sets what the sensor sees, if it can be at its position. */
void
VoxelPresence::look(const io::VoxelFrame& frame,
                    const std::optional<std::array<double, 3>>& sensor_position)
{
  has_depths_ = false;
  if (!sensor_position)
    return;
  depths_.assign(frame.keys, frame.grid, *sensor_position);
  std::size_t behind = 0;
  for (std::size_t i = 0; i < frame.size(); i += behind_sample_step)
    behind += depths_.isBehindOthers(frame.keys[i]) ? 1 : 0;
  has_depths_ = 4 * behind_sample_step * behind <= frame.size();
}

bool
VoxelPresence::becomesShown(const MergedBlocks& merged,
                            std::size_t block,
                            unsigned int cell,
                            TrackedVoxel& voxel) const
{
  const std::uint64_t own = cells_near[cell].cells[0];
  const TrackedBlock& here = merged.blocks[block];
  const std::uint64_t key = here.key << io::block_key_bits | cell;
  const std::uint64_t distance = distanceOf(key);
  const bool is_sparse = surfaces_.isSparse(distance);
  const bool is_frequent = voxel.occupancy > (is_sparse ? sparse : dense).shown_above;
  // Of the 26 voxels around it.
  std::uint64_t shown = here.shown & own;
  std::uint64_t seldom = here.seldom & own;
  std::uint64_t hits = here.hits & own;
  if (!is_frequent && shown != 0)
    return false;
  merged.around.visitOthers(key, [&](std::size_t other, std::uint64_t cells) {
    shown |= merged.blocks[other].shown & cells;
    seldom |= merged.blocks[other].seldom & cells;
    hits |= merged.blocks[other].hits & cells;
  });
  if (!is_frequent && shown != 0)
    return false;
  // Where voxels come and go, as at the edges of things, whose pixels are partly of what
  // is behind, it takes one more. With more of them it is a surface that appears.
  const bool is_among_seldom = !is_frequent && !is_sparse &&
                               bitCount(seldom) >= least_seldom_neighbours &&
                               bitCount(seldom) <= most_seldom_neighbours;
  const Support support =
      surfaces_.of(key, distance, bitCount(hits), is_among_seldom ? 1 : 0);
  if (support == Support::Enough && !is_frequent)
    voxel.occupancy = certain;
  return support == Support::Enough || (is_frequent && support == Support::Some);
}

Miss
VoxelPresence::countMiss(const MergedBlocks& merged,
                         std::uint64_t key,
                         bool is_next_to_hit,
                         TrackedVoxel& voxel) const
{
  if (!is_next_to_hit) {
    std::uint64_t hits = 0;
    merged.around.visitOthers(key, [&](std::size_t other, std::uint64_t cells) {
      hits |= merged.blocks[other].hits & cells;
    });
    is_next_to_hit = hits != 0;
  }
  // A surface that is in the next voxel of this frame may be in this one in the next.
  voxel.empty_ticks = static_cast<std::uint8_t>(std::min(
      voxel.empty_ticks + (is_next_to_hit ? FrameTicks::usual : ticks_), 0xffu));
  voxel.occupancy = static_cast<std::uint16_t>(
      voxel.occupancy - ((voxel.occupancy * (is_next_to_hit ? rate_ : fall_)) >> 16));
  const bool has_left = !is_next_to_hit && (!holds_ || !isOfNoisySurface(key));
  if (has_depths_ && voxel.empty_ticks > ticks_to_look &&
      depths_.isEmpty(key, *rays_, has_left)) {
    voxel.occupancy = 0;
    return Miss::Ended;
  }
  if (hasEnded(voxel, dense) && hasEnded(voxel, persistenceOf(key)))
    return Miss::Ended;
  return has_left ? Miss::Left : Miss::Held;
}

bool
VoxelPresence::hasEnded(const TrackedVoxel& voxel, const Persistence& persistence) const
{
  return voxel.occupancy < persistence.hidden_below ||
         8 * voxel.empty_ticks > persistence.eighths * frames_ * FrameTicks::usual;
}

/** \brief True if an empty voxel may be of a surface that the frame has, as the noise
 * there is larger than the voxels. */
bool
VoxelPresence::isOfNoisySurface(std::uint64_t key) const
{
  return hit_shares_.isNoisy(distanceOf(key)) && surfaces_.hasCoarseNeighbour(key);
}

/** \brief How long a shown voxel may be empty. */
const VoxelPresence::Persistence&
VoxelPresence::persistenceOf(std::uint64_t key) const
{
  if (isOfNoisySurface(key))
    return noisy;
  return surfaces_.isSparse(distanceOf(key)) ? sparse : dense;
}

} // namespace pcl_ext::PCL_EXT_ABI
