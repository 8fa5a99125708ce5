// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/forged_frames.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace pcl_ext::io::test {

struct OrganisedCloud {
  std::uint32_t width;
  std::uint32_t height;
  std::vector<float> coordinates;
  WorldPose pose = WorldPose::Identity();
};

/** \brief A camera before a wall with steps: depths in whole millimetres, and pixels
 * without a point. */
inline OrganisedCloud
cameraCloud(const WorldPose& pose, std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  OrganisedCloud cloud{80, 60, {}, pose};
  for (std::uint32_t row = 0; row < cloud.height; ++row)
    for (std::uint32_t column = 0; column < cloud.width; ++column) {
      const double depth = 1e-3 * static_cast<double>(1200 + 3 * column +
                                                      row / 20 * 70 + below(random, 3));
      const Eigen::Vector3d point =
          pose * Eigen::Vector3d((column - 39.5) / 61.0 * depth,
                                 (row - 28.0) / 60.5 * depth,
                                 depth);
      const bool is_missing = below(random, 9) == 0 || (row > 40 && column < 9);
      for (int axis = 0; axis < 3; ++axis)
        cloud.coordinates.push_back(is_missing ? std::numeric_limits<float>::quiet_NaN()
                                               : static_cast<float>(point[axis]));
    }
  return cloud;
}

/** \brief A lidar in a room of rounded corners, whose rows begin at different angles;
 * ranges are whole steps of 2 mm from the lens, which turns around the axis. */
inline OrganisedCloud
lidarCloud(const WorldPose& pose, std::uint64_t seed)
{
  std::mt19937_64 random(seed);
  OrganisedCloud cloud{256, 16, {}, pose};
  for (std::uint32_t row = 0; row < cloud.height; ++row)
    for (std::uint32_t column = 0; column < cloud.width; ++column) {
      const double angle = -2.0 * M_PI * column / cloud.width + 0.01 * (row % 4);
      const double elevation = 0.02 * row - 0.11;
      const double range = 0.002 * std::round((4.0 + std::cos(3.0 * angle)) / 0.002 +
                                              static_cast<double>(below(random, 4)));
      const Eigen::Vector3d lens(
          0.015 * std::cos(angle + 0.3), 0.015 * std::sin(angle + 0.3), 0.04);
      const Eigen::Vector3d point =
          pose * (lens + range * Eigen::Vector3d(std::cos(elevation) * std::cos(angle),
                                                 std::cos(elevation) * std::sin(angle),
                                                 std::sin(elevation)));
      const bool is_missing = below(random, 7) == 0;
      for (int axis = 0; axis < 3; ++axis)
        cloud.coordinates.push_back(is_missing ? std::numeric_limits<float>::quiet_NaN()
                                               : static_cast<float>(point[axis]));
    }
  return cloud;
}

inline PointView
viewOf(const OrganisedCloud& cloud)
{
  PointView view;
  view.count = cloud.coordinates.size() / 3;
  view.coordinates = cloud.coordinates.data();
  view.coordinate_stride = 3 * sizeof(float);
  view.image = {cloud.width, cloud.height};
  return view;
}

inline EncoderSettings
fineSettings(Effort effort = Effort::Fast)
{
  EncoderSettings settings;
  settings.resolution = 0.001;
  settings.effort = effort;
  settings.keep_points = true;
  settings.i_frame_rate = 3;
  return settings;
}

/** \brief Bytes of a cloud's frame; what it is decoded to is checked against the cloud.
 */
inline std::size_t
expectCloud(CloudEncoder& encoder, FrameDecoder& decoder, const OrganisedCloud& cloud)
{
  Bytes bytes;
  EXPECT_TRUE(encoder.encode(viewOf(cloud), {cloud.pose}, bytes).ok());
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
  expectSameFrame(back, encoder.frame());
  EXPECT_EQ(back.cloudWidth(), cloud.width);
  EXPECT_EQ(back.cloudHeight(), cloud.height);
  if (!back.points.areThere()) {
    ADD_FAILURE() << "it was coded as voxels";
    return bytes.size();
  }
  std::vector<bool> is_there(back.cloudSize());
  for (std::size_t point = 0; point < back.pointCount(); ++point) {
    const std::size_t index = back.cloudIndex(point);
    is_there[index] = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(back.points.positions[point][axis],
                  cloud.coordinates[3 * index + axis],
                  0.500001 * back.grid.resolution);
  }
  for (std::size_t i = 0; i < is_there.size(); ++i)
    EXPECT_EQ(is_there[i], std::isfinite(cloud.coordinates[3 * i])) << i;
  return bytes.size();
}

inline WorldPose
slantedPose()
{
  WorldPose pose = WorldPose::Identity();
  pose.translate(Eigen::Vector3d(2.0, -1.0, 1.5));
  pose.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()));
  return pose;
}

} // namespace pcl_ext::io::test
