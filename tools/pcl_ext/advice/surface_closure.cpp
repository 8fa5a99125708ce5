// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "advice/surface_closure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace pcl_ext::tools {

namespace {

using Position = std::array<std::int64_t, 3>;

/** \brief The voxels of an edge that have points in them. */
class Occupancy {
public:
  Occupancy(const Points& points, double edge) : edge_(edge)
  {
    keys_.reserve(points.size());
    for (const pcl::PointXYZI& point : points)
      keys_.push_back(keyOf(positionOf(point)));
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  }

  std::size_t
  size() const
  {
    return keys_.size();
  }

  /** \brief See SurfaceClosure. */
  bool
  isClosedAt(const pcl::PointXYZI& point) const
  {
    const Position voxel = positionOf(point);
    for (std::size_t normal = 0; normal < 3; ++normal)
      if (hasBoth(voxel, normal, (normal + 1) % 3) &&
          hasBoth(voxel, normal, (normal + 2) % 3))
        return true;
    return false;
  }

private:
  Position
  positionOf(const pcl::PointXYZI& point) const
  {
    // Beyond that a double is no whole number of voxels.
    constexpr double most = 1e15;
    Position position;
    for (int axis = 0; axis < 3; ++axis)
      position[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(
          std::clamp(std::floor(point.data[axis] / edge_), -most, most));
    return position;
  }

  /** \brief 21 bits of each axis; voxels that are 2^21 apart have the same, which are no
   * neighbours. */
  static std::uint64_t
  keyOf(const Position& position)
  {
    constexpr std::uint64_t mask = (std::uint64_t{1} << 21) - 1;
    std::uint64_t key = 0;
    for (const std::int64_t coordinate : position)
      key = key << 21 | (static_cast<std::uint64_t>(coordinate) & mask);
    return key;
  }

  bool
  hasBoth(const Position& voxel, std::size_t normal, std::size_t tangent) const
  {
    for (const int side : {-1, 1}) {
      Position neighbour = voxel;
      neighbour[tangent] += side;
      bool is_there = false;
      for (const int height : {0, -1, 1}) {
        neighbour[normal] = voxel[normal] + height;
        is_there = is_there ||
                   std::binary_search(keys_.begin(), keys_.end(), keyOf(neighbour));
      }
      if (!is_there)
        return false;
    }
    return true;
  }

  double edge_;
  std::vector<std::uint64_t> keys_; // ascending
};

} // namespace

std::vector<double>
roundEdges()
{
  std::vector<double> edges;
  for (const int power : {1, 10, 100, 1000, 10000, 100000})
    for (const int factor : {10, 15, 20, 25, 30, 40, 50, 70})
      edges.push_back(factor * power / 10000.0);
  edges.push_back(1000.0);
  return edges;
}

std::size_t
occupiedVoxels(const Points& points, double edge)
{
  return Occupancy(points, edge).size();
}

SurfaceClosure::SurfaceClosure(const std::vector<double>& edges)
: edges_(edges), closed_(edges.size(), 0)
{}

void
SurfaceClosure::add(const Points& points)
{
  constexpr std::size_t samples = 4000;
  // Odd, so that an image's columns are all met.
  const std::size_t step = points.size() / samples | 1u;
  std::vector<bool> is_closed(points.size(), false);
  for (std::size_t number = 0; number < edges_.size(); ++number) {
    const Occupancy occupancy(points, edges_[number]);
    for (std::size_t i = 0; i < points.size(); i += step) {
      if (!is_closed[i])
        is_closed[i] = occupancy.isClosedAt(points[i]);
      closed_[number] += is_closed[i] ? 1 : 0;
    }
  }
}

double
SurfaceClosure::holesAt(std::size_t number, std::size_t last) const
{
  const std::size_t judged = closed_[last];
  return judged == 0
             ? 1.0
             : 1.0 - static_cast<double>(closed_[number]) / static_cast<double>(judged);
}

} // namespace pcl_ext::tools
