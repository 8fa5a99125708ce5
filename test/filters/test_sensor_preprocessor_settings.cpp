/** \file
 * \brief Settings of SensorPreprocessor that are refused.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <limits>
#include <string>

namespace {

using pcl_ext::CountIntensity;
using pcl_ext::PreprocessingCode;
using pcl_ext::PreprocessingStatus;
using pcl_ext::SensorPreprocessor;

using Output = pcl::PointCloud<pcl::PointXYZI>;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

pcl::PointCloud<pcl::PointXYZ>
onePoint()
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  cloud.emplace_back(1.0f, 2.0f, 3.0f);
  return cloud;
}

/** \brief Expects both kinds of input to be refused because of the settings. */
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
  Eigen::Isometry3d scaled = Eigen::Isometry3d::Identity();
  scaled.linear() *= 1.01;
  Eigen::Isometry3d sheared = Eigen::Isometry3d::Identity();
  sheared.linear()(0, 1) = 0.1;
  Eigen::Isometry3d mirrored = Eigen::Isometry3d::Identity();
  mirrored.linear()(2, 2) = -1.0;
  Eigen::Isometry3d collapsed = Eigen::Isometry3d::Identity();
  collapsed.linear().setZero();
  Eigen::Isometry3d nan_rotation = Eigen::Isometry3d::Identity();
  nan_rotation.linear()(1, 1) = std::numeric_limits<double>::quiet_NaN();
  Eigen::Isometry3d nan_translation = Eigen::Isometry3d::Identity();
  nan_translation.translation().y() = std::numeric_limits<double>::quiet_NaN();
  Eigen::Isometry3d far_translation = Eigen::Isometry3d::Identity();
  far_translation.translation().z() = std::numeric_limits<double>::infinity();
  for (const Eigen::Isometry3d& pose : {scaled,
                                        sheared,
                                        mirrored,
                                        collapsed,
                                        nan_rotation,
                                        nan_translation,
                                        far_translation}) {
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
        preprocessor.setCropBox(bad_min, bad_max);
        expectInvalidSettings(preprocessor, "crop box");
      }
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
