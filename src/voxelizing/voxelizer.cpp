// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/voxelizer.h"

#include "voxelizing/intensity_quantiser.h"
#include "voxelizing/parallel_collector.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/voxel_locator.h"
#include "voxelizing/voxel_sums.h"
#include "voxels/grid_fit.h"
#include "voxels/memory_rule.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

class Voxelizer::Implementation {
public:
  Implementation(const EncoderSettings& settings, IntensityUnit unit)
  : quantiser_(settings, unit)
  , has_intensities_(unit != IntensityUnit::None ||
                     settings.format == StreamFormat::Published)
  , colour_bits_(settings.format == StreamFormat::Published ? 0 : settings.colour_bits)
  , leaves_out_colours_(colour_bits_ != settings.colour_bits)
  , keeps_points_(settings.keepsPoints())
  , is_native_(unit == IntensityUnit::Native)
  , is_mean_(settings.aggregation == Aggregation::Mean ||
             (settings.aggregation == Aggregation::Automatic && is_native_ &&
              settings.format != StreamFormat::Published))
  , has_fixed_grid_(settings.bounding_box.has_value())
  , has_fixed_origin_(has_fixed_grid_ || settings.origin ||
                      settings.format == StreamFormat::Published)
  , has_grid_(has_fixed_grid_)
  , locator_(settings)
  , collector_(std::max(settings.threads, 1u))
  {}

  VoxelizationStatistics
  voxelize(PointBatches& points, bool may_refit, VoxelFrame& frame)
  {
    if (is_interrupted_ || memory_rule_.shouldRelease(points.size())) {
      releaseMemory();
      frame.keys.shrink_to_fit();
      frame.intensities.shrink_to_fit();
      frame.colours.shrink_to_fit();
      frame.point_counts.shrink_to_fit();
      for (FrameField& field : frame.fields)
        field.numbers.shrink_to_fit();
    }
    // If memory runs out within the call, the next one starts with empty containers.
    is_interrupted_ = true;
    const VoxelizationStatistics statistics = voxelizeCloud(points, may_refit, frame);
    is_interrupted_ = false;
    // That of a large cloud would be there while the frame is encoded.
    if (points.size() > most_points_kept)
      releaseMemory();
    return statistics;
  }

private:
  VoxelizationStatistics
  voxelizeCloud(PointBatches& points, bool may_refit, VoxelFrame& frame)
  {
    if (!has_fixed_grid_ && (!has_grid_ || may_refit))
      adaptGrid(points, may_refit);
    if (may_refit) {
      points_off_lattice_ = 0;
      collector_.forgetRounding();
    }
    VoxelizationStatistics statistics;
    voxelizeOnGrid(points, may_refit, frame, statistics);
    // Points that no origin so far had on its lattice are not looked at again.
    if (!has_fixed_origin_ && statistics.points_outside_grid > points_off_lattice_) {
      if (moveOrigin(points, may_refit))
        voxelizeOnGrid(points, may_refit, frame, statistics);
      points_off_lattice_ = statistics.points_outside_grid;
    }
    statistics.resolution = frame.grid.resolution;
    statistics.voxels = frame.size();
    if (leaves_out_colours_ && points.hasColours())
      statistics.colours_left_out = statistics.points;
    return statistics;
  }

  void
  voxelizeOnGrid(PointBatches& points,
                 bool may_refit,
                 VoxelFrame& frame,
                 VoxelizationStatistics& statistics)
  {
    bool is_sparse = points_per_block_ < min_points_per_block;
    // At most three passes: the adapted grid has all usable points on it.
    for (;;) {
      const CollectionResult result = collect(points, is_sparse, frame);
      if (result == CollectionResult::AllPoints)
        break;
      collector_.reset();
      if (result == CollectionResult::TooSparse)
        is_sparse = true;
      else
        adaptGrid(points, may_refit);
    }
    statistics = collector_.statistics();
    if (const std::size_t blocks = collector_.occupiedBlocks(); blocks > 0)
      points_per_block_ = statistics.points_used / blocks;
    writeFrame(points, may_refit, frame, statistics);
  }

  CollectionResult
  collect(PointBatches& points, bool is_sparse, VoxelFrame& frame)
  {
    return collector_.collect(
        points, locator_, fieldsOf(points), is_sparse, frame.keys, sums_);
  }

  /** \brief Moves the origin to where more points are on its lattice, if there is such
   * a one. */
  bool
  moveOrigin(PointBatches& points, bool is_i_frame_due)
  {
    std::array<double, 3> origin{};
    if (!locator_.findBetterOrigin(points, is_i_frame_due, origin))
      return false;
    VoxelGrid grid;
    grid.resolution = locator_.grid().resolution;
    grid.origin = origin;
    locator_.setGrid(grid);
    collector_.reset();
    has_grid_ = false;
    adaptGrid(points, false);
    return true;
  }

  /** \brief Releases memory of earlier clouds. */
  void
  releaseMemory()
  {
    collector_.releaseMemory();
    quantiser_.releaseMemory();
    sums_ = VoxelSums();
  }

  /** \brief The memory of larger clouds, 40 bytes a point, is released: to allocate it
   * again takes little of the time of encoding them. */
  static constexpr std::size_t most_points_kept = std::size_t{1} << 22;

  /** \brief With fewer points per block of voxels SortedVoxels is faster than
   * PointBlocks. */
  static constexpr std::size_t min_points_per_block = 8;

  CollectedFields
  fieldsOf(const PointBatches& points) const
  {
    CollectedFields fields;
    fields.intensities = has_intensities_ && points.hasIntensities();
    fields.colours = colour_bits_ > 0 && points.hasColours();
    fields.step = is_native_;
    return fields;
  }

  void
  writeFrame(const PointBatches& points,
             bool may_refit,
             VoxelFrame& frame,
             VoxelizationStatistics& statistics)
  {
    frame.grid = locator_.grid();
    statistics.intensities_out_of_range =
        quantise(points, may_refit, frame, statistics.intensities_vanished);
    quantiseColours(points, frame);
    frame.has_point_counts = keeps_points_;
    frame.point_counts.clear();
    if (keeps_points_)
      frame.point_counts.assign(sums_.counts.begin(), sums_.counts.end());
  }

  std::size_t
  quantise(const PointBatches& points,
           bool may_refit,
           VoxelFrame& frame,
           std::size_t& vanished)
  {
    vanished = 0;
    if (!has_intensities_) {
      frame.intensity_scale = IntensityScale();
      frame.intensity_scale.bits = 0;
      frame.intensities.clear();
      return 0;
    }
    if (!points.hasIntensities()) { // all are 1
      if (!is_mean_ && quantiser_.takesCounts(sums_.counts, may_refit))
        return quantiser_.quantiseCounts(sums_.counts, frame);
      sums_.intensities.assign(sums_.counts.begin(), sums_.counts.end());
    }
    for (std::size_t i = 0; is_mean_ && i < frame.size(); ++i)
      sums_.intensities[i] /= static_cast<double>(sums_.counts[i]);
    return quantiser_.quantise(
        sums_.intensities, collector_.step(), may_refit, frame, vanished);
  }

  void
  adaptGrid(PointBatches& points, bool may_refit)
  {
    LatticeRange range;
    if (!locator_.measureRange(points, range))
      return;
    const VoxelGrid grid = io::adaptGrid(locator_.grid(), has_grid_, may_refit, range);
    has_grid_ = true;
    if (grid == locator_.grid())
      return;
    locator_.setGrid(grid);
    collector_.reset();
  }

  /** \brief Sets the mean colour of each voxel, in 2^colour_bits - 1 steps from 0 to
   * 255. */
  void
  quantiseColours(const PointBatches& points, VoxelFrame& frame) const
  {
    frame.colours.clear();
    frame.colour_bits = fieldsOf(points).colours ? colour_bits_ : 0;
    if (frame.colour_bits == 0)
      return;
    const std::uint64_t highest = (1u << colour_bits_) - 1;
    frame.colours.resize(frame.size());
    for (std::size_t voxel = 0; voxel < frame.size(); ++voxel) {
      // floor(number / (2 * full_scale)) by one division for three channels. Rounding
      // errors are below 2^-44, and a quotient that is no whole number is further than
      // 2^-41 from the next one, as there are fewer than 2^32 points.
      const auto full_scale = std::int64_t{255} * sums_.counts[voxel];
      const double inverse = 1.0 / static_cast<double>(2 * full_scale);
      const auto quantised = [&](std::uint64_t channel) {
        const auto number =
            static_cast<std::int64_t>(2 * channel * highest) + full_scale;
        return static_cast<std::uint8_t>(
            static_cast<std::int32_t>(static_cast<double>(number) * inverse + 0x1p-43));
      };
      const ColourSum& sum = sums_.colours[voxel];
      frame.colours[voxel] = {quantised(sum.r), quantised(sum.g), quantised(sum.b)};
    }
  }

  IntensityQuantiser quantiser_;
  bool has_intensities_;
  unsigned int colour_bits_;
  bool leaves_out_colours_; // the format has no field for them
  bool keeps_points_;
  bool is_native_;
  bool is_mean_;
  bool has_fixed_grid_;
  bool has_fixed_origin_;
  std::size_t points_off_lattice_ = 0; // in the worst cloud since the last refit
  bool has_grid_;
  VoxelLocator locator_;
  ParallelCollector collector_;
  std::size_t points_per_block_ = min_points_per_block; // of the last cloud

  // Of the current cloud; members so that their memory is reused.
  VoxelSums sums_;
  bool is_interrupted_ = false;
  MemoryRule memory_rule_;
};

Voxelizer::Voxelizer(const EncoderSettings& settings, IntensityUnit unit)
: implementation_(std::make_unique<Implementation>(settings, unit))
{}

Voxelizer::~Voxelizer() = default;
Voxelizer::Voxelizer(Voxelizer&&) noexcept = default;
Voxelizer&
Voxelizer::operator=(Voxelizer&&) noexcept = default;

VoxelizationStatistics
Voxelizer::voxelize(const PointView& points, bool may_refit, VoxelFrame& frame)
{
  SingleBatch batch(points);
  return implementation_->voxelize(batch, may_refit, frame);
}

VoxelizationStatistics
Voxelizer::voxelize(PointBatches& points, bool may_refit, VoxelFrame& frame)
{
  return implementation_->voxelize(points, may_refit, frame);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
