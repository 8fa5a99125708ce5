// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Parameters of both ends that are changed while clouds flow.
 */
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "parameter_test.h"

#include <algorithm>

namespace pcl_ext_point_cloud_transport::test {

namespace {

using ChangedParameters = ParameterTest;

TEST_F(ChangedParameters, ThoseOfTheSenderHoldFromTheNextCloudOn)
{
  start();
  expectNext();
  setAndExpect("resolution", settings.compression.resolution = 0.1);
  setAndExpect("colour_bits", static_cast<int>(settings.compression.colour_bits = 3));
  settings.law = pcl_ext::IntensityLaw::Count;
  setAndExpect("intensity", "count");
  settings.law = pcl_ext::IntensityLaw::Native;
  setAndExpect("intensity", "automatic");
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
  settings.compression.resolution = 0.04;
  settings.law = pcl_ext::IntensityLaw::Count;
  start({{points("resolution"), 0.04}, {points("intensity"), "count"}},
        {{points("min_intensity"), 2}}); // a whole number
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
  pcl_ext::VoxelOutlierRemoval filter({pcl_ext::PointsUnit(), 2.0f});
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
      // The text may be that of rclcpp, whose check of ranges is first.
      {{points("resolution"), 0.0}, "resolution"},
      {{points("resolution"), std::nan("")}, "resolution"},
      {{points("resolution"), "fine"},
       "resolution is 'fine'; it must be a number from"},
      {{points("effort"), "quick"},
       "effort is 'quick'; it must be one of: fast, balanced, small"},
      {{points("i_frame_rate"), 2.5}, "i_frame_rate is 2.5; it must be a whole number"},
      {{points("crop_box"), std::vector<double>{1, 2, 3}},
       "crop_box is [1, 2, 3]; it must"},
      {{points("crop_box"), std::vector<std::string>{"a"}},
       "crop_box is [a]; it must be"},
      {{points("intensity"), "quadratic"}, points("sensor is not set")},
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

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
