// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/rigid_pose.h>

#include "support/cloud_streams.h"
#include "support/naive_preprocessing.h"
#include "support/status_codes.h"
#include "support/world_voxels.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Bytes = std::vector<std::uint8_t>;
using pcl_ext::test::expectCode;
using pcl_ext::test::naivelyPreprocessed;
constexpr double resolution = 0.04;

// 2^6 voxels wide about the origin, so that PCL's lattice for it is the world's.
inline const io::BoundingBox wide_box{{-1.28, -1.28, -1.28}, {1.28, 1.28, 1.28}};

// Through the middle of the clouds, along faces of voxels.
inline const io::BoundingBox narrow_box{{-0.12, -1.0, -0.08}, {1.0, 0.16, 0.2}};

/** \brief Where a sensor is that moves from frame to frame; about 3 m off the
 * origin. */
inline WorldPose
poseOf(unsigned int frame)
{
  WorldPose pose = WorldPose::Identity();
  pose.translate(Eigen::Vector3d(0.4 + 0.37 * frame, -3.1, 0.25 * frame));
  pose.rotate(Eigen::AngleAxisd(-1.5 + 0.2 * frame, Eigen::Vector3d::UnitX()));
  pose.rotate(Eigen::AngleAxisd(0.3 * frame, Eigen::Vector3d::UnitZ()));
  return pose;
}

/** \brief Points about the world origin, in the sensor's frame; most voxels hold
 * several. None is near a face of its voxel, so that rounding does not decide where it
 * is.
 * \param[in] half_width of the cube that they lie in, voxels
 */
inline Cloud
cloudSeenFrom(const WorldPose& pose,
              unsigned int seed,
              std::size_t size = 1500,
              int half_width = 6)
{
  std::mt19937 generator(seed);
  std::uniform_int_distribution<int> voxel(-half_width, half_width - 1);
  std::uniform_real_distribution<double> offset(0.1, 0.9);
  std::uniform_int_distribution<int> intensity(0, 200);
  const WorldPose world_to_sensor = pose.inverse(Eigen::Isometry);
  Cloud cloud;
  for (std::size_t i = 0; i < size; ++i) {
    Eigen::Vector3d place;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      place[axis] = (voxel(generator) + offset(generator)) * resolution;
    const Eigen::Vector3f seen = (world_to_sensor * place).cast<float>();
    pcl::PointXYZI point;
    point.getVector3fMap() = seen;
    point.intensity = static_cast<float>(intensity(generator));
    cloud.push_back(point);
  }
  return cloud;
}

template <typename PointT>
pcl::PCLPointCloud2
messageOf(const pcl::PointCloud<PointT>& cloud, std::uint64_t stamp = 0)
{
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  message.header.stamp = stamp;
  message.header.frame_id = "sensor";
  return message;
}

inline double
naiveCount(const pcl::PointXYZI&)
{
  return 1.0;
}

/** \brief A Kinect V2 whose figures come from a file. */
inline RuntimeSensor
runtimeKinect()
{
  return {70.6, 60.0, 512, 424};
}

inline SensorNodeSettings
settingsOf(IntensityLaw law)
{
  SensorNodeSettings settings;
  settings.law = law;
  settings.compression.resolution = resolution;
  if (law == IntensityLaw::Quadratic || law == IntensityLaw::Linear)
    settings.sensor = runtimeKinect();
  return settings;
}

/** \brief Encodes a cloud with its transform; earlier bytes are replaced. */
inline Bytes
encoded(SensorNode& node, const pcl::PCLPointCloud2& cloud, const WorldPose& pose)
{
  Bytes bytes(7, 0xee);
  const SensorNodeStatus status = node.encode(cloud, pose, bytes);
  EXPECT_TRUE(status) << status; // with or without a warning
  EXPECT_FALSE(bytes.empty());
  return bytes;
}

inline io::VoxelFrame
decodedWith(io::FrameDecoder& decoder, const Bytes& bytes)
{
  io::VoxelFrame frame;
  const io::CompressionStatus status =
      decoder.decode(bytes.data(), bytes.size(), frame);
  EXPECT_TRUE(status.ok()) << status.message();
  return frame;
}

inline void
expectLeftOut(SensorNode& node,
              const pcl::PCLPointCloud2& cloud,
              const std::optional<WorldPose>& pose,
              SensorNodeCode code)
{
  Bytes bytes(7, 0xee);
  const SensorNodeStatus status = node.encode(cloud, pose, bytes);
  expectCode(status, code);
  EXPECT_FALSE(status.hasFrame());
  EXPECT_TRUE(bytes.empty());
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test
