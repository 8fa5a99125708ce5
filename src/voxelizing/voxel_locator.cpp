// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/voxel_locator.h"

#include "voxelizing/coordinate_range.h"
#include "voxelizing/point_batches.h"
#include "voxelizing/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

VoxelGrid
initialGrid(const EncoderSettings& settings)
{
  if (settings.bounding_box && settings.format == StreamFormat::Published)
    return pclGridOfBox(settings.resolution, *settings.bounding_box);
  VoxelGrid grid;
  grid.resolution = settings.resolution;
  if (settings.origin && settings.format == StreamFormat::Version1)
    grid.origin = *settings.origin;
  else if (settings.bounding_box)
    grid.origin = originFor(settings.resolution, *settings.bounding_box);
  return settings.bounding_box ? gridOfBox(grid, *settings.bounding_box) : grid;
}

Lattice
wholeLattice(const VoxelGrid& grid)
{
  return {grid,
          {-lattice_end, -lattice_end, -lattice_end},
          {lattice_end, lattice_end, lattice_end}};
}

/** \brief The grid for coordinates less its origin. */
VoxelGrid
relativeGrid(VoxelGrid grid)
{
  grid.origin = {};
  return grid;
}

/** \brief How many points there are for which a function returns true. */
template <typename IsCountedT>
std::size_t
countPoints(PointBatches& points, const IsCountedT& is_counted)
{
  std::size_t count = 0;
  visitPoints(points, [&](const auto* point) { count += is_counted(point) ? 1 : 0; });
  return count;
}

/** \brief The median of some points along each axis; 0 if none is finite. */
std::array<double, 3>
medianOf(PointBatches& points)
{
  constexpr std::size_t most_samples = 1023;
  const std::size_t step = points.size() / most_samples + 1;
  std::array<std::vector<double>, 3> samples;
  std::size_t index = 0;
  visitPoints(points, [&](const auto* point) {
    if (index++ % step == 0 && isFinite(point))
      for (std::size_t axis = 0; axis < 3; ++axis)
        samples[axis].push_back(static_cast<double>(point[axis]));
  });
  std::array<double, 3> median{};
  if (samples[0].empty())
    return median;
  for (std::size_t axis = 0; axis < 3; ++axis)
    median[axis] = quantileOf(samples[axis]);
  return median;
}

/** \brief The middle between the lowest and the highest coordinate along each axis. */
std::array<double, 3>
middleOf(PointBatches& points)
{
  const CoordinateEnds ends = coordinateEnds(points);
  std::array<double, 3> middle;
  for (std::size_t axis = 0; axis < 3; ++axis)
    middle[axis] = (ends.lowest[axis] + ends.highest[axis]) / 2.0;
  return middle;
}

} // namespace

VoxelLocator::VoxelLocator(const EncoderSettings& settings)
: box_(settings.bounding_box)
, has_pcl_grid_(box_ && settings.format == StreamFormat::Published)
, grid_(initialGrid(settings))
, lattice_(box_ ? Lattice::within(grid_) : wholeLattice(grid_))
, locator_grid_(grid_, box_)
, rounded_locator_grid_(relativeGrid(grid_), std::nullopt, true)
{
  if (!box_)
    setLattice();
}

void
VoxelLocator::setGrid(const VoxelGrid& grid)
{
  const bool has_other_lattice = grid.origin != grid_.origin;
  grid_ = grid;
  locator_grid_ = LocatorGrid(grid_, box_);
  rounded_locator_grid_ = LocatorGrid(relativeGrid(grid_), std::nullopt, true);
  if (has_other_lattice)
    setLattice();
}

void
VoxelLocator::setLattice()
{
  lattice_ = wholeLattice(grid_);
  usable_min_ = lattice_.lowestCoordinates();
  usable_max_ = lattice_.highestCoordinates();
}

bool
VoxelLocator::findBetterOrigin(PointBatches& points,
                               bool is_i_frame_due,
                               std::array<double, 3>& origin) const
{
  const std::size_t finite =
      countPoints(points, [](const auto* point) { return isFinite(point); });
  const std::size_t present = countPointsOnLattice(points);
  std::size_t most = present;
  // The median, so that a few far points do not matter, and the middle, for wide
  // clouds.
  for (const std::array<double, 3>& voxel : {medianOf(points), middleOf(points)}) {
    VoxelGrid other = grid_;
    for (std::size_t axis = 0; axis < 3; ++axis)
      other.origin[axis] =
          std::round(voxel[axis] / grid_.resolution) * grid_.resolution;
    if (!isOrigin(other.origin))
      continue;
    VoxelLocator locator = *this;
    locator.setGrid(other);
    if (const std::size_t count = locator.countPointsOnLattice(points); count > most) {
      most = count;
      origin = other.origin;
    }
  }
  // Each move costs an I-frame, so that a few points more are not worth one that is not
  // due.
  const std::size_t least_gain = is_i_frame_due && most == finite ? 1 : 1 + finite / 16;
  return most >= present + least_gain;
}

std::size_t
VoxelLocator::countPointsOnLattice(PointBatches& points) const
{
  LatticeIndex index;
  return countPoints(points,
                     [&](const auto* point) { return lattice_.indexOf(point, index); });
}

bool
VoxelLocator::measureRange(PointBatches& points, LatticeRange& range) const
{
  // The quotient is monotonic in the coordinate: the lowest and the highest coordinates
  // are in the lowest and the highest voxels.
  CoordinateRange coordinates(usable_min_, usable_max_);
  bool is_any = false;
  const auto add = [&](const LatticeRange& other) {
    range = is_any ? unite(range, other) : other;
    is_any = true;
  };
  const auto add_ends = [&](const auto& lowest, const auto& highest) {
    LatticeRange ends;
    if (lattice_.indexOf(lowest.data(), ends.lowest) &&
        lattice_.indexOf(highest.data(), ends.highest))
      add(ends);
  };
  CoordinateEnds of_doubles;
  points.restart();
  for (PointView batch; points.next(batch);)
    if (batch.double_coordinates == nullptr)
      coordinates.add(batch);
    else
      visitPoints(batch, [&](const auto* point) {
        bool is_between_usable_floats = true;
        for (std::size_t axis = 0; axis < 3; ++axis)
          is_between_usable_floats &= static_cast<double>(point[axis]) >=
                                          static_cast<double>(usable_min_[axis]) &&
                                      static_cast<double>(point[axis]) <=
                                          static_cast<double>(usable_max_[axis]);
        LatticeIndex index;
        if (is_between_usable_floats)
          of_doubles.add(point);
        else if (lattice_.indexOf(point, index))
          add({index, index});
      });
  if (coordinates.isAny())
    add_ends(coordinates.lowest(), coordinates.highest());
  if (of_doubles.lowest[0] <= of_doubles.highest[0])
    add_ends(of_doubles.lowest, of_doubles.highest);
  return is_any;
}

bool
VoxelLocator::find(const PointView& points,
                   std::size_t begin,
                   LocatedPoints& located,
                   VoxelizationStatistics& statistics) const
{
  located.count = 0;
  const std::size_t end = std::min(points.count, begin + LocatedPoints::capacity);
  std::size_t i = begin;
  if (CertainPoints certain; locate(points, begin, end, located, certain)) {
    for (std::size_t eight = 0; i < end; eight += 8) {
      const unsigned int bits = certain[eight / 8];
      if (bits == 255) {
        located.moveEightToEnd(eight, i);
        i += 8;
        continue;
      }
      for (std::size_t lane = 0; lane < 8 && i < end; ++lane, ++i)
        if ((bits >> lane & 1) != 0)
          located.moveToEnd(eight + lane, i);
        else if (!findOne(points, i, located, statistics))
          return false;
    }
  }
  for (; i < end; ++i)
    if (!findOne(points, i, located, statistics))
      return false;
  return true;
}

/** \brief Calls locatePoints().
 * \return false if the points are not such as it takes
 */
bool
VoxelLocator::locate(const PointView& points,
                     std::size_t begin,
                     std::size_t end,
                     LocatedPoints& located,
                     CertainPoints& certain) const
{
  const std::size_t stride = points.coordinate_stride;
  const auto bytes_of = [](const float* coordinates) {
    return reinterpret_cast<const unsigned char*>(coordinates);
  };
  if (points.double_coordinates == nullptr) {
    if (!locator_grid_.is_useful || stride < 3 * sizeof(float))
      return false;
    locatePoints(locator_grid_,
                 {bytes_of(points.coordinates) + begin * stride,
                  stride,
                  end - begin,
                  end < points.count},
                 located,
                 certain);
    return true;
  }
  if (!rounded_locator_grid_.is_useful)
    return false;
  std::array<float, 3 * LocatedPoints::capacity> rounded;
  const double* point = detail::atOffset(points.double_coordinates, begin * stride);
  for (std::size_t i = 0; i < end - begin;
       ++i, point = detail::atOffset(point, stride)) {
    const bool is_outside = box_ && !isInside(*box_, point);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from_origin = point[axis] - grid_.origin[axis];
      // What is in the grid is far below the largest float.
      rounded[3 * i + axis] = is_outside || !(std::abs(from_origin) < 1e30)
                                  ? std::numeric_limits<float>::quiet_NaN()
                                  : static_cast<float>(from_origin);
    }
  }
  locatePoints(rounded_locator_grid_,
               {bytes_of(rounded.data()), 3 * sizeof(float), end - begin, false},
               located,
               certain);
  return true;
}

template <typename NumberT>
bool
VoxelLocator::findVoxel(const NumberT* point,
                        LatticeIndex& index,
                        VoxelizationStatistics& statistics) const
{
  const bool is_in_box = !box_ || isInside(*box_, point);
  if (is_in_box && lattice_.indexOf(point, index))
    return true;
  // The box may be the cube of PCL's octree. Its upper faces belong to the box, but not
  // to the cube. Grids of version 1 may be smaller than the box.
  if (is_in_box && has_pcl_grid_) {
    index = lattice_.nearestIndexOf(point);
    return true;
  }
  if (!isFinite(point))
    ++statistics.points_not_finite;
  else if (!is_in_box)
    ++statistics.points_outside_box;
  else
    ++statistics.points_outside_grid;
  return false;
}

bool
VoxelLocator::findOne(const PointView& points,
                      std::size_t point,
                      LocatedPoints& located,
                      VoxelizationStatistics& statistics) const
{
  const std::size_t offset = point * points.coordinate_stride;
  LatticeIndex index;
  const bool is_used =
      points.double_coordinates != nullptr
          ? findVoxel(
                detail::atOffset(points.double_coordinates, offset), index, statistics)
          : findVoxel(detail::atOffset(points.coordinates, offset), index, statistics);
  if (!is_used)
    return true;
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
  const BlockVoxel voxel = blockVoxelOf({position[0], position[1], position[2]});
  located.blocks[located.count] = voxel.block;
  located.voxels[located.count] = voxel.voxel;
  located.points[located.count] = point;
  ++located.count;
  return true;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
