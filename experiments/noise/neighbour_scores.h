// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The scores of published outlier filters, by the neighbours of each point: PCL's
 * and those for lidars in snow. All are low for outliers.
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

/** \brief What pcl::StatisticalOutlierRemoval compares with its multiplier, times -1:
 * the mean distance to some neighbours, less its mean over the cloud, over its standard
 * deviation. */
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

/** \brief Parameters of DROR.
 *
 * Dynamic radius outlier removal: N. Charron, S. Phillips, S. L. Waslander, "De-noising
 * of Lidar Point Clouds Corrupted by Snowfall", CRV 2018. Rule, multiplier and smallest
 * radius are those of the authors' public program.
 */
struct RangeRadius {
  double multiplier = 3.0; ///< beta: radius over the distance of neighbours in a ring
  double azimuth_step = 0.16; ///< of the lidar, degrees
  double least = 0.04;        ///< smallest search radius, metres
};

/** \brief What DROR compares with its least number of neighbours: how many other points
 * are within the radius multiplier * azimuth step * horizontal range of a point, or
 * within the smallest radius if that is more.
 * \param[in] points in the sensor's frame, z up, finite
 */
void
rangeRadiusScores(const Centres::ConstPtr& points,
                  const RangeRadius& radius,
                  std::vector<float>& scores);

/** \brief Parameters of DSOR.
 *
 * Dynamic statistical outlier removal: A. Kurup, J. Bos, "DSOR: A Scalable Statistical
 * Filter for Removing Falling Snow from LiDAR Point Clouds in Severe Winter Weather",
 * arXiv 2109.07078, 2021. The rule is that of the authors' public program; their
 * defaults were not checked.
 */
struct RangeStatistics {
  int neighbours = 5;       ///< k
  double deviations = 0.01; ///< s: of the mean distances, above their mean
};

/** \brief What DSOR compares with its range multiplier r, times -1: the mean distance to
 * k neighbours over (mean + s standard deviations of all mean distances) * range. A
 * point is an outlier if its score is below -r, for example -0.05.
 * \param[in] points in the sensor's frame, finite
 */
void
rangeStatisticsScores(const Centres::ConstPtr& points,
                      const RangeStatistics& statistics,
                      std::vector<float>& scores);

} // namespace noise
} // namespace pcl_ext
