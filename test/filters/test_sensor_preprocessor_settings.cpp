// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "support/float_values.h"
#include "support/naive_preprocessing.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <string>

namespace {

using pcl_ext::CountIntensity;
using pcl_ext::PreprocessingCode;
using pcl_ext::PreprocessingStatus;
using pcl_ext::SensorPreprocessor;
using pcl_ext::test::infinity;
using pcl_ext::test::not_a_number;

using Output = pcl::PointCloud<pcl::PointXYZI>;

pcl::PointCloud<pcl::PointXYZ>
onePoint()
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  cloud.emplace_back(1.0f, 2.0f, 3.0f);
  return cloud;
}

template <typename IntensityModelT>
void
expectInvalidSettings(SensorPreprocessor<IntensityModelT>& preprocessor,
                      const std::string& culprit)
{
  const pcl::PointCloud<pcl::PointXYZ> cloud = onePoint();
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  Output output;
  output.resize(7); // of an earlier call
  PreprocessingStatus status = preprocessor.process(cloud, output);
  EXPECT_EQ(status.code(), PreprocessingCode::InvalidSettings);
  EXPECT_NE(status.message().find(culprit), std::string::npos) << status.message();
  EXPECT_TRUE(output.empty());
  output.resize(7);
  status = preprocessor.process(message, output);
  EXPECT_EQ(status.code(), PreprocessingCode::InvalidSettings);
  EXPECT_NE(status.message().find(culprit), std::string::npos) << status.message();
  EXPECT_TRUE(output.empty());
}

TEST(SensorPreprocessorSettings, PoseMustBeARotationAndATranslation)
{
  for (const Eigen::Isometry3d& pose :
       pcl_ext::test::invalidPoses<Eigen::Isometry3d>(Eigen::Isometry3d::Identity())) {
    SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
    preprocessor.setSensorPose(pose);
    expectInvalidSettings(preprocessor, "pose");
    preprocessor.setSensorPose(Eigen::Isometry3d::Identity());
    Output output;
    EXPECT_TRUE(preprocessor.process(onePoint(), output).ok());
  }
}

TEST(SensorPreprocessorSettings, CropBoxMustBeABox)
{
  const Eigen::Vector3f min(-1.0f, -1.0f, -1.0f);
  const Eigen::Vector3f max(1.0f, 1.0f, 1.0f);
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true})
      for (const float bad : {is_upper ? -1.5f : 1.5f, not_a_number}) {
        Eigen::Vector3f bad_min = min;
        Eigen::Vector3f bad_max = max;
        (is_upper ? bad_max : bad_min)[axis] = bad;
        SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
        preprocessor.setCropBox(bad_min.cast<double>(), bad_max.cast<double>());
        expectInvalidSettings(preprocessor, "crop box");
      }
}

TEST(SensorPreprocessorSettings, CropBoxMayReachBeyondTheRangeOfFloats)
{
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(1e300);
  Output output;
  preprocessor.setCropBox(-far, far);
  EXPECT_TRUE(preprocessor.process(onePoint(), output).ok());
  EXPECT_EQ(output.size(), 1u);
  preprocessor.setCropBox(far, far);
  EXPECT_TRUE(preprocessor.process(onePoint(), output).ok());
  EXPECT_EQ(output.size(), 0u);
}

TEST(SensorPreprocessorSettings, ScaleMustBeAboveZero)
{
  for (const float bad : {0.0f, -0.0f, -1.0f, not_a_number, infinity, -infinity}) {
    SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(0.04)};
    preprocessor.setIntensityScale(bad);
    expectInvalidSettings(preprocessor, "scale");
  }
}

} // namespace
