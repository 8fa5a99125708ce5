// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "meters/decoded_checks.h"

#include <pcl/kdtree/kdtree_flann.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

using VoxelKey = std::uint64_t;

/** \brief Packs a voxel's index; 2^20 voxels on either side of the origin. */
class VoxelKeys {
public:
  explicit VoxelKeys(const Lattice& lattice) : lattice_(lattice) {}

  /** \brief Index of a coordinate on one axis, moved by a part of a voxel. */
  std::int64_t
  index(float coordinate, std::size_t axis, double moved) const
  {
    return static_cast<std::int64_t>(
        std::floor((static_cast<double>(coordinate) - lattice_.origin[axis]) /
                       lattice_.resolution +
                   moved));
  }

  template <typename PointT>
  VoxelKey
  key(const PointT& point, const std::array<double, 3>& moved = {}) const
  {
    return pack({index(point.x, 0, moved[0]),
                 index(point.y, 1, moved[1]),
                 index(point.z, 2, moved[2])});
  }

private:
  static VoxelKey
  pack(const std::array<std::int64_t, 3>& index)
  {
    constexpr std::int64_t limit = std::int64_t{1} << 20;
    VoxelKey key = 0;
    for (const std::int64_t i : index) {
      if (i < -limit || i >= limit)
        throw std::runtime_error("a point lies more than 2^20 voxels from the origin");
      key = (key << 21) | static_cast<VoxelKey>(i + limit);
    }
    return key;
  }

  Lattice lattice_;
};

void
sortUnique(std::vector<VoxelKey>& keys)
{
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

using VoxelSum = std::pair<VoxelKey, double>;

/** \brief The points' voxels in ascending order, with the sums of their intensities. */
std::vector<VoxelSum>
sumByVoxel(const IntensityCloud& cloud, const VoxelKeys& keys)
{
  std::vector<VoxelSum> points;
  points.reserve(cloud.size());
  for (const pcl::PointXYZI& point : cloud)
    points.emplace_back(keys.key(point), static_cast<double>(point.intensity));
  std::stable_sort(
      points.begin(), points.end(), [](const VoxelSum& a, const VoxelSum& b) {
        return a.first < b.first;
      });
  std::vector<VoxelSum> sums;
  for (const VoxelSum& point : points)
    if (!sums.empty() && sums.back().first == point.first)
      sums.back().second += point.second;
    else
      sums.push_back(point);
  return sums;
}

} // namespace

void
checkVoxels(const PositionCloud& points,
            const PositionCloud& decoded,
            const Lattice& lattice,
            double face_tolerance,
            Repeats repeats)
{
  const VoxelKeys keys(lattice);
  std::vector<VoxelKey> certain;
  std::vector<VoxelKey> possible;
  certain.reserve(points.size());
  possible.reserve(points.size());
  for (const pcl::PointXYZ& point : points) {
    const double t = face_tolerance;
    const VoxelKey lowest = keys.key(point, {-t, -t, -t});
    if (lowest == keys.key(point, {t, t, t})) {
      certain.push_back(lowest);
      possible.push_back(lowest);
      continue;
    }
    for (unsigned int corner = 0; corner < 8; ++corner)
      possible.push_back(keys.key(point,
                                  {(corner & 1) != 0 ? t : -t,
                                   (corner & 2) != 0 ? t : -t,
                                   (corner & 4) != 0 ? t : -t}));
  }
  sortUnique(certain);
  sortUnique(possible);
  std::vector<VoxelKey> found;
  found.reserve(decoded.size());
  for (const pcl::PointXYZ& centre : decoded)
    found.push_back(keys.key(centre));
  sortUnique(found);
  if (repeats == Repeats::Forbidden && found.size() != decoded.size())
    throw std::runtime_error("a voxel was decoded twice");
  if (!std::includes(found.begin(), found.end(), certain.begin(), certain.end()) ||
      !std::includes(possible.begin(), possible.end(), found.begin(), found.end()))
    throw std::runtime_error("the decoded voxels are not those that hold points: " +
                             std::to_string(found.size()) + " instead of " +
                             std::to_string(certain.size()));
}

void
checkPointsInOrder(const PositionCloud& points,
                   const PositionCloud& decoded,
                   double edge)
{
  bool are_near = points.size() == decoded.size();
  for (std::size_t i = 0; are_near && i < points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const auto expected = static_cast<double>(points[i].data[axis]);
      const double rounding = std::abs(expected) * 0x1p-23;
      are_near &= std::abs(static_cast<double>(decoded[i].data[axis]) - expected) <=
                  edge / 2.0 + rounding;
    }
  if (!are_near)
    throw std::runtime_error("of " + std::to_string(points.size()) + " points " +
                             std::to_string(decoded.size()) +
                             " were decoded, or some are too far away");
}

void
checkPoints(const PositionCloud& points,
            const PositionCloud& decoded,
            const Lattice& lattice)
{
  const VoxelKeys keys(lattice);
  const auto sorted_keys = [&keys](const PositionCloud& cloud) {
    std::vector<VoxelKey> sorted;
    sorted.reserve(cloud.size());
    for (const pcl::PointXYZ& point : cloud)
      sorted.push_back(keys.key(point));
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  };
  if (sorted_keys(points) != sorted_keys(decoded))
    throw std::runtime_error("the voxels of the " + std::to_string(decoded.size()) +
                             " decoded points are not those of the " +
                             std::to_string(points.size()) + " points");
}

void
checkIntensities(const IntensityCloud& points,
                 const IntensityCloud& decoded,
                 const Lattice& lattice,
                 double top,
                 double tolerance)
{
  const VoxelKeys keys(lattice);
  const std::vector<VoxelSum> expected = sumByVoxel(points, keys);
  const std::vector<VoxelSum> found = sumByVoxel(decoded, keys);
  if (expected.size() != found.size())
    throw std::runtime_error(
        "there are not as many decoded voxels as voxels with points");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const double error = std::abs(std::min(expected[i].second, top) - found[i].second);
    if (expected[i].first != found[i].first || !(error <= tolerance))
      throw std::runtime_error("a voxel's intensity was decoded as " +
                               std::to_string(found[i].second) + " instead of " +
                               std::to_string(expected[i].second));
  }
}

NearestDistances&
NearestDistances::operator+=(const NearestDistances& other)
{
  points += other.points;
  sum_of_squares += other.sum_of_squares;
  largest = std::max(largest, other.largest);
  largest_of_axis = std::max(largest_of_axis, other.largest_of_axis);
  return *this;
}

double
NearestDistances::rms() const
{
  return points == 0 ? 0.0 : std::sqrt(sum_of_squares / static_cast<double>(points));
}

NearestDistances
nearestDistances(const PositionCloud::ConstPtr& from, const PositionCloud::ConstPtr& to)
{
  // Each place once, as many points of a voxel would all be found.
  const PositionCloud::Ptr places(new PositionCloud(*to));
  const auto coordinates = [](const pcl::PointXYZ& point) {
    return std::make_tuple(point.x, point.y, point.z);
  };
  std::sort(
      places->points.begin(), places->points.end(), [&](const auto& a, const auto& b) {
        return coordinates(a) < coordinates(b);
      });
  places->points.erase(std::unique(places->points.begin(),
                                   places->points.end(),
                                   [&](const auto& a, const auto& b) {
                                     return coordinates(a) == coordinates(b);
                                   }),
                       places->points.end());
  places->width = static_cast<std::uint32_t>(places->points.size());
  places->height = 1;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree(/* sorted */ false);
  tree.setInputCloud(places);
  pcl::Indices index(1);
  std::vector<float> square(1);
  NearestDistances distances;
  for (const pcl::PointXYZ& point : *from) {
    tree.nearestKSearch(point, 1, index, square);
    const double distance = std::sqrt(static_cast<double>(square[0]));
    ++distances.points;
    distances.sum_of_squares += static_cast<double>(square[0]);
    distances.largest = std::max(distances.largest, distance);
    // What is nearest in the largest difference of a coordinate is at most this far away.
    constexpr double diagonal = 1.7322;
    tree.radiusSearch(point, diagonal * distance, index, square);
    float nearest = std::numeric_limits<float>::infinity();
    for (const pcl::index_t i : index)
      nearest = std::min(nearest,
                         (point.getVector3fMap() - (*places)[i].getVector3fMap())
                             .cwiseAbs()
                             .maxCoeff());
    if (!index.empty()) // else the nearest one is at the same place
      distances.largest_of_axis =
          std::max(distances.largest_of_axis, static_cast<double>(nearest));
  }
  return distances;
}

} // namespace measuring
} // namespace pcl_ext
