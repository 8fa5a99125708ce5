// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "central_node_test.h"

#include <octomap/AbstractOcTree.h>
#include <octomap/OcTree.h>

#if PCL_EXT_ROS_HAS_OCTOMAP_MSGS
#include <octomap_msgs/conversions.h>
#include <octomap_msgs/msg/octomap.hpp>
#endif
#include <pcl_ext_ros_common/tf_node.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2_ros/static_transform_broadcaster.hpp>
#include <unistd.h>

#include <filesystem>

namespace pcl_ext_ros::test {

using std_srvs::srv::Trigger;

namespace {

/** \brief The same with a folder for the map. */
class CentralMapTest : public MergingCentreNodeTest {
protected:
  void
  TearDown() override
  {
    MergingCentreNodeTest::TearDown();
    std::filesystem::remove_all(folder_);
  }

  const std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() /
      ("pcl_ext_ros_maps_" + std::to_string(getpid()));
};

} // namespace

TEST_F(CentralMapTest, MapIsWrittenAndReadBack)
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

TEST_F(CentralMapTest, WrongMapPathIsReported)
{
  start({"-p", "map_path:=" + (folder_ / "nowhere" / "map.ot").string()});
  EXPECT_TRUE(
      waitForStatus(*diagnostics_, "all streams", DiagnosticStatus::ERROR, "map_path"));
  EXPECT_TRUE(send(iFrame(0)));
  const auto answer = call<Trigger>(*tester_, "/central_node/write_map");
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->success);
}

#if PCL_EXT_ROS_HAS_OCTOMAP_MSGS
TEST_F(CentralMapTest, MapIsPublishedWithRaysAndLatched)
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

} // namespace pcl_ext_ros::test
