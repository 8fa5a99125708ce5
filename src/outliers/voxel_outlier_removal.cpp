// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "outliers/density_blocks.h"
#include "outliers/outlier_removal_remarks.h"
#include "outliers/outlier_score.h"
#include "outliers/position_map.h"
#include "outliers/ray_hits.h"
#include "outliers/voxel_densities.h"
#include "voxels/keep_voxels.h"
#include "voxels/memory_rule.h"
#include "voxels/point_voxels.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <variant>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr double rounding = 1e-6; ///< relative, of voxel edges

/** \brief Levels of the coarse voxels by which voxels are judged; 0: by themselves.
 * \param[in] resolution edge of a voxel, metres
 */
unsigned int
levelsOf(double resolution)
{
  unsigned int levels = 0;
  while (std::ldexp(resolution, static_cast<int>(levels)) <
         VoxelOutlierRemoval::min_judged_edge * (1.0 - rounding))
    ++levels;
  return levels;
}

} // namespace

class VoxelOutlierRemoval::Implementation {
public:
  explicit Implementation(const VoxelOutlierRemovalSettings& settings)
  : settings_(settings)
  , settings_status_(checkSettings(settings))
  , densities_(settings.unit)
  {}

  OutlierRemovalStatus
  filter(io::VoxelFrame& frame)
  {
    OutlierRemovalStatus status = check(frame);
    if (!status.ok())
      return status;
    const std::size_t outside_before = frame.points.outside_grid;
    io::setVoxels(frame);
    beginFrame();
    learn(frame);
    const float least =
        std::exp((settings_.min_log_odds - score_.offset) / score_.weight);
    const std::size_t voxels = frame.size();
    status = judgement(frame, densityUnitOf(settings_.unit), densities_.unit());
    if (frame.points.outside_grid > outside_before) // else the decoder has told it
      status = withWarning(status, io::statusOfVoxels(frame));
    status.removed = io::keepVoxels(frame, [&](std::size_t i) {
      return !(evidence_[indexOf(coarse_voxels_[i])] < least);
    });
    endFrame(voxels);
    return status;
  }

  OutlierRemovalStatus
  score(const io::VoxelFrame& frame, std::vector<float>& log_odds)
  {
    OutlierRemovalStatus status = check(frame);
    if (!status.ok()) {
      log_odds.assign(frame.size(), std::numeric_limits<float>::infinity());
      return status;
    }
    beginFrame();
    learn(frame);
    log_odds.resize(frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i)
      log_odds[i] = score_.weight * std::log(evidence_[indexOf(coarse_voxels_[i])]) +
                    score_.offset;
    status = judgement(frame, densityUnitOf(settings_.unit), densities_.unit());
    endFrame(frame.size());
    return status;
  }

  void
  setSensorPosition(const std::array<double, 3>& position)
  {
    if (auto* const rays = std::get_if<RaysUnit>(&settings_.unit)) {
      rays->sensor_position = position;
      settings_status_ = checkSettings(settings_);
    }
  }

  void
  reset()
  {
    positions_ = PositionMap(); // so that learn() starts without a history
    releaseAll();
  }

  std::size_t
  rememberedBlocks() const
  {
    return blocks_.size();
  }

  DensityUnit
  unit() const
  {
    return densities_.unit();
  }

private:
  /** \brief A coarse voxel, as a cell of a block. */
  struct CoarseVoxel {
    std::uint32_t block;
    std::uint8_t cell;
  };

  /** \brief Why a frame cannot be judged, or Ok. */
  OutlierRemovalStatus
  check(const io::VoxelFrame& frame) const
  {
    if (!settings_status_.ok())
      return settings_status_;
    if (!isMadeFor(frame.grid.resolution))
      return unsupportedResolution(frame.grid.resolution);
    if (!densities_.canJudge(frame))
      return noDensities(densityUnitOf(settings_.unit));
    return {};
  }

  std::size_t
  indexOf(const CoarseVoxel& voxel) const
  {
    const std::uint64_t before = (std::uint64_t{1} << voxel.cell) - 1;
    return first_voxels_[voxel.block] + bitCount(masks_[voxel.block] & before);
  }

  /** \brief Begins a frame; drops the history if memory ran out in the previous one. */
  void
  beginFrame()
  {
    if (is_interrupted_)
      reset();
    is_interrupted_ = true;
  }

  void
  endFrame(std::size_t voxels)
  {
    const bool is_too_large = memory_rule_.shouldRelease(voxels + blocks_.size());
    limitHistory();
    if (is_too_large) {
      blocks_.releaseMemory();
      releaseFrame();
    }
    is_interrupted_ = false;
  }

  void
  learn(const io::VoxelFrame& frame)
  {
    if (!positions_.follow(frame.grid, levelsOf(frame.grid.resolution))) {
      blocks_.clear();
      densities_.reset();
    }
    const bool is_same_unit =
        densities_.follow(frame, positions_.first(), positions_.levels());
    if (!is_same_unit || !keepsHistory())
      blocks_.clear();
    else
      blocks_.age();
    if (densities_.unit() == DensityUnit::Rays)
      followRays(frame);
    score_ = scoreOf(
        densities_.unit(),
        std::ldexp(frame.grid.resolution, static_cast<int>(positions_.levels())));
    addVoxels(frame);
    first_voxels_.resize(masks_.size());
    std::uint32_t count = 0;
    for (const std::uint32_t block : frame_blocks_) {
      first_voxels_[block] = count;
      count += bitCount(masks_[block]);
    }
    addSums();
    evidence_.resize(count);
    if (densities_.unit() == DensityUnit::Voxels)
      history_ranks_.assign(blocks_, frame_blocks_, masks_, count);
    // In the order of the frame, in which neighbours are close in memory.
    for (const std::uint32_t block : frame_blocks_)
      computeEvidence(block, evidence_.data() + first_voxels_[block]);
  }

  /** \brief False with Rays, which judge a moving sensor's frames as those of one that
   * stands. */
  bool
  keepsHistory() const
  {
    return densities_.unit() != DensityUnit::Rays &&
           std::visit([](const auto& unit) { return unit.use_history; },
                      settings_.unit);
  }

  void
  followRays(const io::VoxelFrame& frame)
  {
    const unsigned int levels = positions_.levels();
    const LidarRays rays = densities_.sensorRays()
                               ? *densities_.sensorRays()
                               : raysOf(std::get<RaysUnit>(settings_.unit),
                                        frame.grid,
                                        positions_.first());
    ray_hits_ = RayHits(rays,
                        frame.grid.resolution,
                        levels,
                        densities_.hasPoints(frame)
                            ? static_cast<double>(DensityBlocks::most_points)
                            : RayHits::mostWithoutPoints(levels));
  }

  /** \brief Adds the density of a coarse voxel to the blocks.
   * \param[in] sum of what its voxels add to it
   */
  void
  addDensity(std::uint32_t block, unsigned int cell, std::uint32_t sum)
  {
    const std::int16_t density = densities_.density(sum);
    if (densities_.unit() == DensityUnit::Rays)
      blocks_.setPoints(block, cell, density);
    else
      blocks_.add(block, cell, density);
  }

  /** \brief Finds the coarse voxels of the voxels; adds those of one voxel to the
   * blocks, and else the density of the voxel to the sum of its coarse voxel. */
  void
  addVoxels(const io::VoxelFrame& frame)
  {
    const unsigned int levels = positions_.levels();
    masks_.assign(blocks_.size(), 0);
    sums_of_voxels_.clear();
    frame_blocks_.clear();
    coarse_voxels_.resize(frame.size());
    std::uint64_t last_key = std::numeric_limits<std::uint64_t>::max();
    std::uint32_t block = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const io::VoxelPosition at = positions_(io::voxelPosition(frame.keys[i]));
      const io::VoxelPosition coarse = {at.x >> levels, at.y >> levels, at.z >> levels};
      const std::uint64_t key = DensityBlocks::blockKey(coarse.x, coarse.y, coarse.z);
      if (key != last_key) {
        block = blocks_.blockAt(key);
        last_key = key;
        if (block == masks_.size())
          masks_.push_back(0);
        if (masks_[block] == 0)
          frame_blocks_.push_back(block);
      }
      const unsigned int cell = DensityBlocks::cell(coarse.x, coarse.y, coarse.z);
      const std::uint32_t density = densities_(frame, i, at);
      if (levels == 0)
        addDensity(block, cell, density);
      else {
        if (sums_of_voxels_.size() <= block)
          sums_of_voxels_.resize(std::size_t{block} + 1);
        sums_of_voxels_[block][cell] += density;
      }
      masks_[block] |= std::uint64_t{1} << cell;
      coarse_voxels_[i] = {block, static_cast<std::uint8_t>(cell)};
    }
  }

  /** \brief Adds coarse voxels of several voxels, whose sums are complete, to the
   * blocks. */
  void
  addSums()
  {
    if (positions_.levels() == 0)
      return;
    for (const std::uint32_t block : frame_blocks_)
      for (std::uint64_t cells = masks_[block]; cells != 0; cells &= cells - 1) {
        const unsigned int cell = lowestBit(cells);
        addDensity(block, cell, sums_of_voxels_[block][cell]);
      }
  }

  /** \brief Computes the evidence of the cells of a block.
   * \param[out] evidence of each occupied cell, in their order
   */
  void
  computeEvidence(std::uint32_t block, float* evidence)
  {
    const DensityUnit unit = densities_.unit();
    blocks_.collect(block, masks_[block], window_);
    if (unit == DensityUnit::Points)
      sumNeighbourhoods<true>(window_, masks_[block], sums_);
    else
      sumNeighbourhoods<false>(window_, masks_[block], sums_);
    for (std::uint64_t cells = masks_[block]; cells != 0; cells &= cells - 1) {
      const unsigned int cell = lowestBit(cells);
      const NeighbourhoodSums& sums = sums_[cell];
      if (unit == DensityUnit::Rays) {
        const std::int32_t own = blocks_.field(block, cell);
        *evidence++ =
            ray_hits_.evidence(blocks_.position(block, cell), own, sums.all - own);
        continue;
      }
      // f is in quarters of 255ths of a face or a coarse voxel.
      const float one =
          unit == DensityUnit::Points
              ? static_cast<float>(sums.all) / static_cast<float>(sums.occupied)
              : 4.0f * 255.0f;
      *evidence = evidenceOf(sums, one, score_.least_shell);
      if (unit == DensityUnit::Voxels)
        *evidence *= history_ranks_.factor(blocks_, block, cell);
      ++evidence;
    }
  }

  /** \brief Enforces the limit of blocks between frames. */
  void
  limitHistory()
  {
    if (frame_blocks_.size() > settings_.max_blocks) {
      releaseAll();
      return;
    }
    if (!keepsHistory()) {
      blocks_.clear();
      return;
    }
    if (blocks_.size() <= settings_.max_blocks)
      return;
    std::sort(frame_blocks_.begin(), frame_blocks_.end());
    blocks_.keepOnly(frame_blocks_);
  }

  /** \brief Drops all blocks and releases the memory. */
  void
  releaseAll()
  {
    blocks_ = DensityBlocks();
    releaseFrame();
  }

  void
  releaseFrame()
  {
    std::vector<CoarseVoxel>().swap(coarse_voxels_);
    std::vector<std::uint64_t>().swap(masks_);
    std::vector<std::uint32_t>().swap(frame_blocks_);
    std::vector<std::uint32_t>().swap(first_voxels_);
    std::vector<float>().swap(evidence_);
    std::vector<std::array<std::uint32_t, 64>>().swap(sums_of_voxels_);
  }

  VoxelOutlierRemovalSettings settings_;
  OutlierRemovalStatus settings_status_;
  VoxelDensities densities_;
  PositionMap positions_;
  DensityBlocks blocks_;
  RayHits ray_hits_; // with Rays

  // Of the current frame; members so that their memory is reused.
  Score score_{};
  std::vector<CoarseVoxel> coarse_voxels_;  // of each voxel
  std::vector<std::uint64_t> masks_;        // of each block, occupied cells
  std::vector<std::uint32_t> frame_blocks_; // blocks with voxels
  std::vector<std::uint32_t> first_voxels_; // of each block, index into evidence_
  std::vector<float> evidence_;             // of each coarse voxel, by block and cell
  /** \brief Sums of the densities of the voxels in each coarse voxel, if it has
   * several. */
  std::vector<std::array<std::uint32_t, 64>> sums_of_voxels_;
  HistoryRanks history_ranks_; // with Voxels
  DensityWindow window_;
  std::array<NeighbourhoodSums, 64> sums_;
  bool is_interrupted_ = false;
  io::MemoryRule memory_rule_;
};

VoxelOutlierRemoval::VoxelOutlierRemoval(const VoxelOutlierRemovalSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

bool
VoxelOutlierRemoval::isMadeFor(double resolution)
{
  return resolution >= min_resolution * (1.0 - rounding) &&
         resolution <= max_resolution * (1.0 + rounding);
}

VoxelOutlierRemoval::~VoxelOutlierRemoval() = default;
VoxelOutlierRemoval::VoxelOutlierRemoval(VoxelOutlierRemoval&&) noexcept = default;
VoxelOutlierRemoval&
VoxelOutlierRemoval::operator=(VoxelOutlierRemoval&&) noexcept = default;

OutlierRemovalStatus
VoxelOutlierRemoval::filter(io::VoxelFrame& frame)
{
  return implementation_->filter(frame);
}

OutlierRemovalStatus
VoxelOutlierRemoval::score(const io::VoxelFrame& frame, std::vector<float>& log_odds)
{
  return implementation_->score(frame, log_odds);
}

void
VoxelOutlierRemoval::setSensorPosition(const std::array<double, 3>& position)
{
  implementation_->setSensorPosition(position);
}

void
VoxelOutlierRemoval::reset()
{
  implementation_->reset();
}

DensityUnit
VoxelOutlierRemoval::unit() const
{
  return implementation_->unit();
}

std::size_t
VoxelOutlierRemoval::rememberedBlocks() const
{
  return implementation_->rememberedBlocks();
}

} // namespace pcl_ext::PCL_EXT_ABI
