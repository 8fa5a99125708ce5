// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace pcl_ext::test {

using PointIntensity = std::function<double(const pcl::PointXYZI&)>;

/** \brief Share of a voxel face that a pixel of a Kinect V2 covers (section 2.5.2 of
 * the paper); its root is the linear law (section 2.5.3).
 * \param[in] depth metres
 * \param[in] resolution voxel edge, metres
 */
inline double
kinectShare(double depth, double resolution)
{
  const double pi = std::acos(-1.0);
  const double footprint =
      4.0 * std::tan(35.3 * pi / 180.0) * std::tan(30.0 * pi / 180.0) / (512.0 * 424.0);
  const double positive_depth = std::max(depth, 0.0);
  return std::min(
      footprint * positive_depth * positive_depth / (resolution * resolution), 1.0);
}

/** \brief Poses that are no rotation and translation by floats. */
template <typename PoseT>
std::vector<PoseT>
invalidPoses(const PoseT& valid)
{
  constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
  std::vector<PoseT> poses(8, valid);
  poses[0].linear() *= 1.01;
  poses[1].linear()(0, 1) += 0.1;
  poses[2].linear().col(2) *= -1.0; // a mirror
  poses[3].linear().setZero();
  poses[4].linear()(1, 1) = nan_value;
  poses[5].translation().y() = nan_value;
  poses[6].translation().z() = -std::numeric_limits<double>::infinity();
  poses[7].translation().x() = 1e300; // beyond the floats
  return poses;
}

inline double
naiveNative(const pcl::PointXYZI& point)
{
  return static_cast<double>(point.intensity);
}

/** \brief The finite points of a cloud, moved, cropped, each with its intensity. */
template <typename PoseT>
pcl::PointCloud<pcl::PointXYZI>
naivelyPreprocessed(const pcl::PointCloud<pcl::PointXYZI>& cloud,
                    const PoseT& pose,
                    const PointIntensity& intensity_of,
                    const std::optional<io::BoundingBox>& box = std::nullopt)
{
  pcl::PointCloud<pcl::PointXYZI> preprocessed;
  for (const pcl::PointXYZI& point : cloud) {
    const Eigen::Vector3d place = pose * point.getVector3fMap().cast<double>();
    bool is_inside = place.allFinite();
    for (std::size_t axis = 0; box && axis < 3; ++axis) {
      const double coordinate = place[static_cast<Eigen::Index>(axis)];
      is_inside &= box->min[axis] <= coordinate && coordinate <= box->max[axis];
    }
    if (!is_inside)
      continue;
    pcl::PointXYZI moved;
    moved.getVector3fMap() = place.cast<float>();
    moved.intensity = static_cast<float>(intensity_of(point));
    preprocessed.push_back(moved);
  }
  return preprocessed;
}

} // namespace pcl_ext::test
