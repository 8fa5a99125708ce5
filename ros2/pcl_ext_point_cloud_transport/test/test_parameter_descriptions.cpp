// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief How parameters are declared: their names, their descriptions, and values at
 * the start.
 */
#include <pcl_ext/nodes/impl/node_parameters.h>

#include "parameter_test.h"

namespace pcl_ext_point_cloud_transport::test {

namespace {

using DeclaredParameters = ParameterTest;

TEST_F(DeclaredParameters, OverridesThatAreWrongAreLoggedAndTheDefaultHolds)
{
  ::testing::internal::CaptureStderr();
  start({{points("resolution"), -0.5},
         {points("effort"), "quick"},
         {points("i_frame_rate"), 3.5},
         {points("colour_bits"), 2}},
        {{points("min_intensity"), "much"}});
  const std::string log = ::testing::internal::GetCapturedStderr();
  for (const char* const name :
       {"resolution", "effort", "i_frame_rate", "min_intensity"})
    EXPECT_NE(log.find(points(name)), std::string::npos) << name << '\n' << log;
  EXPECT_NE(log.find("effort is 'quick'; it must be one of: fast"), std::string::npos)
      << log;
  EXPECT_EQ(log.find(points("colour_bits")), std::string::npos) << log;
  EXPECT_EQ(sender->node().get_parameter(points("resolution")).as_double(),
            settings.compression.resolution);
  settings.compression.colour_bits = 2;
  expectNext();
  EXPECT_TRUE(sender->node().set_parameter({points("resolution"), 0.05}).successful);
  settings.compression.resolution = 0.05;
  expectNext();
}

TEST_F(DeclaredParameters, AContradictionAtTheStartSendsNothingUntilItIsSetRight)
{
  layout = Layout::Xyz;
  settings = defaultSettings();
  start({{points("intensity"), "quadratic"}});
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 3; ++i)
    sender->publisher.publish(makeCloud(number++));
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find(points("sensor is not set")), std::string::npos) << log;
  EXPECT_TRUE(sender->node().set_parameter({points("sensor"), "kinect_v2"}).successful);
  settings.law = pcl_ext::IntensityLaw::Quadratic;
  settings.sensor.emplace(70.0, 60.0, 512u, 424u);
  const Cloud cloud = makeCloud(number++);
  sender->publisher.publish(cloud);
  ASSERT_TRUE(receiver->clouds.waitForStamp(cloud.header.stamp));
  EXPECT_EQ(receiver->clouds.count(), 1u); // none of those before
}

/** \brief The parameters of an end have the table's descriptions and ranges. */
void
expectDescriptors(rclcpp::Node& node,
                  const std::vector<pcl_ext::nodes::ParameterDescription>& table)
{
  std::size_t ranges = 0;
  for (const auto& parameter : table) {
    ASSERT_TRUE(node.has_parameter(points(parameter.name))) << parameter.name;
    const auto descriptor = node.describe_parameter(points(parameter.name));
    EXPECT_EQ(descriptor.description.find(parameter.description), 0u);
    EXPECT_EQ(descriptor.additional_constraints, allowedValues(parameter));
    EXPECT_FALSE(descriptor.additional_constraints.empty());
    EXPECT_FALSE(descriptor.read_only);
    ranges += descriptor.floating_point_range.size() + descriptor.integer_range.size();
  }
  EXPECT_GT(ranges, 0u);
}

TEST_F(DeclaredParameters, AllAreDescribedAndHaveTheSameNamesInAnyNamespace)
{
  start(); // the nodes are in a namespace
  expectDescriptors(sender->node(), pcl_ext::nodes::encodingParameters());
  expectDescriptors(receiver->node(), pcl_ext::nodes::noiseParameters());
  const auto in_root = std::make_shared<rclcpp::Node>(
      "node_in_root",
      rclcpp::NodeOptions().parameter_overrides(
          {{"points.enable_pub_plugins",
            std::vector<std::string>{"point_cloud_transport/pcl_ext"}}}));
  auto publisher = point_cloud_transport::PointCloudTransport(toTransport(in_root))
                       .advertise("points", toTransport(reliable()));
  expectDescriptors(*in_root, pcl_ext::nodes::encodingParameters());

  // A topic outside of the node's namespace has its full name.
  const auto hints = hintsOfPlugin();
  const auto subscriber =
      point_cloud_transport::PointCloudTransport(toTransport(receiver->spun.node))
          .subscribe(
              "/else/points",
              toTransport(reliable()),
              [](const Cloud::ConstSharedPtr&) {},
              {},
              &hints);
  EXPECT_TRUE(receiver->node().has_parameter("else.points.pcl_ext.min_intensity"));
}

TEST_F(DeclaredParameters, TheirNamesAreThoseOfTheProgramWhereTheTopicIsRemapped)
{
  const auto remapped = rclcpp::NodeOptions().arguments(
      {"--ros-args", "-r", "points/pcl_ext:=else/where/pcl_ext"});
  sender.emplace(
      Parameters{{points("resolution"), 0.07}}, "sender", reliable(), remapped);
  receiver.emplace(Parameters(), "receiver", "points", reliable(), remapped);
  EXPECT_EQ(receiver->subscriber.getTopic(), spaceOfThisTest() + "/else/where/pcl_ext");
  sender->expectSubscribers(1);
  receiver->expectPublishers(1);
  expectDescriptors(sender->node(), pcl_ext::nodes::encodingParameters());
  expectDescriptors(receiver->node(), pcl_ext::nodes::noiseParameters());
  EXPECT_TRUE(sender->node().has_parameter("points.enable_pub_plugins"));
  settings.compression.resolution = 0.07;
  expectNext();
  settings.compression.resolution = 0.1;
  setAndExpect("resolution", 0.1);
}

TEST_F(DeclaredParameters, ThoseThatANodeDeclaresFromItsOverridesAreCheckedAndDescribed)
{
  const auto options =
      rclcpp::NodeOptions().automatically_declare_parameters_from_overrides(true);
  ::testing::internal::CaptureStderr();
  sender.emplace(Parameters{{points("resolution"), 0.07}, {points("effort"), "quick"}},
                 "sender",
                 reliable(),
                 options);
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("effort is 'quick'"), std::string::npos) << log;
  receiver.emplace();
  sender->expectSubscribers(1);
  receiver->expectPublishers(1);
  expectDescriptors(sender->node(), pcl_ext::nodes::encodingParameters());
  EXPECT_EQ(sender->node().get_parameter(points("effort")).as_string(), "fast");
  settings.compression.resolution = 0.07;
  expectNext();
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
