// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "central_node_test.h"

namespace pcl_ext_ros::test {

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

TEST(MergingCentreNode, ParametersOfAStreamDoNotChangeWhereItIsRemapped)
{
  MergingCentreNode node(optionsOf({"-r", "input:=/kinect_1/points/pcl_ext"}));
  EXPECT_TRUE(waitUntil(
      [&] { return node.count_subscribers("/kinect_1/points/pcl_ext") == 1; }));
  EXPECT_TRUE(node.has_parameter("input.sensor_frame"));
}

} // namespace pcl_ext_ros::test
