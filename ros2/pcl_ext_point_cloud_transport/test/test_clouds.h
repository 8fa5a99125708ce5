// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds of the tests, and what the library makes of them without ROS.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/PCLPointCloud2.h>

#include <sensor_msgs/msg/point_cloud2.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace pcl_ext_point_cloud_transport::test {

using Cloud = sensor_msgs::msg::PointCloud2;
using Stamp = builtin_interfaces::msg::Time;

/** \brief Half the edge of the crop box of a Sender, metres. */
constexpr double box_edge = 10.0;

/** \brief Layouts of clouds. */
enum class Layout {
  Xyz,        ///< 12 bytes
  XyzPadded,  ///< 16 bytes, as PCL's PointXYZ
  Xyzi,       ///< PCL's PointXYZI: 32 bytes
  XyziPacked, ///< 16 bytes
  XyzRgb,     ///< PCL's PointXYZRGB: 32 bytes
  Lidar,      ///< intensity as UINT16, ring, time as FLOAT64, not aligned
  XyzRgbi,    ///< colours and intensities
  Organized,  ///< Xyz as an image of several rows
  PaddedRows, ///< Xyzi as an image with bytes after each row
};

constexpr std::array<Layout, 9> all_layouts{Layout::Xyz,
                                            Layout::XyzPadded,
                                            Layout::Xyzi,
                                            Layout::XyziPacked,
                                            Layout::XyzRgb,
                                            Layout::Lidar,
                                            Layout::XyzRgbi,
                                            Layout::Organized,
                                            Layout::PaddedRows};

bool
hasIntensity(Layout layout);

Stamp
stampOf(std::uint32_t number);

/** \brief A noisy wall and a ball that moves in front of it, with some points that are
 * not finite and some that are noise. Points and stamp depend on the number only. */
Cloud
makeCloud(std::uint32_t number, Layout layout = Layout::Xyz);

pcl::PCLPointCloud2
toPcl(const Cloud& cloud);

/** \brief Voxels as points x, y, z, intensity, colour (0: none), in their order. */
using Voxels = std::vector<std::array<float, 5>>;

/** \brief The points of a cloud of any layout of these. */
Voxels
voxelsIn(const Cloud& message);

Voxels
voxelsIn(const pcl_ext::io::VoxelFrame& frame);

/** \brief Settings of a Sender without overrides for clouds with or without
 * intensity. */
pcl_ext::nodes::SensorNodeSettings
defaultSettings(Layout layout = Layout::Xyz);

/** \brief The same stream, encoded and decoded by the library alone. */
class DirectStream {
public:
  explicit DirectStream(const pcl_ext::nodes::SensorNodeSettings& settings);

  /** \brief The next cloud, encoded and decoded. */
  pcl_ext::io::VoxelFrame
  frameOf(const Cloud& cloud);

  Voxels
  voxelsOf(const Cloud& cloud)
  {
    return voxelsIn(frameOf(cloud));
  }

private:
  pcl_ext::nodes::SensorNode sensor_node_;
  pcl_ext::io::FrameDecoder decoder_;
};

/** \brief The voxels of a cloud that is the first one of its stream. */
Voxels
directVoxels(const Cloud& cloud, const pcl_ext::nodes::SensorNodeSettings& settings);

} // namespace pcl_ext_point_cloud_transport::test
