// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds.h"
#include "direct_library.h"
#include "running_nodes.h"

#include <gtest/gtest.h>

#include <octomap/AbstractOcTree.h>
#include <octomap/OcTree.h>
#include <pcl_ext_ros/merging_centre_node.hpp>

#if PCL_EXT_ROS_HAS_OCTOMAP_MSGS
#include <octomap_msgs/conversions.h>
#include <octomap_msgs/msg/octomap.hpp>
#endif
#include <pcl_ext_ros_common/tf_node.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2_ros/static_transform_broadcaster.hpp>
#include <unistd.h>

#include <filesystem>

namespace pcl_ext_ros {
namespace test {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::PointCloud2;
using std_srvs::srv::Trigger;
using namespace std::chrono_literals;

namespace {

const std::string topic_1 = "/kinect_1/points/pcl_ext";
const std::string topic_2 = "/kinect_2/points/pcl_ext";
const std::string voxels_topic_1 = "/central_node" + topic_1 + "/voxels";
const std::string voxels_topic_2 = "/central_node" + topic_2 + "/voxels";

pcl_ext::nodes::ParameterValues
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
    tester_ = nodes_.add<Tester>(rclcpp::NodeOptions());
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
    std::filesystem::remove_all(folder_);
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

  /** \brief A node of the test itself. */
  class Tester : public rclcpp::Node {
  public:
    explicit Tester(const rclcpp::NodeOptions& options)
    : rclcpp::Node("tester", options)
    {}
  };

  RunningNodes nodes_{std::make_unique<rclcpp::executors::MultiThreadedExecutor>()};
  std::shared_ptr<MergingCentreNode> node_;
  std::shared_ptr<Tester> tester_;
  rclcpp::Publisher<Frame>::SharedPtr frames_1_;
  rclcpp::Publisher<Frame>::SharedPtr frames_2_;
  std::optional<Recorder<PointCloud2>> voxels_1_;
  std::optional<Recorder<PointCloud2>> voxels_2_;
  std::optional<Recorder<std_msgs::msg::Empty>> requests_1_;
  std::optional<Recorder<DiagnosticArray>> diagnostics_;
  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("pcl_ext_ros_maps_" + std::to_string(getpid()));
};

/** \brief The voxels of a frame whose intensity is large enough. */
std::size_t
countFrom(const Frame& frame, float min_intensity)
{
  std::size_t count = 0;
  pcl_ext::io::forEachVoxelCentre(decoded(frame.compressed_data),
                                  [&](float, float, float, float intensity) {
                                    count += intensity >= min_intensity ? 1 : 0;
                                  });
  return count;
}

} // namespace

TEST_F(MergingCentreNodeTest, VoxelsAreThoseOfTheLibrary)
{
  start({});
  DirectStream direct(coarse());
  pcl_ext::nodes::CentralNode library((pcl_ext::nodes::CentralNodeSettings()));
  ASSERT_TRUE(library.addStream("stream").ok());
  for (std::uint32_t i = 0; i < 5; ++i) {
    const Frame frame =
        direct.frameOf(makeCloud(i, "world", now()), samplePose(0.01 * i));
    const auto voxels = send(frame);
    ASSERT_TRUE(voxels) << i;
    ASSERT_TRUE(library.receive("stream", frame.compressed_data).ok());
    library.waitUntilDecoded();
    pcl_ext::io::VoxelFrame expected;
    ASSERT_TRUE(library.latestVoxels("stream", expected));
    EXPECT_EQ(voxels->data, pointsOf(expected)) << i;
    EXPECT_EQ(voxels->header, frame.header);
    EXPECT_EQ(voxels->width, expected.size());
    EXPECT_EQ(voxels->fields.size(), 4u);
  }
  EXPECT_EQ(voxels_2_->count(), 0u);
}

TEST_F(MergingCentreNodeTest, StreamsAreMerged)
{
  start({"-p", "merge_rate:=50.0", "-p", "max_merge_age:=3600.0"});
  Recorder<DiagnosticArray> streams(*tester_, "/central_node/merged/streams");
  ASSERT_TRUE(streams.waitForPublisher());
  Recorder<PointCloud2> merged(*tester_, "/central_node/merged");
  ASSERT_TRUE(merged.waitForPublisher());
  Frame first = iFrame(1);
  Frame second = iFrame(2);
  first.header.stamp = rclcpp::Time(70, 0); // a wrong clock
  second.header.stamp = roundedDown(now(), std::chrono::milliseconds(20));
  frames_1_->publish(first);
  ASSERT_TRUE(waitUntil([&] { return voxels_1_->count() == 1; }));
  std::optional<PointCloud2> cloud;
  // Merging begins when the node has seen the subscriber.
  ASSERT_TRUE(waitUntil([&] {
    const rclcpp::Time stamp = rclcpp::Time(second.header.stamp) + 20ms;
    second.header.stamp = stamp;
    const std::size_t known = merged.count();
    frames_2_->publish(second);
    std::this_thread::sleep_for(20ms);
    if (merged.count() > known)
      cloud = merged.messages().back();
    return cloud.has_value();
  }));
  const auto expected = mergedDirectly(
      0.1, {{topic_1, first.compressed_data}, {topic_2, second.compressed_data}});
  EXPECT_EQ(cloud->data, pointsOf(expected));
  EXPECT_EQ(cloud->header.frame_id, "world");
  EXPECT_EQ(rclcpp::Time(cloud->header.stamp).nanoseconds() % 20000000, 0);
  EXPECT_LE(rclcpp::Time(cloud->header.stamp), rclcpp::Time(second.header.stamp));
  // Of the first ones one may be missed, as the topics are connected one after the
  // other.
  std::optional<DiagnosticArray> merged_streams;
  ASSERT_TRUE(waitUntil([&] {
    for (const DiagnosticArray& message : streams.messages())
      for (const PointCloud2& same : merged.messages())
        if (message.header.stamp == same.header.stamp)
          merged_streams = message;
    return merged_streams.has_value();
  }));
  ASSERT_EQ(merged_streams->status.size(), 3u);
  EXPECT_EQ(merged_streams->status[1].name, "central_node: " + topic_2);
  EXPECT_EQ(merged_streams->status[1].hardware_id, "none");
  EXPECT_EQ(merged_streams->status[1].level, DiagnosticStatus::OK);
  EXPECT_EQ(merged_streams->status[2].name, "central_node: all streams");
  EXPECT_EQ(merged_streams->status[2].values.at(0).value, "70000000000");
}

TEST_F(MergingCentreNodeTest, TellsWhatIsMergedAlsoWhereNobodyWantsTheVoxels)
{
  start({});
  Recorder<DiagnosticArray> streams(*tester_, "/central_node/merged/streams");
  ASSERT_TRUE(waitUntil([&] {
    const Frame frame = iFrame(1);
    frames_1_->publish(frame);
    frames_2_->publish(frame);
    std::this_thread::sleep_for(20ms);
    return streams.count() != 0;
  }));
  EXPECT_EQ(streams.messages()[0].status.size(), 3u);
}

TEST_F(MergingCentreNodeTest, AnotherResolutionThanThatOfTheMergedGridIsReported)
{
  start({});
  DirectStream stream({{"resolution", 0.15}, {"intensity", std::string("count")}});
  ASSERT_TRUE(send(stream.frameOf(makeCloud(0, "world", now()), samplePose(0.0))));
  EXPECT_TRUE(
      waitForStatus(*diagnostics_,
                    topic_1,
                    DiagnosticStatus::WARN,
                    "Voxels have an edge of 0.15 m, those of the merged grid 0.1 m"));
}

TEST_F(MergingCentreNodeTest, NoiseChangesWhileItRuns)
{
  start({"-p", "min_intensity:=2.0"});
  const Frame frame = iFrame(0);
  ASSERT_LT(countFrom(frame, 4), countFrom(frame, 3));
  ASSERT_LT(countFrom(frame, 3), countFrom(frame, 2));
  const auto width = [&] {
    const auto voxels = send(frame);
    return voxels ? voxels->width : 0u;
  };
  EXPECT_EQ(width(), countFrom(frame, 2));
  EXPECT_EQ(set("min_intensity", rclcpp::ParameterValue(3)), "");
  EXPECT_EQ(width(), countFrom(frame, 3));
  const std::string own = "kinect_1.points.pcl_ext.min_intensity";
  EXPECT_EQ(set(own, rclcpp::ParameterValue(4.0)), "");
  EXPECT_EQ(width(), countFrom(frame, 4));
  // That of the stream stays.
  EXPECT_EQ(set("min_intensity", rclcpp::ParameterValue(0.0)), "");
  EXPECT_EQ(width(), countFrom(frame, 4));
  EXPECT_EQ(set(own, rclcpp::ParameterValue()), "");
  EXPECT_EQ(width(), countFrom(frame, 0));
}

TEST_F(MergingCentreNodeTest, StreamsHaveTheirOwnParametersAtTheStart)
{
  start({"-p",
         "kinect_1.points.pcl_ext.min_intensity:=3.0",
         "-p",
         "kinect_2.points.pcl_ext.remove_outliers:=true",
         "-p",
         "kinect_2.points.pcl_ext.density_unit:=points"});
  const Frame frame = iFrame(0);
  const auto voxels = send(frame);
  ASSERT_TRUE(voxels);
  EXPECT_EQ(voxels->width, countFrom(frame, 3));
  pcl_ext::nodes::CentralNode library((pcl_ext::nodes::CentralNodeSettings()));
  ASSERT_TRUE(library.addStream("stream").ok());
  const pcl_ext::VoxelOutlierRemovalSettings removal{pcl_ext::PointsUnit()};
  ASSERT_TRUE(library.setOutlierRemoval("stream", removal).ok());
  ASSERT_TRUE(library.receive("stream", frame.compressed_data).ok());
  library.waitUntilDecoded();
  pcl_ext::io::VoxelFrame expected;
  ASSERT_TRUE(library.latestVoxels("stream", expected));
  ASSERT_LT(expected.size(), countFrom(frame, 0));
  frames_2_->publish(frame);
  const auto others = voxels_2_->next(0);
  ASSERT_TRUE(others);
  EXPECT_EQ(others->data, pointsOf(expected));
}

TEST_F(MergingCentreNodeTest, WrongValuesAreRefusedWithTheReason)
{
  start({});
  EXPECT_EQ(set("density_unit", rclcpp::ParameterValue("litres")),
            "density_unit is 'litres'; it must be one of: automatic, faces, points, "
            "voxels, rays");
  const std::string own = "kinect_1.points.pcl_ext.remove_outliers";
  EXPECT_EQ(set(own, rclcpp::ParameterValue(1)),
            "kinect_1.points.pcl_ext.remove_outliers is 1; it must be true or false");
  EXPECT_NE(set("merge_rate", rclcpp::ParameterValue(5.0)).find("read-only"),
            std::string::npos);
  const auto twice = std::vector<std::string>{"/a", "a"};
  EXPECT_EQ(set("streams", rclcpp::ParameterValue(twice)),
            "streams is [/a, a]; /a is twice in it");
}

TEST_F(MergingCentreNodeTest, FramesOfAnotherFrameIdOrFormatAreDroppedAndReported)
{
  start({});
  Frame frame = iFrame(0);
  frame.header.frame_id = "elsewhere";
  frames_1_->publish(frame);
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            topic_1,
                            DiagnosticStatus::ERROR,
                            "Frames are of another frame id or format"));
  frame = iFrame(0);
  frame.format = "draco";
  frames_2_->publish(frame);
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            topic_2,
                            DiagnosticStatus::ERROR,
                            "Frames are of another frame id or format"));
  EXPECT_TRUE(waitForStatus(
      *diagnostics_, "all streams", DiagnosticStatus::WARN, "Not all streams are OK"));
  EXPECT_EQ(voxels_1_->count() + voxels_2_->count(), 0u);
}

TEST_F(MergingCentreNodeTest, TwoPublishersOfOneStreamAreAnError)
{
  start({});
  const auto second = tester_->create_publisher<Frame>(topic_1, 10);
  frames_1_->publish(iFrame(0));
  EXPECT_TRUE(waitForStatus(*diagnostics_,
                            topic_1,
                            DiagnosticStatus::ERROR,
                            "2 publishers send this stream, which can have one"));
}

TEST_F(MergingCentreNodeTest, IFrameIsRequestedWhereOneWasLost)
{
  start({});
  DirectStream direct(coarse());
  direct.frameOf(makeCloud(0, "world", now()), samplePose(0.0));
  frames_1_->publish(direct.frameOf(makeCloud(1, "world", now()), samplePose(0.0)));
  EXPECT_TRUE(requests_1_->next(0));
  EXPECT_EQ(voxels_1_->count(), 0u);
  direct.sender().requestIFrame();
  EXPECT_TRUE(send(direct.frameOf(makeCloud(2, "world", now()), samplePose(0.0))));
}

TEST_F(MergingCentreNodeTest, MapIsWrittenAndReadBack)
{
  std::filesystem::create_directories(folder_);
  const std::string path = folder_ / "map.ot";
  start({"-p", "map_path:=" + path, "-p", "map_rate:=20.0"});
  const Frame frame = iFrame(0);
  ASSERT_TRUE(send(frame));
  const auto answer = call<Trigger>(*tester_, "/central_node/write_map");
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->success) << answer->message;
  const auto readMap = [&] {
    const std::unique_ptr<octomap::AbstractOcTree> tree(
        octomap::AbstractOcTree::read(path));
    auto* const map = dynamic_cast<octomap::OcTree*>(tree.get());
    return map == nullptr ? octomap::OcTree(1.0) : octomap::OcTree(*map);
  };
  const octomap::OcTree map = readMap();
  EXPECT_EQ(map.getResolution(), 0.1);
  std::size_t known = 0;
  pcl_ext::io::forEachVoxelCentre(
      decoded(frame.compressed_data), [&](float x, float y, float z, float intensity) {
        const auto* const node = map.search(x + 1e-4f, y + 1e-4f, z + 1e-4f);
        known += node != nullptr && intensity > 0.0f ? 1 : 0;
      });
  EXPECT_EQ(known, countFrom(frame, 1e-6f));
  // At the end with the last frames.
  const std::size_t before = map.size();
  ASSERT_TRUE(send(iFrame(7)));
  std::filesystem::remove(path);
  node_.reset();
  nodes_.stop();
  EXPECT_GT(readMap().size(), before);
}

TEST_F(MergingCentreNodeTest, WrongMapPathIsReported)
{
  start({"-p", "map_path:=" + (folder_ / "nowhere" / "map.ot").string()});
  EXPECT_TRUE(
      waitForStatus(*diagnostics_, "all streams", DiagnosticStatus::ERROR, "map_path"));
  EXPECT_TRUE(send(iFrame(0)));
  const auto answer = call<Trigger>(*tester_, "/central_node/write_map");
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->success);
}

TEST_F(MergingCentreNodeTest, StreamsAreAddedAndRemovedWhileItRuns)
{
  start({});
  const auto setStreams = [&](const std::vector<std::string>& streams) {
    EXPECT_EQ(set("streams", rclcpp::ParameterValue(streams)), "");
  };
  ASSERT_TRUE(send(iFrame(0)));
  setStreams({topic_2, "third"});
  EXPECT_TRUE(waitUntil([&] {
    return frames_1_->get_subscription_count() == 0 &&
           node_->count_publishers(voxels_topic_1) == 0 &&
           node_->count_subscribers("/third") == 1;
  }));
  EXPECT_TRUE(node_->has_parameter("third.min_intensity"));
  // One that comes back begins anew, and has its parameters.
  EXPECT_EQ(set("kinect_1.points.pcl_ext.min_intensity", rclcpp::ParameterValue(3.0)),
            "");
  setStreams({topic_1, topic_2});
  ASSERT_TRUE(waitUntil([&] {
    return frames_1_->get_subscription_count() == 1 &&
           node_->count_subscribers("/third") == 0 &&
           node_->count_subscribers(voxels_topic_1) == 1;
  }));
  const Frame frame = iFrame(1);
  std::optional<PointCloud2> voxels;
  // Both directions have to be connected.
  ASSERT_TRUE(waitUntil([&] {
    const std::size_t known = voxels_1_->count();
    frames_1_->publish(frame);
    std::this_thread::sleep_for(20ms);
    if (voxels_1_->count() > known)
      voxels = voxels_1_->messages().back();
    return voxels.has_value();
  }));
  EXPECT_EQ(voxels->width, countFrom(frame, 3));
  frames_2_->publish(frame);
  EXPECT_TRUE(voxels_2_->next(0));
}

#if PCL_EXT_ROS_HAS_OCTOMAP_MSGS
TEST_F(MergingCentreNodeTest, MapIsPublishedWithRaysAndLatched)
{
  start(
      {"-p", "map_rate:=20.0", "-p", "kinect_1.points.pcl_ext.sensor_frame:=kinect_1"});
  tf2_ros::StaticTransformBroadcaster transforms(
      pcl_ext_ros_common::tfNode<tf2_ros::StaticTransformBroadcaster>(*tester_));
  transforms.sendTransform(toMessage("kinect_1", samplePose(0.0), now()));
  using octomap_msgs::msg::Octomap;
  const auto qos = rclcpp::QoS(1).transient_local();
  std::optional<Recorder<Octomap>> maps(
      std::in_place, *tester_, "/central_node/map", qos);
  // The map begins with its first subscriber.
  ASSERT_TRUE(maps->next(0));
  const auto hasFreeNodes = [](const Octomap& message) {
    const std::unique_ptr<octomap::AbstractOcTree> tree(
        octomap_msgs::fullMsgToMap(message));
    const auto* const map = dynamic_cast<octomap::OcTree*>(tree.get());
    if (map == nullptr)
      return false;
    for (auto leaf = map->begin_leafs(); leaf != map->end_leafs(); ++leaf)
      if (!map->isNodeOccupied(*leaf))
        return true;
    return false;
  };
  ASSERT_TRUE(waitUntil([&] {
    frames_1_->publish(iFrame(0));
    const auto map = maps->next(maps->count());
    return map && hasFreeNodes(*map);
  }));
  maps.emplace(*tester_, "/central_node/map", qos);
  const auto latched = maps->next(0);
  ASSERT_TRUE(latched);
  EXPECT_EQ(latched->header.frame_id, "world");
  EXPECT_EQ(latched->resolution, 0.1);
}
#endif

/** \brief A node of the test itself. */
class Listener : public rclcpp::Node {
public:
  explicit Listener(const rclcpp::NodeOptions& options)
  : rclcpp::Node("listener", options)
  {}
};

/** \brief Wrong `streams`, and what is said. */
class WrongStreams
: public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(WrongStreams, AreReportedAndTheNodeStaysWithoutStreams)
{
  const auto& [streams, message] = GetParam();
  RunningNodes nodes;
  const auto node = nodes.add<MergingCentreNode>(
      optionsOf({"-p", std::string("streams:=") + streams}));
  const auto listener = nodes.add<Listener>(rclcpp::NodeOptions());
  const Recorder<DiagnosticArray> diagnostics(*listener, "/diagnostics");
  nodes.start();
  EXPECT_TRUE(
      waitForStatus(diagnostics, "all streams", DiagnosticStatus::ERROR, message));
  ASSERT_NE(diagnostics.count(), 0u);
  EXPECT_EQ(diagnostics.messages()[0].status.size(), 1u);
  for (const char* const topic : {"/input", "/a"})
    EXPECT_EQ(node->count_subscribers(topic), 0u) << topic;
}

INSTANTIATE_TEST_SUITE_P(
    All,
    WrongStreams,
    ::testing::Values(std::make_pair("[1.5, 2.5]", "it must be a list of topics"),
                      std::make_pair("/a", "it must be a list of topics"),
                      std::make_pair("['']", "'' is no topic"),
                      std::make_pair("[/a, 'b c']", "'b c' is no topic"),
                      std::make_pair("[/a, /a]", "/a is twice in it"),
                      std::make_pair("[/central_node/merged/pcl_ext]",
                                     "is what this node itself merges")));

TEST(MergingCentreNode, StreamsMayHaveSeveralCentralNodes)
{
  MergingCentreNode one(optionsOf({"-p", "streams:=[/zone/a]", "-r", "__ns:=/zone"}));
  MergingCentreNode other(
      optionsOf({"-p", "streams:=[/zone/a]", "-r", "__node:=other"}));
  for (const char* const topic :
       {"/zone/central_node/a/voxels", "/other/zone/a/voxels"})
    EXPECT_TRUE(waitUntil([&] { return one.count_publishers(topic) == 1; })) << topic;
}

TEST(MergingCentreNode, ParametersOfAStreamDoNotChangeWhereItIsRemapped)
{
  MergingCentreNode node(optionsOf({"-r", "input:=/kinect_1/points/pcl_ext"}));
  EXPECT_TRUE(waitUntil(
      [&] { return node.count_subscribers("/kinect_1/points/pcl_ext") == 1; }));
  EXPECT_TRUE(node.has_parameter("input.sensor_frame"));
}

} // namespace test
} // namespace pcl_ext_ros
