/** \file
 * \brief PCL's outlier filters on the centres of voxels, or on points.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <vector>

namespace pcl_ext {
namespace noise {

using Centres = pcl::PointCloud<pcl::PointXYZI>;

/** \brief Voxels as the points that a decoder makes of them. */
Centres::Ptr
centresOf(const io::VoxelFrame& frame);

/** \brief Mean distance of each point to its nearest others, metres, and what it is over
 * all points. */
struct NeighbourDistances {
  std::vector<double> means; ///< of each point
  double mean = 0.0;
  double deviation = 0.0; ///< standard deviation
};

/** \brief Mean distances to some nearest neighbours. */
NeighbourDistances
neighbourDistances(const Centres::ConstPtr& centres, int neighbours);

/** \brief What pcl::StatisticalOutlierRemoval compares with its multiplier, times -1:
 * the mean distance to some neighbours, less its mean over the cloud, over its standard
 * deviation. Low for outliers. */
void
statisticalScores(const Centres::ConstPtr& centres,
                  int neighbours,
                  std::vector<float>& scores);

/** \brief What pcl::RadiusOutlierRemoval compares with its least number of neighbours:
 * how many there are within a radius, metres. */
void
radiusScores(const Centres::ConstPtr& centres,
             double radius,
             std::vector<float>& scores);

/** \brief CPU seconds that PCL's own filters take for one cloud. */
double
statisticalSeconds(const Centres::ConstPtr& centres, int neighbours);
double
radiusSeconds(const Centres::ConstPtr& centres, double radius);

} // namespace noise
} // namespace pcl_ext
