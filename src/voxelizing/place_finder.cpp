#include "voxelizing/place_finder.h"

#include "simd/bit_operations.h"
#include "voxelizing/point_batches.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

namespace pcl_ext {
namespace io {

namespace {

VoxelGrid
initialGrid(const IntensityCompressionSettings& settings)
{
  if (settings.bounding_box && settings.format == StreamFormat::Published)
    return pclGridOfBox(settings.resolution, *settings.bounding_box);
  VoxelGrid grid;
  grid.resolution = settings.resolution;
  if (settings.origin && settings.format == StreamFormat::Version1)
    grid.anchor = *settings.origin;
  else if (settings.bounding_box)
    grid.anchor = originFor(settings.resolution, *settings.bounding_box);
  return settings.bounding_box ? gridOfBox(grid, *settings.bounding_box) : grid;
}

/** \brief The usable range is a fixed grid, or the whole lattice. */
Lattice
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

std::size_t
countFinite(PointBatches& points)
{
  std::size_t count = 0;
  visitPoints(points,
              [&count](const float* point) { count += isFinite(point) ? 1 : 0; });
  return count;
}

/** \brief The median of some points along each axis; 0 if none is finite. */
std::array<double, 3>
medianOf(PointBatches& points)
{
  constexpr std::size_t most_samples = 1023;
  const std::size_t step = points.size() / most_samples + 1;
  std::array<std::vector<float>, 3> samples;
  std::size_t index = 0;
  visitPoints(points, [&](const float* point) {
    if (index++ % step == 0 && isFinite(point))
      for (std::size_t axis = 0; axis < 3; ++axis)
        samples[axis].push_back(point[axis]);
  });
  std::array<double, 3> median{};
  if (samples[0].empty())
    return median;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto middle =
        samples[axis].begin() + static_cast<std::ptrdiff_t>(samples[axis].size() / 2);
    std::nth_element(samples[axis].begin(), middle, samples[axis].end());
    median[axis] = static_cast<double>(*middle);
  }
  return median;
}

/** \brief The middle between the lowest and the highest coordinate along each axis. */
std::array<double, 3>
middleOf(PointBatches& points)
{
  const CoordinateEnds ends = coordinateEnds(points);
  std::array<double, 3> middle;
  for (std::size_t axis = 0; axis < 3; ++axis)
    middle[axis] = (static_cast<double>(ends.lowest[axis]) +
                    static_cast<double>(ends.highest[axis])) /
                   2.0;
  return middle;
}

/** \brief The lowest and the highest coordinates of the points of a usable range. */
class CoordinateRange {
public:
  /** \param[in] usable_min,usable_max ends of the range, both included */
  CoordinateRange(const std::array<float, 3>& usable_min,
                  const std::array<float, 3>& usable_max)
  : usable_min_(lanesOf(usable_min))
  , usable_max_(lanesOf(usable_max))
  , lowest_(usable_max_)
  , highest_(usable_min_)
  {}

  /** \brief Adds those of some points that are in the usable range. */
  void
  add(const PointView& points)
  {
    const auto* const bytes =
        reinterpret_cast<const unsigned char*>(points.coordinates);
    const std::size_t stride = points.coordinate_stride * sizeof(float);
    for (std::size_t i = 0; i + 1 < points.count; ++i) {
      prefetch(bytes + i * stride + prefetch_distance);
      addPoint(bytes + i * stride);
    }
    // A float after z is read, which the last point may not have.
    if (points.count > 0) {
      std::array<float, 4> last{};
      std::memcpy(last.data(), bytes + (points.count - 1) * stride, 3 * sizeof(float));
      addPoint(reinterpret_cast<const unsigned char*>(last.data()));
    }
  }

  bool
  isAny() const
  {
    return is_any_;
  }

  std::array<float, 4>
  lowest() const
  {
    return arrayOf(lowest_);
  }

  std::array<float, 4>
  highest() const
  {
    return arrayOf(highest_);
  }

private:
  using Floats = NativeLanes::Floats;

  void
  addPoint(const unsigned char* point)
  {
    const auto coordinates = NativeLanes::loadPoint(point);
    const unsigned int usable = NativeLanes::bitsOf(
        NativeLanes::bitAnd(NativeLanes::lessOrEqual(usable_min_, coordinates),
                            NativeLanes::lessOrEqual(coordinates, usable_max_)));
    if ((usable & 7) != 7) // NaN is not
      return;
    is_any_ = true;
    lowest_ = NativeLanes::minimum(lowest_, coordinates);
    highest_ = NativeLanes::maximum(highest_, coordinates);
  }

  static Floats
  lanesOf(const std::array<float, 3>& point)
  {
    const std::array<float, 4> lanes{point[0], point[1], point[2], 0.0f};
    return NativeLanes::loadPoint(reinterpret_cast<const unsigned char*>(lanes.data()));
  }

  static std::array<float, 4>
  arrayOf(const Floats& lanes)
  {
    std::array<float, 4> array;
    NativeLanes::store(lanes, array.data());
    return array;
  }

  // The fourth lane is not used.
  Floats usable_min_;
  Floats usable_max_;
  Floats lowest_;
  Floats highest_;
  bool is_any_ = false;
};

} // namespace

PlaceFinder::PlaceFinder(const IntensityCompressionSettings& settings)
: box_(settings.bounding_box)
, has_pcl_grid_(box_ && settings.format == StreamFormat::Published)
, grid_(initialGrid(settings))
, lattice_(makeLattice(grid_, box_.has_value()))
, locator_grid_(grid_, box_)
{
  if (!box_)
    setLattice();
}

void
PlaceFinder::setGrid(const VoxelGrid& grid)
{
  const bool has_other_lattice = grid.anchor != grid_.anchor;
  grid_ = grid;
  locator_grid_ = LocatorGrid(grid_, box_);
  if (has_other_lattice)
    setLattice();
}

void
PlaceFinder::setLattice()
{
  lattice_ = makeLattice(grid_, false);
  usable_min_ = lattice_.lowestCoordinates();
  usable_max_ = lattice_.highestCoordinates();
}

bool
PlaceFinder::findBetterOrigin(PointBatches& points,
                              bool is_i_frame_due,
                              std::array<double, 3>& origin) const
{
  const std::size_t finite = countFinite(points);
  const std::size_t present = countPointsOnLattice(points);
  std::size_t most = present;
  // The median, so that a few far points do not matter, and the middle, for wide clouds.
  for (const std::array<double, 3>& place : {medianOf(points), middleOf(points)}) {
    VoxelGrid other = grid_;
    for (std::size_t axis = 0; axis < 3; ++axis)
      other.anchor[axis] =
          std::round(place[axis] / grid_.resolution) * grid_.resolution;
    if (!isOrigin(other.anchor))
      continue;
    PlaceFinder finder = *this;
    finder.setGrid(other);
    if (const std::size_t count = finder.countPointsOnLattice(points); count > most) {
      most = count;
      origin = other.anchor;
    }
  }
  // Each move costs an I-frame, so that a few points more are not worth one that is not due.
  const std::size_t least_gain = is_i_frame_due && most == finite ? 1 : 1 + finite / 16;
  return most >= present + least_gain;
}

std::size_t
PlaceFinder::countPointsOnLattice(PointBatches& points) const
{
  std::size_t count = 0;
  LatticeIndex index;
  visitPoints(points, [&](const float* point) {
    count += lattice_.indexOf(point, index) ? 1 : 0;
  });
  return count;
}

bool
PlaceFinder::measureRange(PointBatches& points, LatticeRange& range) const
{
  // The quotient is monotonic in the coordinate: the lowest and the highest coordinates are
  // in the lowest and the highest voxels.
  CoordinateRange coordinates(usable_min_, usable_max_);
  points.restart();
  for (PointView batch; points.next(batch);)
    coordinates.add(batch);
  return coordinates.isAny() &&
         lattice_.indexOf(coordinates.lowest().data(), range.lowest) &&
         lattice_.indexOf(coordinates.highest().data(), range.highest);
}

bool
PlaceFinder::find(const PointView& points,
                  std::size_t begin,
                  PlacedPoints& placed,
                  VoxelizationStatistics& statistics) const
{
  placed.count = 0;
  const std::size_t end = std::min(points.count, begin + PlacedPoints::capacity);
  const std::size_t stride = points.coordinate_stride;
  std::size_t i = begin;
  if (locator_grid_.is_useful && stride >= 3) {
    CertainPoints certain;
    locatePoints(
        locator_grid_,
        {reinterpret_cast<const unsigned char*>(points.coordinates + begin * stride),
         stride * sizeof(float),
         end - begin,
         end < points.count},
        placed,
        certain);
    for (std::size_t eight = 0; i < end; eight += 8) {
      const unsigned int bits = certain[eight / 8];
      if (bits == 255) {
        placed.moveEightToEnd(eight, i);
        i += 8;
        continue;
      }
      for (std::size_t lane = 0; lane < 8 && i < end; ++lane, ++i)
        if ((bits >> lane & 1) != 0)
          placed.moveToEnd(eight + lane, i);
        else if (!findOne(points, i, placed, statistics))
          return false;
    }
  }
  for (; i < end; ++i)
    if (!findOne(points, i, placed, statistics))
      return false;
  return true;
}

bool
PlaceFinder::findOne(const PointView& points,
                     std::size_t point,
                     PlacedPoints& placed,
                     VoxelizationStatistics& statistics) const
{
  const float* const coordinates =
      points.coordinates + point * points.coordinate_stride;
  LatticeIndex index;
  if (!findVoxel(coordinates, index)) {
    countUnused(coordinates, statistics);
    return true;
  }
  std::array<std::uint32_t, 3> position;
  std::uint32_t all_bits = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Negative positions wrap to large ones.
    position[axis] = static_cast<std::uint32_t>(index[axis]) -
                     static_cast<std::uint32_t>(grid_.first_index[axis]);
    all_bits |= position[axis];
  }
  if (all_bits >= grid_.size())
    return false;
  const BlockPlace place = blockPlace({position[0], position[1], position[2]});
  placed.blocks[placed.count] = place.block;
  placed.voxels[placed.count] = place.voxel;
  placed.points[placed.count] = point;
  ++placed.count;
  return true;
}

bool
PlaceFinder::isInBox(const float* point) const
{
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto coordinate = static_cast<double>(point[axis]);
    // Negated, so that NaN is outside.
    if (!(coordinate >= box_->min[axis] && coordinate <= box_->max[axis]))
      return false;
  }
  return true;
}

bool
PlaceFinder::findVoxel(const float* point, LatticeIndex& index) const
{
  if (!box_)
    return lattice_.indexOf(point, index);
  if (!isInBox(point))
    return false;
  if (lattice_.indexOf(point, index))
    return true;
  // The box may be the cube of PCL's octree. Its upper faces belong to the box, but not to
  // the cube. Grids of version 1 may be smaller than the box.
  if (has_pcl_grid_)
    index = lattice_.nearestIndexOf(point);
  return has_pcl_grid_;
}

void
PlaceFinder::countUnused(const float* point, VoxelizationStatistics& statistics) const
{
  if (!std::isfinite(point[0]) || !std::isfinite(point[1]) || !std::isfinite(point[2]))
    ++statistics.points_not_finite;
  else if (box_ && !isInBox(point))
    ++statistics.points_outside_box;
  else
    ++statistics.points_outside_grid;
}

} // namespace io
} // namespace pcl_ext
