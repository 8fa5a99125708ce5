// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds.h"
#include "direct_library.h"
#include "running_nodes.h"

#include <gtest/gtest.h>

#include <pcl_ext_ros/cloud_sender_node.hpp>
#include <pcl_ext_ros/merging_centre_node.hpp>
#include <pcl_ext_ros_common/tf_node.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2_ros/static_transform_broadcaster.hpp>

#include <algorithm>
#include <array>
#include <cstring>

namespace pcl_ext_ros::test {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::PointCloud2;

namespace {

constexpr std::size_t sensors = 6;

std::string
frameIdOf(std::size_t sensor)
{
  return "kinect_" + std::to_string(sensor + 1);
}

std::string
topicOf(std::size_t sensor)
{
  return "/" + frameIdOf(sensor) + "/points/pcl_ext";
}

std::string
voxelsOf(std::size_t sensor)
{
  return "/central_node" + topicOf(sensor) + "/voxels";
}

/** \brief Points of x, y, z and intensity: the order of merged voxels depends on the
 * frames before. */
std::vector<std::array<float, 4>>
sortedPoints(const Bytes& data)
{
  std::vector<std::array<float, 4>> points(data.size() / 16);
  std::memcpy(points.data(), data.data(), 16 * points.size());
  std::sort(points.begin(), points.end());
  return points;
}

/** \brief Six sensor nodes and the central node in this process, without copies. */
class Composition {
public:
  Composition()
  {
    std::string streams;
    for (std::size_t i = 0; i < sensors; ++i) {
      nodes_.add<CloudSenderNode>(
          optionsOf({"-r",
                     "__ns:=/" + frameIdOf(i),
                     "-r",
                     "input:=points",
                     "-p",
                     "resolution:=0.1",
                     "-p",
                     "intensity:=count",
                     "-p",
                     "crop_box:=[-20.0, -20.0, -20.0, 20.0, 20.0, "
                     "20.0]",
                     "-p",
                     "queue_size:=100",
                     "-p",
                     "tf_timeout:=10.0"})
              .use_intra_process_comms(true));
      streams += (streams.empty() ? "" : ",") + topicOf(i);
    }
    const auto central =
        nodes_.add<MergingCentreNode>(optionsOf({"-p",
                                                 "streams:=[" + streams + "]",
                                                 "-p",
                                                 "resolution:=0.1",
                                                 "-p",
                                                 "merge_rate:=50.0",
                                                 "-p",
                                                 "max_merge_age:=3600.0",
                                                 "-p",
                                                 "map_rate:=50.0"})
                                          .use_intra_process_comms(true));
    central_ = central;
    tester = nodes_.add<Tester>(rclcpp::NodeOptions().use_intra_process_comms(true));
    transforms_.emplace(
        pcl_ext_ros_common::tfNode<tf2_ros::StaticTransformBroadcaster>(*tester));
    for (std::size_t i = 0; i < sensors; ++i) {
      clouds[i] = tester->create_publisher<PointCloud2>("/" + frameIdOf(i) + "/points",
                                                        rclcpp::QoS(100));
      voxels[i].emplace(*tester, voxelsOf(i));
      transforms_->sendTransform(toMessage(
          frameIdOf(i), samplePose(0.1 * static_cast<double>(i)), tester->now()));
    }
    merged.emplace(*tester, "/central_node/merged");
    diagnostics.emplace(*tester, "/diagnostics");
    nodes_.start();
  }

  /** \brief Waits until all are connected. */
  bool
  connect()
  {
    bool is_connected = merged->waitForPublisher() && diagnostics->waitForPublisher();
    for (std::size_t i = 0; i < sensors; ++i)
      is_connected = is_connected && voxels[i]->waitForPublisher() && waitUntil([&] {
                       return clouds[i]->get_subscription_count() == 1 &&
                              tester->count_subscribers(topicOf(i)) == 1 &&
                              tester->count_publishers(topicOf(i)) == 1 &&
                              central_.lock()->count_subscribers(voxelsOf(i)) == 1;
                     });
    return is_connected;
  }

  /** \brief Unloads the first node: the sensors' in their order, then the central
   * one. */
  void
  unloadFirst()
  {
    nodes_.unload(0);
  }

  rclcpp::Node::SharedPtr tester;
  std::array<rclcpp::Publisher<PointCloud2>::SharedPtr, sensors> clouds;
  std::array<std::optional<Recorder<PointCloud2>>, sensors> voxels;
  std::optional<Recorder<PointCloud2>> merged;
  std::optional<Recorder<DiagnosticArray>> diagnostics;

private:
  std::optional<tf2_ros::StaticTransformBroadcaster> transforms_;
  std::weak_ptr<MergingCentreNode> central_;
  // Last member, as the callbacks of its thread use the others.
  RunningNodes nodes_{std::make_unique<rclcpp::executors::MultiThreadedExecutor>(
      rclcpp::ExecutorOptions(), 4)};
};

} // namespace

TEST(Composition, SixSensorsAndTheCentralNodeInOneProcess)
{
  Composition composition;
  ASSERT_TRUE(composition.connect());
  for (const auto& clouds : composition.clouds)
    EXPECT_EQ(clouds->get_intra_process_subscription_count(), 1u);
  // Of the same times, which are those of merged clouds, too.
  const rclcpp::Duration period = std::chrono::milliseconds(20);
  rclcpp::Time stamp = roundedDown(composition.tester->now(), period);
  std::uint32_t frames = 0;
  // Merging begins when the node has seen that there is a subscriber, at first with those
  // streams whose frames arrived since.
  for (; frames < 20 || (composition.merged->count() < 3 && frames < 1000); ++frames) {
    stamp += period;
    for (std::size_t i = 0; i < sensors; ++i)
      composition.clouds[i]->publish(
          std::make_unique<PointCloud2>(makeCloud(frames, frameIdOf(i), stamp)));
    // Not faster than the voxels' queues.
    for (std::size_t i = 0; i < sensors; ++i)
      ASSERT_TRUE(waitUntil([&] { return composition.voxels[i]->count() > frames; }))
          << i << " " << frames;
  }
  std::map<std::string, Bytes> last_frames;
  for (std::size_t i = 0; i < sensors; ++i) {
    EXPECT_EQ(composition.voxels[i]->count(), frames);
    const auto last = composition.voxels[i]->messages().back();
    DirectStream direct({{"resolution", 0.1},
                         {"intensity", std::string("count")},
                         {"crop_box", std::vector<double>{-20, -20, -20, 20, 20, 20}}});
    last_frames[topicOf(i)] = direct.encode(makeCloud(frames - 1, frameIdOf(i), stamp),
                                            samplePose(0.1 * static_cast<double>(i)));
    EXPECT_EQ(last.data, pointsOf(decoded(last_frames[topicOf(i)]))) << i;
  }
  // What is merged already may be of earlier frames.
  const auto expected = sortedPoints(pointsOf(mergedDirectly(0.1, last_frames)));
  EXPECT_TRUE(waitUntil([&] {
    const auto merged = composition.merged->messages();
    return !merged.empty() && sortedPoints(merged.back().data) == expected;
  }));
  EXPECT_TRUE(waitForStatus(*composition.diagnostics,
                            "central_node: all streams",
                            DiagnosticStatus::OK,
                            "OK"));
}

TEST(Composition, NodesEndWhileCloudsArrive)
{
  for (int round = 0; round < 3; ++round) {
    Composition composition;
    ASSERT_TRUE(composition.connect());
    for (std::uint32_t frame = 0; frame < 5; ++frame)
      for (std::size_t i = 0; i < sensors; ++i)
        composition.clouds[i]->publish(std::make_unique<PointCloud2>(
            makeCloud(frame, frameIdOf(i), composition.tester->now())));
    ASSERT_TRUE(waitUntil([&] { return composition.voxels[0]->count() != 0; }));
  }
}

TEST(Composition, NodesAreUnloadedWhileOthersRun)
{
  Composition composition;
  ASSERT_TRUE(composition.connect());
  for (std::uint32_t frame = 0; frame < 3 * (sensors + 1); ++frame) {
    const std::size_t known = composition.voxels[sensors - 1]->count();
    for (std::size_t i = 0; i < sensors; ++i)
      composition.clouds[i]->publish(std::make_unique<PointCloud2>(
          makeCloud(frame, frameIdOf(i), composition.tester->now())));
    // The last sensor's node is the last but one to go.
    const std::size_t unloaded = frame / 3;
    if (unloaded < sensors) {
      EXPECT_TRUE(composition.voxels[sensors - 1]->next(known));
    }
    if (frame % 3 == 2)
      composition.unloadFirst();
  }
}

} // namespace pcl_ext_ros::test
