/** \file
 * \brief A simulated sensor, its compressor and the central node.
 */
#pragma once

#include <pcl_ext/nodes/sensor_node.h>
#include <pcl_ext/rigid_pose.h>

#include "diagnostics.h"
#include "direct_library.h"
#include "node_process.h"
#include "recorder.h"
#include "sensor_input.h"

#include <gtest/gtest.h>

#include <pcl_ext_ros1/CompressedPointCloud2.h>
#include <ros/node_handle.h>
#include <sensor_msgs/PointCloud2.h>

#include <optional>
#include <string>

namespace pcl_ext_ros1 {
namespace test {

/** \brief Parameters of a compressor with a fixed grid, so that the voxels depend on
 * one cloud only, and with a long timeout for transforms. */
Parameters
compressorParameters();

/** \brief The same as settings of the library. */
pcl_ext::nodes::SensorNodeSettings
compressorSettings();

/** \brief Nodes and topics are in a namespace with the name of the test, as the master
 * keeps parameters and topics of earlier tests. */
class StreamScenario : public ::testing::Test {
protected:
  StreamScenario();

  /** \brief A name in the namespace of the test. */
  std::string
  full(const std::string& name) const;

  /** \brief Starts the compressor and waits until it is connected.
   * \param[in] changes of compressorParameters()
   */
  void
  startCompressor(const Parameters& changes = {});

  /** \brief Starts the decompressor and waits until it is connected with the
   * compressor, if there is one.
   * \param[in] parameters besides ~streams, which is the compressor's by default
   */
  void
  startDecompressor(const Parameters& parameters = {});

  /** \brief Starts both nodes. The sensor is in `pose`. */
  void
  startBoth(const Parameters& compressor_changes = {},
            const Parameters& decompressor_parameters = {});

  template <typename PointT = pcl::PointXYZ>
  sensor_msgs::PointCloud2
  cloud(std::uint32_t number) const
  {
    return makeCloud<PointT>(number, sensor_frame);
  }

  /** \brief Publishes a cloud and waits for its frame.
   * \return null if there is no frame in time, or the test has failed already
   */
  CompressedPointCloud2::ConstPtr
  compress(const sensor_msgs::PointCloud2& cloud);

  /** \brief Publishes a cloud and waits for its voxels.
   * \return null if there are no voxels in time, or the test has failed already
   */
  sensor_msgs::PointCloud2::ConstPtr
  show(const sensor_msgs::PointCloud2& cloud);

  /** \brief Publishes a cloud; expects these voxels with its stamp in the world
   * frame. */
  void
  expectVoxels(const sensor_msgs::PointCloud2& cloud, const Voxels& expected);

  /** \brief Publishes the clouds [begin, end); expects of each what `direct` makes of
   * it at `pose`. */
  void
  expectClouds(std::uint32_t begin, std::uint32_t end);

  const std::string space;        // namespace of the test
  const std::string sensor_frame; // of this test only, as all tests share TF
  const std::string input;        // topics
  const std::string compressed;
  const pcl_ext::WorldPose pose;
  ros::NodeHandle node;
  StaticTransforms transforms;
  ros::Publisher clouds;
  Recorder<CompressedPointCloud2> frames;
  Recorder<sensor_msgs::PointCloud2> voxels;
  Diagnostics compressor_health;
  Diagnostics decompressor_health;
  DirectStream direct{compressorSettings()};
  std::optional<NodeProcess> compressor;
  std::optional<NodeProcess> decompressor;
};

} // namespace test
} // namespace pcl_ext_ros1
