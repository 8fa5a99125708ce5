/** \file
 * \brief A sensor that the test plays, its compressor, and the central node.
 */
#pragma once

#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/rigid_pose.h>

#include "clouds.h"
#include "connections.h"
#include "direct_library.h"
#include "node_process.h"
#include "recorder.h"
#include "transforms.h"

#include <gtest/gtest.h>

#include <pcl_ext_ros/CompressedPointCloud2.h>
#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud2.h>

#include <optional>
#include <string>

namespace pcl_ext_ros {
namespace test {

/** \brief Parameters of a compressor whose voxels depend on nothing but its cloud: a fixed
 * grid; and all the time in the world for a transform that is on its way. */
Parameters
compressorParameters();

/** \brief The settings that these parameters are for the library. */
pcl_ext::nodes::SensorNodeSettings
compressorSettings();

/** \brief Parameters with some of them replaced, or more. */
Parameters
operator+(Parameters parameters, const Parameters& others);

/** \brief Names of nodes and topics live in a namespace of the test's name, so that what
 * one test leaves with the master is nothing to the next. */
class StreamScenario : public ::testing::Test {
protected:
  StreamScenario();

  /** \brief A name in the test's namespace. */
  std::string
  full(const std::string& name) const;

  void
  startCompressor(const Parameters& parameters = compressorParameters(),
                  const std::vector<std::string>& arguments = {});

  /** \brief Starts the decompressor, connected with the compressor, if there is one.
   * \param[in] parameters besides the streams
   */
  void
  startDecompressor(const Parameters& parameters = {},
                    const std::vector<std::string>& arguments = {});

  /** \brief Both nodes, of a sensor that is in `pose` for ever. */
  void
  startBoth(const Parameters& parameters = compressorParameters());

  template <typename PointT = pcl::PointXYZ>
  sensor_msgs::PointCloud2
  cloud(std::uint32_t number) const
  {
    return makeCloud<PointT>(number, sensor_frame);
  }

  /** \brief Sends a cloud and waits for the frame that it becomes.
   * \return none if there is no frame in time
   */
  CompressedPointCloud2::ConstPtr
  compress(const sensor_msgs::PointCloud2& cloud);

  /** \brief Sends a cloud and waits for the voxels that it becomes.
   * \return none if there are no voxels in time
   */
  sensor_msgs::PointCloud2::ConstPtr
  show(const sensor_msgs::PointCloud2& cloud);

  /** \brief Sends a cloud, and expects these voxels with its stamp in the world frame. */
  void
  expectVoxels(const sensor_msgs::PointCloud2& cloud, const Voxels& expected);

  const std::string space;        // of the test's names
  const std::string sensor_frame; // of this test alone, as there is one TF for all
  const std::string input;        // topics
  const std::string compressed;
  const pcl_ext::WorldPose pose;
  ros::NodeHandle node;
  StaticTransforms transforms;
  ros::Publisher clouds;
  Recorder<CompressedPointCloud2> frames;
  Recorder<sensor_msgs::PointCloud2> voxels;
  std::optional<NodeProcess> compressor;
  std::optional<NodeProcess> decompressor;
};

} // namespace test
} // namespace pcl_ext_ros
