#include <pcl_ext/compression/voxelizer.h>

#include "grid_fit.h"
#include "intensity_quantiser.h"
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
  {
    grid_.resolution = settings.resolution;
    if (box_)
      grid_ = has_pcl_grid_ ? pclGridOfBox(settings.resolution, *box_)
                            : gridOfBox(settings.resolution, *box_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      allowed_begin_[axis] =
          static_cast<double>(box_ ? grid_.first_index[axis] : -lattice_end);
      allowed_end_[axis] = static_cast<double>(
          box_ ? grid_.first_index[axis] + grid_.size() : lattice_end);
    }
  }

  VoxelizationStatistics
  voxelize(const PointView& points, bool may_refit, VoxelFrame& frame)
  {
    VoxelizationStatistics statistics;
    statistics.points = points.count;
    collectPoints(points, statistics);
    if (!lattice_points_.empty() && !has_fixed_grid_)
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
  struct LatticePoint {
    std::array<std::int32_t, 3> index;
    float intensity;
  };

  struct KeyedIntensity {
    std::uint64_t key;
    float intensity;
  };

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

  /** \brief Lattice index of a point; false if it is not finite, or beyond the lattice
   * or the fixed grid. */
  bool
  latticeIndex(const float* point, std::array<std::int32_t, 3>& index) const
  {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      // Divided, not multiplied by the inverse: at a face the inverse's rounding would
      // put points into the neighbour of the voxel that they are in.
      const double position =
          (static_cast<double>(point[axis]) - grid_.anchor[axis]) / grid_.resolution;
      if (!(position >= allowed_begin_[axis] && position < allowed_end_[axis]))
        return false;
      // The floor, without a call into the mathematics library.
      const auto truncated = static_cast<std::int32_t>(position);
      index[axis] = truncated - (static_cast<double>(truncated) > position ? 1 : 0);
    }
    return true;
  }

  /** \brief Lattice index of a point in the box that is not in the grid, because it
   * lies on an upper face of a box that is the very cube of PCL's octree: that of the
   * last voxel. False in this library's own grids, which may end before the box does.
   */
  bool
  upperFaceIndex(const float* point, std::array<std::int32_t, 3>& index) const
  {
    if (!has_pcl_grid_)
      return false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      index[axis] = static_cast<std::int32_t>(std::clamp(
          (static_cast<double>(point[axis]) - grid_.anchor[axis]) / grid_.resolution,
          allowed_begin_[axis],
          allowed_end_[axis] - 1.0));
    return true;
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
  collectPoints(const PointView& points, VoxelizationStatistics& statistics)
  {
    lattice_points_.resize(points.count);
    LatticePoint* next = lattice_points_.data();
    range_.lowest.fill(std::numeric_limits<std::int32_t>::max());
    range_.highest.fill(std::numeric_limits<std::int32_t>::min());
    all_whole_numbers_ = true;
    for (std::size_t i = 0; i < points.count; ++i) {
      const float* point = points.coordinates + i * points.coordinate_stride;
      if (box_ ? !(isInBox(point) && (latticeIndex(point, next->index) ||
                                      upperFaceIndex(point, next->index)))
               : !latticeIndex(point, next->index)) {
        countUnused(point, statistics);
        continue;
      }
      next->intensity = points.intensities != nullptr
                            ? points.intensities[i * points.intensity_stride]
                            : 1.0f;
      if (!std::isfinite(next->intensity)) {
        ++statistics.intensities_not_finite;
        next->intensity = 0.0f;
      }
      if (is_native_)
        all_whole_numbers_ &= next->intensity == std::floor(next->intensity);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        range_.lowest[axis] = std::min(range_.lowest[axis], next->index[axis]);
        range_.highest[axis] = std::max(range_.highest[axis], next->index[axis]);
      }
      ++next;
    }
    lattice_points_.resize(static_cast<std::size_t>(next - lattice_points_.data()));
    statistics.points_used = lattice_points_.size();
  }

  void
  adaptGrid(bool may_refit)
  {
    // Two levels too many is an outlier's work that has passed; one is breathing space.
    const bool is_far_too_large = may_refit && requiredDepth(range_) + 2 <= grid_.depth;
    if (!has_grid_ || is_far_too_large)
      grid_ = fitGrid(grid_.resolution, range_);
    else if (!containsRange(grid_, range_))
      grid_ = fitGrid(grid_.resolution, unite(rangeOf(grid_), range_));
    has_grid_ = true;
  }

  void
  sortByKey()
  {
    entries_.resize(lattice_points_.size());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const auto position = [&](std::size_t axis) {
        return static_cast<std::uint32_t>(lattice_points_[i].index[axis] -
                                          grid_.first_index[axis]);
      };
      entries_[i] = {mortonKey({position(0), position(1), position(2)}),
                     lattice_points_[i].intensity};
    }
    radixSort(entries_, spare_entries_, 3 * grid_.depth);
  }

  void
  aggregate(VoxelFrame& frame)
  {
    frame.keys.clear();
    voxel_values_.clear();
    for (std::size_t begin = 0; begin < entries_.size();) {
      const std::uint64_t key = entries_[begin].key;
      double sum = 0.0;
      std::size_t end = begin;
      for (; end < entries_.size() && entries_[end].key == key; ++end)
        sum += static_cast<double>(entries_[end].intensity);
      frame.keys.push_back(key);
      voxel_values_.push_back(is_mean_ ? sum / static_cast<double>(end - begin) : sum);
      begin = end;
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
  std::array<double, 3> allowed_begin_; // lattice indices that points may have
  std::array<double, 3> allowed_end_;

  // Of the current cloud; members so that their memory is reused.
  LatticeRange range_;
  bool all_whole_numbers_ = true;
  std::vector<LatticePoint> lattice_points_;
  std::vector<KeyedIntensity> entries_;
  std::vector<KeyedIntensity> spare_entries_;
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
