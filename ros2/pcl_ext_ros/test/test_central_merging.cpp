// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "central_node_test.h"

namespace pcl_ext_ros::test {

using namespace std::chrono_literals;

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
  EXPECT_TRUE(waitForStatus(
      *diagnostics_,
      topic_1,
      DiagnosticStatus::WARN,
      "Voxels have an edge of 0.15 m, those of the merged grid and the map "
      "0.1 m"));
}

} // namespace pcl_ext_ros::test
