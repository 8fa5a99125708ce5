#include "range_filters.h"

#include <pcl/search/kdtree.h>

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace noise {

void
rangeRadiusScores(const Centres::ConstPtr& points,
                  const RangeRadius& radius,
                  std::vector<float>& scores)
{
  constexpr double degree = 3.14159265358979323846 / 180.0;
  pcl::search::KdTree<pcl::PointXYZI> tree(false);
  tree.setInputCloud(points);
  pcl::Indices indices;
  std::vector<float> squared_distances;
  scores.clear();
  for (const pcl::PointXYZI& point : *points) {
    const double range =
        std::hypot(static_cast<double>(point.x), static_cast<double>(point.y));
    const double reach = std::max(
        radius.least, radius.multiplier * radius.azimuth_step * degree * range);
    // Without the point itself.
    scores.push_back(static_cast<float>(
        tree.radiusSearch(point, reach, indices, squared_distances) - 1));
  }
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
