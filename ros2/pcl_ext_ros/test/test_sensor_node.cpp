// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds.h"
#include "direct_library.h"
#include "running_nodes.h"

#include <gtest/gtest.h>

#include <pcl_ext_ros/cloud_sender_node.hpp>
#include <pcl_ext_ros_common/tf_node.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2_ros/static_transform_broadcaster.hpp>
#include <tf2_ros/transform_broadcaster.hpp>

namespace pcl_ext_ros::test {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using pcl_ext::nodes::ParameterValues;
using sensor_msgs::msg::PointCloud2;
using std_srvs::srv::Trigger;

namespace {

/** \brief A sensor's node and one that sends it clouds. */
class CloudSenderNodeTest : public testing::Test {
protected:
  /** \param[in] arguments as those of a command line */
  void
  start(std::vector<std::string> arguments)
  {
    arguments.insert(arguments.end(), {"-r", "input:=/kinect_1/points"});
    node_ = nodes_.add<CloudSenderNode>(optionsOf(arguments));
    tester_ = nodes_.add<Tester>();
    static_transforms_.emplace(
        pcl_ext_ros_common::tfNode<tf2_ros::StaticTransformBroadcaster>(*tester_));
    transforms_.emplace(
        pcl_ext_ros_common::tfNode<tf2_ros::TransformBroadcaster>(*tester_));
    clouds_ = tester_->create_publisher<PointCloud2>("/kinect_1/points", 10);
    requests_ = tester_->create_publisher<std_msgs::msg::Empty>(
        "/kinect_1/points/pcl_ext/request_i_frame", 10);
    frames_.emplace(*tester_, "/kinect_1/points/pcl_ext");
    diagnostics_.emplace(*tester_, "/diagnostics");
    nodes_.start();
    ASSERT_TRUE(waitUntil([this] {
      return clouds_->get_subscription_count() == 1 &&
             node_->count_subscribers("/kinect_1/points/pcl_ext") == 1 &&
             requests_->get_subscription_count() == 1;
    }));
    ASSERT_TRUE(frames_->waitForPublisher());
    ASSERT_TRUE(diagnostics_->waitForPublisher());
  }

  void
  TearDown() override
  {
    nodes_.stop();
  }

  /** \brief Sends a cloud and waits for its frame. */
  std::optional<Frame>
  send(const PointCloud2& cloud)
  {
    const std::size_t known = frames_->count();
    clouds_->publish(cloud);
    return frames_->next(known);
  }

  rcl_interfaces::msg::SetParametersResult
  set(const std::string& name, const rclcpp::ParameterValue& value)
  {
    return node_->set_parameter(rclcpp::Parameter(name, value));
  }

  rclcpp::Time
  now() const
  {
    return tester_->now();
  }

  RunningNodes nodes_;
  std::shared_ptr<CloudSenderNode> node_;
  std::shared_ptr<Tester> tester_;
  std::optional<tf2_ros::StaticTransformBroadcaster> static_transforms_;
  std::optional<tf2_ros::TransformBroadcaster> transforms_;
  rclcpp::Publisher<PointCloud2>::SharedPtr clouds_;
  rclcpp::Publisher<std_msgs::msg::Empty>::SharedPtr requests_;
  std::optional<Recorder<Frame>> frames_;
  std::optional<Recorder<DiagnosticArray>> diagnostics_;
};

const ParameterValues coarse{{"resolution", 0.1}, {"intensity", std::string("count")}};
const std::vector<std::string> coarse_arguments = {
    "-p", "resolution:=0.1", "-p", "intensity:=count"};

std::vector<std::string>
coarseWith(std::vector<std::string> more)
{
  more.insert(more.end(), coarse_arguments.begin(), coarse_arguments.end());
  return more;
}

} // namespace

TEST_F(CloudSenderNodeTest, FramesAreThoseOfTheLibrary)
{
  start({"-p",
         "resolution:=0.05",
         "-p",
         "i_frame_rate:=3",
         "-p",
         "crop_box:=[-10.0, -10.0, -10.0, 10.0, 10.0, 10.0]",
         "-p",
         "tf_timeout:=10.0"});
  DirectStream direct({{"resolution", 0.05},
                       {"i_frame_rate", std::int64_t{3}},
                       {"crop_box", std::vector<double>{-10, -10, -10, 10, 10, 10}}});
  static_transforms_->sendTransform(toMessage("kinect_1", samplePose(0.0), now()));
  pcl_ext::io::FrameDecoder decoder;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const PointCloud2 cloud = makeCloud(i, "kinect_1", now());
    const auto frame = send(cloud);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->compressed_data, direct.encode(cloud, samplePose(0.0))) << i;
    EXPECT_EQ(frame->header.stamp, cloud.header.stamp);
    EXPECT_EQ(frame->header.frame_id, "world");
    EXPECT_EQ(frame->format, "pcl_ext/version1");
    pcl_ext::io::VoxelFrame voxels;
    decoder.decode(
        frame->compressed_data.data(), frame->compressed_data.size(), voxels);
    EXPECT_EQ(frame->width, voxels.size());
    EXPECT_EQ(isIFrame(frame->compressed_data), i % 3 == 0) << i;
  }
}

TEST_F(CloudSenderNodeTest, CloudsWithoutTransformAreDroppedAndReported)
{
  start(coarse_arguments);
  clouds_->publish(makeCloud(0, "unknown", now()));
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            "points",
                            DiagnosticStatus::ERROR,
                            "without transform are dropped"));
  EXPECT_EQ(frames_->count(), 0u);
  // Clouds in the global frame need none.
  EXPECT_TRUE(send(makeCloud(1, "world", now())));
}

TEST_F(CloudSenderNodeTest, LostCloudsAreReported)
{
  start(coarse_arguments);
  const rclcpp::Time first = now();
  for (std::uint32_t i = 0; i < 80; ++i)
    if (i % 4 != 3) { // every fourth is lost
      ASSERT_TRUE(send(makeCloud(
          i, "world", first + rclcpp::Duration::from_nanoseconds(i * 50000000))));
    }
  EXPECT_TRUE(waitForStatus(
      *diagnostics_, "points", DiagnosticStatus::WARN, "Clouds are missing"));
}

TEST_F(CloudSenderNodeTest, LateTransformIsWaitedForAndTheNodeDoesNotBlock)
{
  start(coarseWith({"-p", "tf_timeout:=10.0"}));
  const PointCloud2 cloud = makeCloud(0, "kinect_1", now());
  clouds_->publish(cloud);
  // The executor has one thread, which is that of the clouds.
  const auto answer = call<Trigger>(*tester_, "/sensor_node/request_i_frame");
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success);
  EXPECT_FALSE(
      waitUntil([&] { return frames_->count() != 0; }, std::chrono::milliseconds(200)));
  // That of the cloud is the mean of the two.
  const rclcpp::Duration second(1, 0);
  const rclcpp::Time stamp(cloud.header.stamp);
  transforms_->sendTransform(toMessage("kinect_1", samplePose(0.0), stamp - second));
  transforms_->sendTransform(toMessage("kinect_1", samplePose(0.0), stamp + second));
  const auto frame = frames_->next(0);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->width * frame->point_step, frame->row_step);
  EXPECT_FALSE(waitUntil(
      [&] {
        const auto status = lastStatus(*diagnostics_, "points");
        return status && status->level == DiagnosticStatus::WARN;
      },
      std::chrono::milliseconds(1200)));
}

TEST_F(CloudSenderNodeTest, LatestTransformIsUsedAndReported)
{
  start(coarse_arguments);
  DirectStream direct(coarse);
  const rclcpp::Time stamp = now();
  transforms_->sendTransform(
      toMessage("kinect_1", samplePose(0.0), stamp - rclcpp::Duration(1, 0)));
  PointCloud2 cloud = makeCloud(0, "kinect_1", stamp);
  // The first ones may arrive before the transform.
  std::optional<Frame> frame;
  ASSERT_TRUE(waitUntil([&] {
    clouds_->publish(cloud);
    return waitUntil([&] { return frames_->count() != 0; },
                     std::chrono::milliseconds(100));
  }));
  EXPECT_EQ(frames_->messages().front().compressed_data,
            direct.encode(cloud, samplePose(0.0)));
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            "points",
                            DiagnosticStatus::WARN,
                            "A transform of another time is used"));
}

TEST_F(CloudSenderNodeTest, LastTransformIsUsedAndReportedWhereTfHasNone)
{
  start(coarseWith({"-p", "use_sim_time:=true"}));
  DirectStream direct(coarse);
  const auto clock = tester_->create_publisher<rosgraph_msgs::msg::Clock>(
      "/clock", rclcpp::ClockQoS());
  const auto setTime = [&](std::int32_t seconds) {
    rosgraph_msgs::msg::Clock time;
    time.clock.sec = seconds;
    return waitUntil([&] {
      clock->publish(time);
      return waitUntil([&] { return node_->now().seconds() == seconds; },
                       std::chrono::milliseconds(100));
    });
  };
  ASSERT_TRUE(setTime(1000));
  const PointCloud2 cloud = makeCloud(0, "kinect_1", rclcpp::Time(1000, 0));
  ASSERT_TRUE(waitUntil([&] {
    transforms_->sendTransform(
        toMessage("kinect_1", samplePose(0.0), rclcpp::Time(1000, 0)));
    clouds_->publish(cloud);
    return waitUntil([&] { return frames_->count() != 0; },
                     std::chrono::milliseconds(200));
  }));
  // TF forgets its transforms when time goes back.
  ASSERT_TRUE(setTime(500));
  const auto frame = send(makeCloud(0, "kinect_1", rclcpp::Time(500, 0)));
  ASSERT_TRUE(frame);
  const std::size_t frames = frames_->count();
  Bytes expected;
  for (std::size_t i = 0; i < frames; ++i)
    expected = direct.encode(cloud, samplePose(0.0));
  EXPECT_EQ(frame->compressed_data, expected);
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            "points",
                            DiagnosticStatus::WARN,
                            "A transform of another time is used"));
  // That of another frame is not.
  clouds_->publish(makeCloud(0, "kinect_2", rclcpp::Time(500, 0)));
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            "points",
                            DiagnosticStatus::ERROR,
                            "without transform are dropped"));
}

TEST_F(CloudSenderNodeTest, CloudsKeepTheirOrderWhileOneWaits)
{
  start(coarseWith({"-p", "tf_timeout:=10.0"}));
  for (std::uint32_t i = 0; i < 4; ++i)
    clouds_->publish(makeCloud(i, i == 0 ? "kinect_1" : "world", now()));
  EXPECT_FALSE(
      waitUntil([&] { return frames_->count() != 0; }, std::chrono::milliseconds(200)));
  static_transforms_->sendTransform(toMessage("kinect_1", samplePose(0.0), now()));
  ASSERT_TRUE(waitUntil([&] { return frames_->count() == 4; }));
  const std::vector<Frame> frames = frames_->messages();
  for (std::size_t i = 1; i < frames.size(); ++i)
    EXPECT_LT(rclcpp::Time(frames[i - 1].header.stamp),
              rclcpp::Time(frames[i].header.stamp));
}

TEST_F(CloudSenderNodeTest, OldestWaitingCloudsAreDroppedAndReported)
{
  start(coarseWith({"-p", "tf_timeout:=10.0", "-p", "queue_size:=2"}));
  for (std::uint32_t i = 0; i < 5; ++i) {
    clouds_->publish(makeCloud(i, "kinect_1", now()));
    std::this_thread::sleep_for(
        std::chrono::milliseconds(20)); // in the network's queue
  }
  static_transforms_->sendTransform(toMessage("kinect_1", samplePose(0.0), now()));
  ASSERT_TRUE(waitUntil([&] { return frames_->count() == 2; }));
  EXPECT_TRUE(waitForStatus(
      *diagnostics_, "points", DiagnosticStatus::WARN, "Clouds are missing"));
}

TEST_F(CloudSenderNodeTest, IFramesOnRequest)
{
  start(coarseWith({"-p", "i_frame_rate:=1000"}));
  std::uint32_t number = 0;
  const auto sendNext = [&] {
    const auto frame = send(makeCloud(++number, "world", now()));
    return frame && isIFrame(frame->compressed_data);
  };
  EXPECT_TRUE(sendNext());
  EXPECT_FALSE(sendNext());
  EXPECT_FALSE(sendNext());
  requests_->publish(std_msgs::msg::Empty());
  EXPECT_TRUE(waitUntil(sendNext));
  EXPECT_FALSE(sendNext());
  EXPECT_FALSE(sendNext());
  const auto answer = call<Trigger>(*tester_, "/sensor_node/request_i_frame");
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success);
  EXPECT_TRUE(sendNext());
}

TEST_F(CloudSenderNodeTest, ParametersChangeWithTheNextFrame)
{
  start(coarse_arguments);
  DirectStream direct(coarse);
  PointCloud2 cloud = makeCloud(0, "world", now());
  const auto identity = pcl_ext::WorldPose::Identity();
  auto frame = send(cloud);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->compressed_data, direct.encode(cloud, pcl_ext::WorldPose(identity)));
  const auto result = set("resolution", rclcpp::ParameterValue(0.05));
  EXPECT_TRUE(result.successful) << result.reason;
  EXPECT_EQ(direct.sender().setParameters({{"resolution", 0.05}}), "");
  frame = send(cloud);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->compressed_data, direct.encode(cloud, pcl_ext::WorldPose(identity)));
  EXPECT_TRUE(isIFrame(frame->compressed_data));
}

TEST_F(CloudSenderNodeTest, WrongValuesAreRefusedWithTheReason)
{
  start(coarse_arguments);
  auto result = set("effort", rclcpp::ParameterValue("quick"));
  EXPECT_FALSE(result.successful);
  EXPECT_EQ(result.reason,
            "effort is 'quick'; it must be one of: fast, balanced, small");
  result = set("resolution", rclcpp::ParameterValue("fine"));
  EXPECT_FALSE(result.successful);
  EXPECT_NE(result.reason.find("resolution is 'fine'"), std::string::npos)
      << result.reason;
  result = set("resolution", rclcpp::ParameterValue(-1.0));
  EXPECT_FALSE(result.successful);
  EXPECT_NE(result.reason.find("resolution"), std::string::npos) << result.reason;
  // Each for itself is allowed.
  result = set("intensity", rclcpp::ParameterValue("quadratic"));
  EXPECT_FALSE(result.successful);
  EXPECT_NE(result.reason.find("sensor"), std::string::npos) << result.reason;
  result = set("global_frame", rclcpp::ParameterValue("map"));
  EXPECT_FALSE(result.successful);
  EXPECT_NE(result.reason.find("read-only"), std::string::npos) << result.reason;
  EXPECT_EQ(node_->get_parameter("effort").as_string(), "fast");
}

TEST_F(CloudSenderNodeTest, ContradictionAtTheStartIsReportedAndCanBeMended)
{
  start({"-p", "intensity:=quadratic"});
  clouds_->publish(makeCloud(0, "world", now()));
  EXPECT_TRUE(waitForStatus(
      *diagnostics_, "points", DiagnosticStatus::ERROR, "No cloud is sent"));
  EXPECT_EQ(frames_->count(), 0u);
  const auto result = set("intensity", rclcpp::ParameterValue("count"));
  EXPECT_TRUE(result.successful) << result.reason;
  EXPECT_TRUE(send(makeCloud(1, "world", now())));
}

TEST_F(CloudSenderNodeTest, ParametersAreDescribed)
{
  start({});
  const auto descriptor = node_->describe_parameter("resolution");
  EXPECT_NE(descriptor.description.find("Unit: m"), std::string::npos);
  ASSERT_EQ(descriptor.floating_point_range.size(), 1u);
  EXPECT_EQ(descriptor.floating_point_range[0].from_value, 1e-6);
  EXPECT_FALSE(descriptor.read_only);
  EXPECT_TRUE(node_->describe_parameter("queue_size").read_only);
  EXPECT_TRUE(
      node_->has_parameter("qos_overrides./kinect_1/points.subscription.reliability"));
  EXPECT_TRUE(node_->has_parameter(
      "qos_overrides./kinect_1/points/pcl_ext.publisher.reliability"));
}

} // namespace pcl_ext_ros::test
