// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "neighbour_scores.h"

#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief Mean distance of each point to its nearest others, metres, and what it is over
 * all points. */
struct NeighbourDistances {
  std::vector<double> means; ///< of each point
  double mean = 0.0;
  double deviation = 0.0; ///< standard deviation
};

NeighbourDistances
neighbourDistances(const Centres::ConstPtr& centres, int neighbours)
{
  pcl::search::KdTree<pcl::PointXYZI> tree(false);
  tree.setInputCloud(centres);
  pcl::Indices indices;
  std::vector<float> squared_distances;
  NeighbourDistances distances;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const pcl::PointXYZI& point : *centres) {
    // The first that is found is the point itself.
    tree.nearestKSearch(point, neighbours + 1, indices, squared_distances);
    double distance = 0.0;
    for (std::size_t i = 1; i < squared_distances.size(); ++i)
      distance += std::sqrt(static_cast<double>(squared_distances[i]));
    distance /= neighbours;
    sum += distance;
    sum_of_squares += distance * distance;
    distances.means.push_back(distance);
  }
  const auto count = static_cast<double>(distances.means.size());
  distances.mean = sum / count;
  distances.deviation =
      std::sqrt((sum_of_squares - sum * distances.mean) / (count - 1.0));
  return distances;
}

/** \brief How many other points are within a radius of each point.
 * \param[in] radius_of a point, metres
 */
template <typename RadiusT>
void
countWithin(const Centres::ConstPtr& centres,
            const RadiusT& radius_of,
            std::vector<float>& scores)
{
  pcl::search::KdTree<pcl::PointXYZI> tree(false);
  tree.setInputCloud(centres);
  pcl::Indices indices;
  std::vector<float> squared_distances;
  scores.clear();
  // Without the point itself.
  for (const pcl::PointXYZI& point : *centres)
    scores.push_back(static_cast<float>(
        tree.radiusSearch(point, radius_of(point), indices, squared_distances) - 1));
}

} // namespace

Centres::Ptr
centresOf(const io::VoxelFrame& frame)
{
  Centres::Ptr cloud(new Centres);
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    pcl::PointXYZI point;
    point.x = x;
    point.y = y;
    point.z = z;
    point.intensity = intensity;
    cloud->push_back(point);
  });
  return cloud;
}

void
statisticalScores(const Centres::ConstPtr& centres,
                  int neighbours,
                  std::vector<float>& scores)
{
  const NeighbourDistances distances = neighbourDistances(centres, neighbours);
  scores.clear();
  for (const double distance : distances.means)
    scores.push_back(
        static_cast<float>((distances.mean - distance) / distances.deviation));
}

void
radiusScores(const Centres::ConstPtr& centres,
             double radius,
             std::vector<float>& scores)
{
  countWithin(
      centres, [radius](const pcl::PointXYZI&) { return radius; }, scores);
}

void
rangeRadiusScores(const Centres::ConstPtr& points,
                  const RangeRadius& radius,
                  std::vector<float>& scores)
{
  constexpr double degree = 3.14159265358979323846 / 180.0;
  countWithin(
      points,
      [&radius](const pcl::PointXYZI& point) {
        const double range =
            std::hypot(static_cast<double>(point.x), static_cast<double>(point.y));
        return std::max(radius.least,
                        radius.multiplier * radius.azimuth_step * degree * range);
      },
      scores);
}

void
rangeStatisticsScores(const Centres::ConstPtr& points,
                      const RangeStatistics& statistics,
                      std::vector<float>& scores)
{
  const NeighbourDistances distances =
      neighbourDistances(points, statistics.neighbours);
  const double usual = distances.mean + statistics.deviations * distances.deviation;
  // Returns at the sensor itself, which have no range, are outliers.
  constexpr double least_range = 1e-3;
  scores.clear();
  for (std::size_t i = 0; i < points->size(); ++i) {
    const auto range = static_cast<double>((*points)[i].getVector3fMap().norm());
    scores.push_back(static_cast<float>(-distances.means[i] /
                                        (usual * std::max(range, least_range))));
  }
}

} // namespace noise
} // namespace pcl_ext
