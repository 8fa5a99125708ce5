// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Expected results: the same work done by the library without ROS.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/cloud_sender.h>

#include <gtest/gtest.h>

#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>

#include <map>
#include <string>
#include <vector>

namespace pcl_ext_ros::test {

using Bytes = std::vector<std::uint8_t>;
using Frame = point_cloud_interfaces::msg::CompressedPointCloud2;

/** \brief One stream, encoded by the library for one receiver. */
class DirectStream {
public:
  explicit DirectStream(const pcl_ext::nodes::ParameterValues& values)
  {
    EXPECT_EQ(sender_.setParameters(values), "");
  }

  pcl_ext::nodes::CloudSender&
  sender()
  {
    return sender_;
  }

  Bytes
  encode(const sensor_msgs::msg::PointCloud2& cloud, const pcl_ext::WorldPose& pose)
  {
    pcl::PCLPointCloud2 input;
    pcl_ext::nodes::toPcl(cloud, input);
    Bytes bytes;
    const auto status = sender_.encode(input, pose, 1, bytes);
    EXPECT_TRUE(status.hasFrame()) << status.message();
    return bytes;
  }

  /** \brief The next frame as a message. */
  Frame
  frameOf(const sensor_msgs::msg::PointCloud2& cloud, const pcl_ext::WorldPose& pose)
  {
    Frame frame;
    frame.compressed_data = encode(cloud, pose);
    frame.header.stamp = cloud.header.stamp;
    frame.header.frame_id = "world";
    frame.format = pcl_ext::nodes::messageFormat(pcl_ext::io::StreamFormat::Version1);
    return frame;
  }

private:
  pcl_ext::nodes::CloudSender sender_;
};

/** \brief The data of a PointCloud2 of the voxels. */
inline Bytes
pointsOf(const pcl_ext::io::VoxelFrame& voxels)
{
  sensor_msgs::msg::PointCloud2 message;
  pcl_ext::nodes::writeVoxels(voxels, message);
  return message.data;
}

/** \brief The voxels of an I-frame. */
inline pcl_ext::io::VoxelFrame
decoded(const Bytes& bytes)
{
  pcl_ext::io::VoxelFrame voxels;
  const auto status =
      pcl_ext::io::FrameDecoder().decode(bytes.data(), bytes.size(), voxels);
  EXPECT_TRUE(status.ok()) << status.message();
  return voxels;
}

inline bool
isIFrame(const Bytes& bytes)
{
  pcl_ext::io::VoxelFrame voxels;
  return pcl_ext::io::FrameDecoder().decode(bytes.data(), bytes.size(), voxels).ok();
}

/** \brief The merged voxels of one frame of each stream.
 * \param[in] resolution of the common grid, metres
 * \param[in] frames I-frames, by name of their stream
 */
inline pcl_ext::io::VoxelFrame
mergedDirectly(double resolution, const std::map<std::string, Bytes>& frames)
{
  pcl_ext::nodes::CentralNodeSettings settings;
  settings.resolution = resolution;
  settings.max_merge_age = std::chrono::hours(1);
  pcl_ext::nodes::CentralNode central_node(settings);
  for (const auto& [name, bytes] : frames) {
    EXPECT_TRUE(central_node.addStream(name).ok());
    EXPECT_TRUE(central_node.receive(name, bytes).ok());
  }
  central_node.waitUntilDecoded();
  pcl_ext::io::VoxelFrame merged;
  central_node.merge(merged);
  return merged;
}

} // namespace pcl_ext_ros::test
