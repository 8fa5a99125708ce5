#include <pcl_ext/compression/voxelizer.h>

#include "grid_fit.h"
#include "intensity_quantiser.h"
#include "lattice.h"
#include "radix_sort.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ext {
namespace io {

class Voxelizer::Implementation {
public:
  Implementation(const IntensityCompressionSettings& settings, IntensityUnit unit)
  : quantiser_(settings, unit)
  , is_native_(unit == IntensityUnit::Native)
  , is_mean_(settings.aggregation == Aggregation::Mean ||
             (settings.aggregation == Aggregation::Automatic && is_native_ &&
              settings.format != StreamFormat::Published))
  , has_fixed_grid_(settings.bounding_box.has_value())
  , has_pcl_grid_(has_fixed_grid_ && settings.format == StreamFormat::Published)
  , has_grid_(has_fixed_grid_)
  , box_(settings.bounding_box)
  , grid_(initialGrid(settings))
  , lattice_(makeLattice(grid_, has_fixed_grid_))
  {}

  VoxelizationStatistics
  voxelize(const PointView& points, bool may_refit, VoxelFrame& frame)
  {
    VoxelizationStatistics statistics;
    statistics.points = points.count;
    collectRuns(points, statistics);
    if (run_count_ != 0 && !has_fixed_grid_)
      adaptGrid(may_refit);
    sortByKey();
    aggregate(frame);
    frame.grid = grid_;
    statistics.intensities_out_of_range =
        quantiser_.quantise(voxel_values_, all_whole_numbers_, may_refit, frame);
    statistics.voxels = frame.size();
    return statistics;
  }

private:
  /** \brief Consecutive points in the same voxel. Neighbours in a cloud mostly are
   * neighbours in space, so that there are fewer runs than points to sort. */
  struct Run {
    LatticeIndex index;
    std::uint32_t count;
    double sum; // of the points' intensities
  };

  struct KeyedRun {
    std::uint64_t key;
    std::uint32_t run;
  };

  static VoxelGrid
  initialGrid(const IntensityCompressionSettings& settings)
  {
    if (settings.bounding_box)
      return settings.format == StreamFormat::Published
                 ? pclGridOfBox(settings.resolution, *settings.bounding_box)
                 : gridOfBox(settings.resolution, *settings.bounding_box);
    VoxelGrid grid;
    grid.resolution = settings.resolution;
    return grid;
  }

  /** \brief A fixed grid is all that can be used; without one it is the whole lattice. */
  static Lattice
  makeLattice(const VoxelGrid& grid, bool is_fixed)
  {
    std::array<std::int64_t, 3> begin;
    std::array<std::int64_t, 3> end;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      begin[axis] = is_fixed ? grid.first_index[axis] : -lattice_end;
      end[axis] = is_fixed ? begin[axis] + grid.size() : lattice_end;
    }
    return {grid, begin, end};
  }

  bool
  isInBox(const float* point) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto coordinate = static_cast<double>(point[axis]);
      // Written so that NaN is outside.
      if (!(coordinate >= box_->min[axis] && coordinate <= box_->max[axis]))
        return false;
    }
    return true;
  }

  /** \brief Finds the voxel of a point; false if the point is to be left out. */
  bool
  findVoxel(const float* point, LatticeIndex& index) const
  {
    if (!box_)
      return lattice_.indexOf(point, index);
    if (!isInBox(point))
      return false;
    if (lattice_.indexOf(point, index))
      return true;
    // The box may be the very cube of PCL's octree, whose upper faces belong to the box
    // and not to the cube. This library's own grids may end before the box does.
    if (has_pcl_grid_)
      index = lattice_.nearestIndexOf(point);
    return has_pcl_grid_;
  }

  void
  countUnused(const float* point, VoxelizationStatistics& statistics) const
  {
    if (!std::isfinite(point[0]) || !std::isfinite(point[1]) ||
        !std::isfinite(point[2]))
      ++statistics.points_not_finite;
    else if (box_ && !isInBox(point))
      ++statistics.points_outside_box;
    else
      ++statistics.points_outside_grid;
  }

  void
  collectRuns(const PointView& points, VoxelizationStatistics& statistics)
  {
    // Never made smaller, as growing again would write all of it.
    if (runs_.size() < points.count)
      runs_.resize(points.count);
    constexpr std::int32_t nowhere = std::numeric_limits<std::int32_t>::min();
    Run run{{nowhere, nowhere, nowhere}, 0, 0.0};
    std::size_t last = static_cast<std::size_t>(-1); // of the runs; the first is next
    all_whole_numbers_ = true;
    const float* point = points.coordinates;
    LatticeIndex index;
    for (std::size_t i = 0; i < points.count; ++i, point += points.coordinate_stride) {
      if (!findVoxel(point, index)) {
        countUnused(point, statistics);
        continue;
      }
      const double intensity =
          points.intensities != nullptr
              ? usableIntensity(points.intensities[i * points.intensity_stride],
                                statistics)
              : 1.0;
      // Arithmetic instead of a branch: whether a run goes on is a coin toss. The run is
      // written at every point and overwritten as long as it goes on.
      const bool goes_on = isSame(index, run.index);
      last += goes_on ? 0 : 1;
      run.index = index;
      run.count = (goes_on ? run.count : 0) + 1;
      run.sum = static_cast<double>(goes_on) * run.sum + intensity;
      runs_[last] = run;
    }
    run_count_ = last + 1;
    statistics.points_used = points.count - statistics.points_not_finite -
                             statistics.points_outside_box -
                             statistics.points_outside_grid;
  }

  LatticeRange
  rangeOfRuns() const
  {
    LatticeRange range{runs_[0].index, runs_[0].index};
    for (std::size_t i = 1; i < run_count_; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        range.lowest[axis] = std::min(range.lowest[axis], runs_[i].index[axis]);
        range.highest[axis] = std::max(range.highest[axis], runs_[i].index[axis]);
      }
    return range;
  }

  double
  usableIntensity(float intensity, VoxelizationStatistics& statistics)
  {
    if (!std::isfinite(intensity)) {
      ++statistics.intensities_not_finite;
      return 0.0;
    }
    if (is_native_ && all_whole_numbers_)
      all_whole_numbers_ = std::floor(intensity) == intensity;
    return static_cast<double>(intensity);
  }

  void
  adaptGrid(bool may_refit)
  {
    const LatticeRange range = rangeOfRuns();
    // Two levels too many is an outlier's work that has passed; one is breathing space.
    const bool is_far_too_large = may_refit && requiredDepth(range) + 2 <= grid_.depth;
    if (!has_grid_ || is_far_too_large)
      grid_ = fitGrid(grid_.resolution, range);
    else if (!containsRange(grid_, range))
      grid_ = fitGrid(grid_.resolution, unite(rangeOf(grid_), range));
    has_grid_ = true;
  }

  void
  sortByKey()
  {
    keyed_runs_.resize(run_count_);
    for (std::size_t i = 0; i < run_count_; ++i) {
      const auto position = [&](std::size_t axis) {
        return static_cast<std::uint32_t>(runs_[i].index[axis] -
                                          grid_.first_index[axis]);
      };
      keyed_runs_[i] = {mortonKey({position(0), position(1), position(2)}),
                        static_cast<std::uint32_t>(i)};
    }
    radixSort(keyed_runs_, spare_keyed_runs_, 3 * grid_.depth);
  }

  void
  aggregate(VoxelFrame& frame)
  {
    frame.keys.clear();
    voxel_values_.clear();
    for (std::size_t i = 0; i < keyed_runs_.size();) {
      const std::uint64_t key = keyed_runs_[i].key;
      double sum = 0.0;
      std::uint64_t count = 0;
      for (; i < keyed_runs_.size() && keyed_runs_[i].key == key; ++i) {
        sum += runs_[keyed_runs_[i].run].sum;
        count += runs_[keyed_runs_[i].run].count;
      }
      frame.keys.push_back(key);
      voxel_values_.push_back(is_mean_ ? sum / static_cast<double>(count) : sum);
    }
  }

  IntensityQuantiser quantiser_;
  bool is_native_;
  bool is_mean_;
  bool has_fixed_grid_;
  bool has_pcl_grid_;
  bool has_grid_;
  std::optional<BoundingBox> box_;
  VoxelGrid grid_;
  Lattice lattice_;

  // Of the current cloud; members so that their memory is reused.
  bool all_whole_numbers_ = true;
  std::vector<Run> runs_;
  std::size_t run_count_ = 0; // of runs_, whose further elements are spare memory
  std::vector<KeyedRun> keyed_runs_;
  std::vector<KeyedRun> spare_keyed_runs_;
  std::vector<double> voxel_values_;
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
