// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "central_node_test.h"

namespace pcl_ext_ros::test {

using namespace std::chrono_literals;

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

TEST(MergingCentreNode, StreamsMayHaveSeveralCentralNodes)
{
  MergingCentreNode one(optionsOf({"-p", "streams:=[/zone/a]", "-r", "__ns:=/zone"}));
  MergingCentreNode other(
      optionsOf({"-p", "streams:=[/zone/a]", "-r", "__node:=other"}));
  for (const char* const topic :
       {"/zone/central_node/a/voxels", "/other/zone/a/voxels"})
    EXPECT_TRUE(waitUntil([&] { return one.count_publishers(topic) == 1; })) << topic;
}

} // namespace pcl_ext_ros::test
