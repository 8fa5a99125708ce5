/** \file
 * \brief Filters of frames with regions: one filter for the voxels of each edge.
 */
#pragma once

#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "outliers/level_frames.h"

#include <array>
#include <optional>
#include <vector>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief Judges the voxels of each edge by a VoxelOutlierRemoval of their own. Voxels
 * of an edge that it is not made for are not judged. */
class RegionOutlierRemoval {
public:
  explicit RegionOutlierRemoval(const VoxelOutlierRemovalSettings& settings)
  : settings_(settings)
  {
    settings_.max_blocks /= io::most_region_levels + 1; // in all of them together
  }

  /** \brief As VoxelOutlierRemoval::score(), for frames with regions. */
  OutlierRemovalStatus
  score(const io::VoxelFrame& frame, std::vector<float>& log_odds);

  /** \brief As VoxelOutlierRemoval::filter(), likewise. */
  OutlierRemovalStatus
  filter(io::VoxelFrame& frame);

  void
  setSensorPosition(const std::array<double, 3>& position);

  std::size_t
  rememberedBlocks() const;

  /** \brief As VoxelOutlierRemoval::unit(), of the finest voxels that were judged. */
  DensityUnit
  unit() const;

private:
  VoxelOutlierRemovalSettings settings_;
  std::vector<VoxelOutlierRemoval> removals_; // by levels
  LevelFrames frames_;
  std::vector<std::vector<float>> log_odds_; // of the frame of each number of levels
  std::vector<float> own_log_odds_;
};

/** \brief Filters the voxels of each edge by a TemporalVoxelFilter of their own. */
class RegionTemporalFilter {
public:
  /** \brief Parameters are those of TemporalVoxelFilter. */
  RegionTemporalFilter(unsigned int frames, bool holds)
  : frame_count_(frames), holds_(holds)
  {}

  /** \brief As TemporalVoxelFilter::filter(), for frames with regions.
   * \param[in] rays that end where the frame has no points, metres; null: not known
   */
  TemporalFilterStatus
  filter(io::VoxelFrame& frame, const SensorView& view, const DirectionDepths* rays);

  std::size_t
  rememberedVoxels() const;

private:
  unsigned int frame_count_;
  bool holds_;
  std::vector<TemporalVoxelFilter> filters_; // by levels
  LevelFrames frames_;
};

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
