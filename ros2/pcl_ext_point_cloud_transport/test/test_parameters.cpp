/** \file
 * \brief Parameters of both ends: described, checked, and changed while clouds flow.
 */
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/node_parameters.h>

#include "plugin_test.h"

#include <algorithm>

namespace pcl_ext_point_cloud_transport {
namespace test {

namespace {

/** \brief Both ends; the voxels are compared with those of the settings. */
class ChangedParameters : public ::testing::Test {
protected:
  void
  start(const Parameters& of_sender = {}, const Parameters& of_receiver = {})
  {
    sender.emplace(of_sender);
    receiver.emplace(of_receiver);
    sender->expectSubscribers(1);
    receiver->expectPublishers(1);
  }

  /** \brief Sets a parameter of the sender, and expects its effect. */
  template <typename ValueT>
  void
  setAndExpect(const std::string& name, const ValueT& value)
  {
    const auto result =
        sender->node().set_parameter(rclcpp::Parameter(points(name), value));
    EXPECT_TRUE(result.successful) << result.reason;
    expectNext();
  }

  void
  expectNext()
  {
    for (int i = 0; i < 2; ++i, ++number) {
      const Cloud cloud = makeCloud(number, layout);
      expectVoxels(*sender, *receiver, cloud, directVoxels(cloud, settings));
    }
  }

  Layout layout = Layout::XyzRgbi;
  pcl_ext::nodes::SensorNodeSettings settings = defaultSettings(Layout::XyzRgbi);
  std::optional<Sender> sender;
  std::optional<Receiver> receiver;
  std::uint32_t number = 0;
};

TEST_F(ChangedParameters, ThoseOfTheSenderHoldFromTheNextCloudOn)
{
  start();
  expectNext();
  setAndExpect("resolution", settings.compression.resolution = 0.1);
  setAndExpect("resolution", settings.compression.resolution = 0.03);
  setAndExpect("colour_bits", static_cast<int>(settings.compression.colour_bits = 3));
  setAndExpect("colour_bits", static_cast<int>(settings.compression.colour_bits = 0));
  settings.law = pcl_ext::IntensityLaw::Count;
  setAndExpect("intensity", "count");
  settings.law = pcl_ext::IntensityLaw::None;
  setAndExpect("intensity", "none");
  settings.law = pcl_ext::IntensityLaw::Native;
  setAndExpect("intensity", "auto");
  settings.crop_box->min = {-0.5, -0.5, 0.0};
  settings.crop_box->max = {0.5, 0.75, 5.0};
  setAndExpect("crop_box", std::vector<double>{-0.5, -0.5, 0.0, 0.5, 0.75, 5.0});
  settings.crop_box->min = {-1.0, -1.0, 0.0};
  settings.crop_box->max = {1.0, 1.0, 3.0};
  setAndExpect("crop_box", std::vector<std::int64_t>{-1, -1, 0, 1, 1, 3});
  settings.outlier_removal.emplace();
  setAndExpect("remove_outliers", true);
}

TEST_F(ChangedParameters, EffortAndIFrameRateChangeTheFrames)
{
  start({{points("i_frame_rate"), 2}});
  Listener<Compressed> frames(receiver->node(), spaceOfThisTest() + "/points/pcl_ext");
  sender->expectSubscribers(2);
  const auto bytes_of_i_frame = [&](const char* effort) {
    EXPECT_TRUE(sender->node()
                    .set_parameter(rclcpp::Parameter(points("effort"), effort))
                    .successful);
    Cloud cloud = makeCloud(0, layout);
    cloud.header.stamp = stampOf(number++);
    sender->publisher.publish(cloud);
    const auto frame = frames.recorder.waitForStamp(cloud.header.stamp);
    EXPECT_TRUE(frame && isIFrame(*frame)) << effort;
    return frame ? frame->compressed_data.size() : 0;
  };
  bytes_of_i_frame("balanced");
  EXPECT_LT(bytes_of_i_frame("small"), bytes_of_i_frame("fast"));
  EXPECT_TRUE(sender->node()
                  .set_parameter(rclcpp::Parameter(points("i_frame_rate"), 3))
                  .successful);
  for (int i = 0; i < 7; ++i, ++number) {
    sender->publisher.publish(makeCloud(number));
    const auto frame = frames.recorder.waitForStamp(stampOf(number));
    ASSERT_TRUE(frame);
    EXPECT_EQ(isIFrame(*frame), i % 3 == 0) << i;
  }
}

TEST_F(ChangedParameters, ThoseOfTheReceiverHoldFromTheNextCloudOn)
{
  layout = Layout::Xyz;
  settings = defaultSettings();
  start({}, {{points("min_intensity"), 2}}); // a whole number
  const auto without_faint = [&](const Cloud& cloud, float least) {
    Voxels voxels = directVoxels(cloud, settings);
    const auto is_faint = [least](const auto& voxel) { return voxel[3] < least; };
    voxels.erase(std::remove_if(voxels.begin(), voxels.end(), is_faint), voxels.end());
    return voxels;
  };
  const auto expect_next = [&](float least) {
    const Cloud cloud = makeCloud(number++);
    expectVoxels(*sender, *receiver, cloud, without_faint(cloud, least));
  };
  expect_next(2.0f);
  ASSERT_LT(without_faint(makeCloud(0), 2.0f).size(),
            directVoxels(makeCloud(0), settings).size());
  const auto set = [&](const char* name, const auto& value) {
    EXPECT_TRUE(receiver->node()
                    .set_parameter(rclcpp::Parameter(points(name), value))
                    .successful);
  };
  set("min_intensity", 3.5);
  expect_next(3.5f);
  set("min_intensity", 0.0);
  expect_next(0.0f);
  set("density_unit", "points");
  set("min_log_odds", 2); // a whole number
  set("remove_outliers", true);
  pcl_ext::VoxelOutlierRemovalSettings removal;
  removal.unit = pcl_ext::DensityUnit::Points;
  removal.min_log_odds = 2.0f;
  pcl_ext::VoxelOutlierRemoval filter(removal);
  std::size_t removed = 0;
  for (int i = 0; i < 5; ++i) {
    const Cloud cloud = makeCloud(number++);
    auto frame = DirectStream(settings).frameOf(cloud);
    removed += filter.filter(frame).removed;
    expectVoxels(*sender, *receiver, cloud, voxelsIn(frame));
  }
  EXPECT_GT(removed, 100u);
  set("remove_outliers", false);
  expect_next(0.0f);
}

TEST_F(ChangedParameters, WhatIsNotAllowedIsRefusedWithTheReason)
{
  start();
  expectNext();
  const std::vector<std::pair<rclcpp::Parameter, std::string>> refused{
      {{points("resolution"), 0.0}, "resolution"},
      {{points("resolution"), -1}, "resolution"},
      {{points("resolution"), std::nan("")},
       "resolution is nan; it must be a number from"},
      {{points("resolution"), "fine"},
       "resolution is 'fine'; it must be a number from"},
      {{points("effort"), "quick"},
       "effort is 'quick'; it must be one of: fast, balanced, small"},
      {{points("effort"), 1}, "effort is 1; it must be one of"},
      {{points("i_frame_rate"), -1}, "i_frame_rate"},
      {{points("i_frame_rate"), 2.5}, "i_frame_rate is 2.5; it must be a whole number"},
      {{points("colour_bits"), 9}, "colour_bits"},
      {{points("crop_box"), std::vector<double>{1, 2, 3}},
       "crop_box is [1, 2, 3]; it must"},
      {{points("crop_box"), std::vector<double>{1, 1, 1, 0, 2, 2}},
       "crop_box is [1, 1, 1"},
      {{points("crop_box"), std::vector<std::string>{"a"}},
       "crop_box is [a]; it must be"},
      {{points("intensity"), "quadratic"}, "sensor is not set"},
      {{points("remove_outliers"), 1},
       "remove_outliers is 1; it must be true or false"}};
  for (const auto& [parameter, reason] : refused) {
    const auto before = sender->node().get_parameter(parameter.get_name());
    const auto result = sender->node().set_parameter(parameter);
    EXPECT_FALSE(result.successful) << parameter.get_name();
    EXPECT_NE(result.reason.find(reason), std::string::npos) << result.reason;
    EXPECT_EQ(sender->node().get_parameter(parameter.get_name()), before);
  }
  // All or none.
  EXPECT_FALSE(sender->node()
                   .set_parameters_atomically(
                       {{points("resolution"), 0.5}, {points("effort"), "quick"}})
                   .successful);
  expectNext();
  EXPECT_FALSE(
      receiver->node().set_parameter({points("min_intensity"), "much"}).successful);
  EXPECT_FALSE(
      receiver->node().set_parameter({points("density_unit"), "moles"}).successful);
}

TEST_F(ChangedParameters, ValuesThatNeedEachOtherAreSetTogether)
{
  layout = Layout::Xyz;
  start();
  settings = defaultSettings();
  settings.law = pcl_ext::IntensityLaw::Linear;
  settings.sensor.emplace(70.0, 60.0, 512u, 424u);
  EXPECT_TRUE(sender->node()
                  .set_parameters_atomically({{points("intensity"), "linear"},
                                              {points("sensor_fov_x_deg"), 70},
                                              {points("sensor_fov_y_deg"), 60.0},
                                              {points("sensor_columns"), 512},
                                              {points("sensor_rows"), 424}})
                  .successful);
  expectNext();
}

TEST_F(ChangedParameters, OverridesThatAreWrongAreLoggedAndTheDefaultHolds)
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
  EXPECT_EQ(sender->node().get_parameter(points("resolution")).as_double(), 0.04);
  settings.compression.colour_bits = 2;
  expectNext();
  EXPECT_TRUE(sender->node().set_parameter({points("resolution"), 0.05}).successful);
  settings.compression.resolution = 0.05;
  expectNext();
}

TEST_F(ChangedParameters, AContradictionAtTheStartSendsNothingUntilItIsSetRight)
{
  layout = Layout::Xyz;
  settings = defaultSettings();
  start({{points("intensity"), "quadratic"}});
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 3; ++i)
    sender->publisher.publish(makeCloud(number++));
  const std::string log = ::testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("sensor is not set"), std::string::npos) << log;
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

TEST_F(ChangedParameters, AllAreDescribedAndHaveTheSameNamesInAnyNamespace)
{
  start(); // the nodes are in a namespace
  expectDescriptors(sender->node(), pcl_ext::nodes::encodingParameters());
  expectDescriptors(receiver->node(), pcl_ext::nodes::noiseParameters());
  const auto in_root = std::make_shared<rclcpp::Node>(
      "node_in_root",
      rclcpp::NodeOptions().parameter_overrides(
          {{"points.enable_pub_plugins",
            std::vector<std::string>{"point_cloud_transport/pcl_ext"}}}));
  auto publisher = point_cloud_transport::PointCloudTransport(in_root).advertise(
      "points", reliable());
  expectDescriptors(*in_root, pcl_ext::nodes::encodingParameters());
}

TEST_F(ChangedParameters, ThoseThatANodeDeclaresFromItsOverridesAreCheckedAndDescribed)
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
  EXPECT_EQ(sender->node().get_parameter(points("effort")).as_string(), "balanced");
  settings.compression.resolution = 0.07;
  expectNext();
}

} // namespace

} // namespace test
} // namespace pcl_ext_point_cloud_transport
