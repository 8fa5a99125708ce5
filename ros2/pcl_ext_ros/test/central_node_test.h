// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The central node with two streams of a test.
 */
#pragma once

#include "clouds.h"
#include "direct_library.h"
#include "running_nodes.h"

#include <gtest/gtest.h>

#include <pcl_ext_ros/merging_centre_node.hpp>
#include <std_msgs/msg/empty.hpp>

namespace pcl_ext_ros::test {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::PointCloud2;

inline const std::string topic_1 = "/kinect_1/points/pcl_ext";
inline const std::string topic_2 = "/kinect_2/points/pcl_ext";
inline const std::string voxels_topic_1 = "/central_node" + topic_1 + "/voxels";
inline const std::string voxels_topic_2 = "/central_node" + topic_2 + "/voxels";

inline pcl_ext::nodes::ParameterValues
coarse()
{
  return {{"resolution", 0.1}, {"intensity", std::string("count")}};
}

/** \brief The central node and one that sends it two streams. */
class MergingCentreNodeTest : public testing::Test {
protected:
  /** \param[in] arguments as those of a command line */
  void
  start(std::vector<std::string> arguments)
  {
    arguments.insert(arguments.end(),
                     {"-p",
                      "streams:=[/kinect_1/points/pcl_ext, kinect_2/points/pcl_ext]",
                      "-p",
                      "resolution:=0.1"});
    node_ = nodes_.add<MergingCentreNode>(optionsOf(arguments));
    tester_ = nodes_.add<Tester>();
    frames_1_ = tester_->create_publisher<Frame>(topic_1, 10);
    frames_2_ = tester_->create_publisher<Frame>(topic_2, 10);
    voxels_1_.emplace(*tester_, voxels_topic_1);
    voxels_2_.emplace(*tester_, voxels_topic_2);
    requests_1_.emplace(*tester_, topic_1 + "/request_i_frame");
    diagnostics_.emplace(*tester_, "/diagnostics");
    nodes_.start();
    ASSERT_TRUE(waitUntil([this] {
      return frames_1_->get_subscription_count() == 1 &&
             frames_2_->get_subscription_count() == 1 &&
             node_->count_subscribers(voxels_topic_1) == 1 &&
             node_->count_subscribers(voxels_topic_2) == 1 &&
             node_->count_subscribers(topic_1 + "/request_i_frame") == 1;
    }));
    ASSERT_TRUE(voxels_1_->waitForPublisher());
    ASSERT_TRUE(voxels_2_->waitForPublisher());
    ASSERT_TRUE(requests_1_->waitForPublisher());
    ASSERT_TRUE(diagnostics_->waitForPublisher());
  }

  void
  TearDown() override
  {
    node_.reset();
    nodes_.stop();
  }

  /** \brief Sends a frame of the first stream and waits for its voxels. */
  std::optional<PointCloud2>
  send(const Frame& frame)
  {
    const std::size_t known = voxels_1_->count();
    frames_1_->publish(frame);
    return voxels_1_->next(known);
  }

  Frame
  iFrame(std::uint32_t number)
  {
    return DirectStream(coarse()).frameOf(makeCloud(number, "world", now()),
                                          samplePose(0.1 * number));
  }

  std::string
  set(const std::string& name, const rclcpp::ParameterValue& value)
  {
    const auto result = node_->set_parameter(rclcpp::Parameter(name, value));
    EXPECT_EQ(result.successful, result.reason.empty()) << result.reason;
    return result.reason;
  }

  rclcpp::Time
  now() const
  {
    return tester_->now();
  }

  RunningNodes nodes_{std::make_unique<rclcpp::executors::MultiThreadedExecutor>()};
  std::shared_ptr<MergingCentreNode> node_;
  std::shared_ptr<Tester> tester_;
  rclcpp::Publisher<Frame>::SharedPtr frames_1_;
  rclcpp::Publisher<Frame>::SharedPtr frames_2_;
  std::optional<Recorder<PointCloud2>> voxels_1_;
  std::optional<Recorder<PointCloud2>> voxels_2_;
  std::optional<Recorder<std_msgs::msg::Empty>> requests_1_;
  std::optional<Recorder<DiagnosticArray>> diagnostics_;
};

/** \brief The voxels of a frame whose intensity is large enough. */
inline std::size_t
countFrom(const Frame& frame, float min_intensity)
{
  std::size_t count = 0;
  pcl_ext::io::forEachVoxelCentre(decoded(frame.compressed_data),
                                  [&](float, float, float, float intensity) {
                                    count += intensity >= min_intensity ? 1 : 0;
                                  });
  return count;
}

} // namespace pcl_ext_ros::test
