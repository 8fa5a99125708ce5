#include <pcl_ext/compression/voxelizer.h>

#include "voxelizing/common_step.h"
#include "voxelizing/intensity_quantiser.h"
#include "voxelizing/place_finder.h"
#include "voxelizing/point_blocks.h"
#include "voxelizing/sorted_voxels.h"
#include "voxels/grid_fit.h"
#include "voxels/memory_rule.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace pcl_ext {
namespace io {

class Voxelizer::Implementation {
public:
  Implementation(const IntensityCompressionSettings& settings, IntensityUnit unit)
  : quantiser_(settings, unit)
  , has_intensities_(unit != IntensityUnit::None ||
                     settings.format == StreamFormat::Published)
  , colour_bits_(settings.format == StreamFormat::Published ? 0 : settings.colour_bits)
  , leaves_out_colours_(colour_bits_ != settings.colour_bits)
  , keeps_points_(settings.keep_points)
  , is_native_(unit == IntensityUnit::Native)
  , is_mean_(settings.aggregation == Aggregation::Mean ||
             (settings.aggregation == Aggregation::Automatic && is_native_ &&
              settings.format != StreamFormat::Published))
  , has_fixed_grid_(settings.bounding_box.has_value())
  , has_fixed_origin_(has_fixed_grid_ || settings.origin ||
                      settings.format == StreamFormat::Published)
  , has_grid_(has_fixed_grid_)
  , finder_(settings)
  {}

  VoxelizationStatistics
  voxelize(const PointView& points, bool may_refit, VoxelFrame& frame)
  {
    if (is_interrupted_ || memory_rule_.shouldRelease(points.count)) {
      releaseMemory();
      frame.keys.shrink_to_fit();
      frame.intensities.shrink_to_fit();
      frame.colours.shrink_to_fit();
      frame.point_counts.shrink_to_fit();
    }
    // If memory runs out within the call, the next one starts with empty containers.
    is_interrupted_ = true;
    const VoxelizationStatistics statistics = voxelizeCloud(points, may_refit, frame);
    is_interrupted_ = false;
    return statistics;
  }

private:
  VoxelizationStatistics
  voxelizeCloud(const PointView& points, bool may_refit, VoxelFrame& frame)
  {
    if (!has_fixed_grid_ && (!has_grid_ || may_refit))
      adaptGrid(points, may_refit);
    if (may_refit)
      points_off_lattice_ = 0;
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
    statistics.points_behind_sensor = points.count_behind_sensor;
    if (leaves_out_colours_ && points.colours != nullptr)
      statistics.colours_left_out = points.count;
    return statistics;
  }

  void
  voxelizeOnGrid(const PointView& points,
                 bool may_refit,
                 VoxelFrame& frame,
                 VoxelizationStatistics& statistics)
  {
    // The first cloud is sorted, as it may be sparse.
    if (points_per_block_ < min_points_per_block ||
        !voxelizeWith(blocks_, points, may_refit, frame, statistics))
      voxelizeWith(sorted_voxels_, points, may_refit, frame, statistics);
  }

  /** \brief Moves the origin to where more points are on its lattice, if there is such a
   * place. */
  bool
  moveOrigin(const PointView& points, bool is_i_frame_due)
  {
    std::array<double, 3> origin{};
    if (!finder_.findBetterOrigin(points, is_i_frame_due, origin))
      return false;
    VoxelGrid grid;
    grid.resolution = finder_.grid().resolution;
    grid.anchor = origin;
    finder_.setGrid(grid);
    blocks_.reset();
    has_grid_ = false;
    adaptGrid(points, false);
    return true;
  }

  /** \brief Releases memory of earlier clouds. */
  void
  releaseMemory()
  {
    blocks_ = PointBlocks();
    sorted_voxels_ = SortedVoxels();
    runs_ = std::vector<Run>();
    voxel_counts_ = std::vector<std::uint32_t>();
    voxel_values_ = std::vector<double>();
  }

  /** \brief Consecutive points in the same voxel. */
  struct Run {
    std::size_t added =
        static_cast<std::size_t>(-1); ///< handle of the points; -1: none
    double sum = 0.0;                 ///< of their intensities
  };

  /** \brief With fewer points per block of voxels SortedVoxels is faster than PointBlocks. */
  static constexpr std::size_t min_points_per_block = 4;

  enum class Collected { AllPoints, TooSparse, PointOutsideGrid };

  /** \brief Voxelizes a cloud; returns false if it is too sparse for VoxelsT. */
  template <typename VoxelsT>
  bool
  voxelizeWith(VoxelsT& voxels,
               const PointView& points,
               bool may_refit,
               VoxelFrame& frame,
               VoxelizationStatistics& statistics)
  {
    Collected collected = collect(points, voxels, statistics);
    if (collected == Collected::PointOutsideGrid) {
      adaptGrid(points, may_refit);
      collected = collect(points, voxels, statistics);
    }
    if (collected == Collected::TooSparse) {
      blocks_.reset();
      return false;
    }
    voxels.writeVoxels(frame.keys, voxel_counts_);
    if (!frame.keys.empty())
      points_per_block_ = statistics.points_used / voxels.occupiedBlocks();
    frame.grid = finder_.grid();
    statistics.intensities_out_of_range =
        quantise(voxels, points, may_refit, frame, statistics.intensities_vanished);
    quantiseColours(voxels, points, frame);
    frame.has_point_counts = keeps_points_;
    frame.point_counts.clear();
    if (keeps_points_)
      frame.point_counts.assign(voxel_counts_.begin(), voxel_counts_.end());
    return true;
  }

  template <typename VoxelsT>
  std::size_t
  quantise(const VoxelsT& voxels,
           const PointView& points,
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
    if (points.intensities != nullptr)
      sumIntensities(voxels, frame.size());
    else if (!is_mean_ && quantiser_.takesCounts())
      return quantiser_.quantiseCounts(voxel_counts_, frame);
    else if (is_mean_) // all intensities are 1
      voxel_values_.assign(frame.size(), 1.0);
    else
      voxel_values_.assign(voxel_counts_.begin(), voxel_counts_.end());
    return quantiser_.quantise(voxel_values_, step_, may_refit, frame, vanished);
  }

  /** \brief Adds all usable points. */
  template <typename VoxelsT>
  Collected
  collect(const PointView& points, VoxelsT& voxels, VoxelizationStatistics& statistics)
  {
    statistics = VoxelizationStatistics();
    statistics.points = points.count;
    const bool has_runs = has_intensities_ && points.intensities != nullptr;
    voxels.clear(points.count, has_runs, hasColours(points));
    startRuns(points);
    std::array<std::size_t, PlacedPoints::capacity> added;
    for (std::size_t i = 0; i < points.count; i += PlacedPoints::capacity) {
      if (!finder_.find(points, i, placed_, statistics))
        return Collected::PointOutsideGrid;
      voxels.add(placed_, added.data());
      if (voxels.areTooSparse(i))
        return Collected::TooSparse;
      if (has_intensities_ && points.intensities != nullptr)
        addRuns(points, added.data(), statistics);
      if (hasColours(points))
        addColours(points, added.data(), voxels);
    }
    statistics.points_used = points.count - statistics.points_not_finite -
                             statistics.points_outside_box -
                             statistics.points_outside_grid;
    return Collected::AllPoints;
  }

  void
  adaptGrid(const PointView& points, bool may_refit)
  {
    LatticeRange range;
    if (!finder_.measureRange(points, range))
      return;
    VoxelGrid grid = finder_.grid();
    // One level more than required is kept as a reserve. Two are due to an outlier in a
    // previous cloud.
    const bool is_far_too_large = may_refit && requiredDepth(range) + 2 <= grid.depth;
    if (!has_grid_ || is_far_too_large)
      grid = fitGrid(grid, range);
    else if (!containsRange(grid, range))
      grid = fitGrid(grid, unite(rangeOf(grid), range));
    has_grid_ = true;
    if (grid == finder_.grid())
      return;
    finder_.setGrid(grid);
    blocks_.reset();
  }

  void
  startRuns(const PointView& points)
  {
    step_ = CommonStep();
    run_ = Run();
    last_run_ = 0;
    // Not made smaller, as growing again would initialise all elements.
    if (has_intensities_ && points.intensities != nullptr &&
        runs_.size() <= points.count)
      runs_.resize(points.count + 1);
  }

  bool
  hasColours(const PointView& points) const
  {
    return colour_bits_ > 0 && points.colours != nullptr;
  }

  template <typename VoxelsT>
  void
  addColours(const PointView& points, const std::size_t* added, VoxelsT& voxels)
  {
    const auto* const bytes = static_cast<const unsigned char*>(points.colours);
    std::array<std::uint32_t, PlacedPoints::capacity> colours;
    for (std::size_t i = 0; i < placed_.count; ++i)
      std::memcpy(&colours[i],
                  bytes + placed_.points[i] * points.colour_stride,
                  sizeof(colours[i]));
    voxels.addColours(colours.data(), added, placed_.count);
  }

  /** \brief Sets the mean colour of each voxel, in 2^colour_bits - 1 steps from 0 to 255. */
  template <typename VoxelsT>
  void
  quantiseColours(VoxelsT& voxels, const PointView& points, VoxelFrame& frame)
  {
    frame.colours.clear();
    frame.colour_bits = hasColours(points) ? colour_bits_ : 0;
    if (frame.colour_bits == 0)
      return;
    const std::uint64_t highest = (1u << colour_bits_) - 1;
    frame.colours.resize(frame.size());
    std::size_t voxel = 0;
    voxels.visitColourSums([&](const ColourSum& sum) {
      // floor(number / (2 * full_scale)) by one division for three channels. Rounding
      // errors are below 2^-44, and a quotient that is no whole number is further than
      // 2^-41 from the next one, as there are fewer than 2^32 points.
      const auto full_scale = std::int64_t{255} * voxel_counts_[voxel];
      const double inverse = 1.0 / static_cast<double>(2 * full_scale);
      const auto quantised = [&](std::uint64_t channel) {
        const auto number =
            static_cast<std::int64_t>(2 * channel * highest) + full_scale;
        return static_cast<std::uint8_t>(
            static_cast<std::int32_t>(static_cast<double>(number) * inverse + 0x1p-43));
      };
      frame.colours[voxel++] = {quantised(sum.r), quantised(sum.g), quantised(sum.b)};
    });
  }

  void
  addRuns(const PointView& points,
          const std::size_t* added,
          VoxelizationStatistics& statistics)
  {
    Run run = run_;
    std::size_t last = last_run_;
    for (std::size_t i = 0; i < placed_.count; ++i) {
      const float intensity = usableIntensity(
          points.intensities[placed_.points[i] * points.intensity_stride], statistics);
      // Without a branch, which would be mispredicted: the run is stored at each point and
      // overwritten while it continues.
      const bool goes_on = added[i] == run.added;
      last += goes_on ? 0 : 1;
      run.added = added[i];
      run.sum = static_cast<double>(goes_on) * run.sum + static_cast<double>(intensity);
      runs_[last] = run;
    }
    run_ = run;
    last_run_ = last;
  }

  float
  usableIntensity(float intensity, VoxelizationStatistics& statistics)
  {
    if (!std::isfinite(intensity)) {
      ++statistics.intensities_not_finite;
      return 0.0f;
    }
    if (is_native_)
      step_.add(intensity);
    return intensity;
  }

  /** \brief Sums the runs in the order of their points, as the order affects rounding. */
  template <typename VoxelsT>
  void
  sumIntensities(const VoxelsT& voxels, std::size_t count)
  {
    // Not assign(), which reallocates without a reserve.
    voxel_values_.resize(count);
    std::fill(voxel_values_.begin(), voxel_values_.end(), 0.0);
    for (std::size_t i = 1; i <= last_run_; ++i)
      voxel_values_[voxels.voxelOf(runs_[i].added)] += runs_[i].sum;
    for (std::size_t i = 0; is_mean_ && i < count; ++i)
      voxel_values_[i] /= static_cast<double>(voxel_counts_[i]);
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
  PlaceFinder finder_;
  PointBlocks blocks_;
  SortedVoxels sorted_voxels_;
  std::size_t points_per_block_ = 0; // of the last cloud

  // Of the current cloud; members so that their memory is reused.
  PlacedPoints placed_;
  CommonStep step_; // of the intensities
  Run run_;
  std::vector<Run> runs_;    // the first is not used
  std::size_t last_run_ = 0; // of runs_, further elements are unused
  std::vector<std::uint32_t> voxel_counts_;
  std::vector<double> voxel_values_;
  bool is_interrupted_ = false;
  MemoryRule memory_rule_;
};

Voxelizer::Voxelizer(const IntensityCompressionSettings& settings, IntensityUnit unit)
: implementation_(std::make_unique<Implementation>(settings, unit))
{}

Voxelizer::~Voxelizer() = default;
Voxelizer::Voxelizer(Voxelizer&&) noexcept = default;
Voxelizer&
Voxelizer::operator=(Voxelizer&&) noexcept = default;

VoxelizationStatistics
Voxelizer::voxelize(const PointView& points, bool may_refit, VoxelFrame& frame)
{
  return implementation_->voxelize(points, may_refit, frame);
}

} // namespace io
} // namespace pcl_ext
