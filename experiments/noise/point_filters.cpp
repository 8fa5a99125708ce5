#include "point_filters.h"

#include "measuring/machine.h"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/search/kdtree.h>

#include <cmath>
#include <cstddef>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief CPU seconds of one of PCL's filters for one cloud. */
template <typename FilterT>
double
secondsOf(FilterT& removal, const Centres::ConstPtr& centres)
{
  Centres kept;
  const double start = measuring::processCpuSeconds();
  removal.setInputCloud(centres);
  removal.filter(kept);
  return measuring::processCpuSeconds() - start;
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
  pcl::search::KdTree<pcl::PointXYZI> tree(false);
  tree.setInputCloud(centres);
  pcl::Indices indices;
  std::vector<float> squared_distances;
  scores.clear();
  for (const pcl::PointXYZI& point : *centres)
    scores.push_back(static_cast<float>(
        tree.radiusSearch(point, radius, indices, squared_distances) - 1));
}

double
statisticalSeconds(const Centres::ConstPtr& centres, int neighbours)
{
  pcl::StatisticalOutlierRemoval<pcl::PointXYZI> removal;
  removal.setMeanK(neighbours);
  removal.setStddevMulThresh(1.0);
  return secondsOf(removal, centres);
}

double
radiusSeconds(const Centres::ConstPtr& centres, double radius)
{
  pcl::RadiusOutlierRemoval<pcl::PointXYZI> removal;
  removal.setRadiusSearch(radius);
  removal.setMinNeighborsInRadius(5);
  return secondsOf(removal, centres);
}

} // namespace noise
} // namespace pcl_ext
