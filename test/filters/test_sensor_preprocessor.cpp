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

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::test;
using pcl_ext::CountIntensity;
using pcl_ext::IntensityModel;
using pcl_ext::KinectV2;
using pcl_ext::LinearLaw;
using pcl_ext::NativeIntensity;
using pcl_ext::PreprocessingCode;
using pcl_ext::PreprocessingStatistics;
using pcl_ext::PreprocessingStatus;
using pcl_ext::QuadraticLaw;
using pcl_ext::SensorPreprocessor;
using pcl_ext::io::BoundingBox;

using Output = pcl::PointCloud<pcl::PointXYZI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double preprocessed_resolution = 0.04;

double
naiveQuadratic(const pcl::PointXYZI& point)
{
  return kinectShare(static_cast<double>(point.z), preprocessed_resolution);
}

struct NaiveResult {
  Output points;
  PreprocessingStatistics statistics;
};

NaiveResult
processNaively(const Output& cloud,
               const PointIntensity& intensity_of,
               const Eigen::Isometry3d& pose,
               const std::optional<BoundingBox>& box)
{
  NaiveResult result;
  result.points = naivelyPreprocessed(cloud, pose, intensity_of, box);
  result.statistics.points = cloud.size();
  for (const pcl::PointXYZI& point : cloud)
    result.statistics.points_not_finite += point.getVector3fMap().allFinite() ? 0 : 1;
  result.statistics.points_cropped =
      cloud.size() - result.statistics.points_not_finite - result.points.size();
  return result;
}

Output
randomMeasurements(unsigned int seed, std::size_t count)
{
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> side(-3.0f, 3.0f);
  std::uniform_real_distribution<float> depth(-0.5f, 20.0f); // beyond the cut-off, too
  std::uniform_int_distribution<int> intensity(0, 100);
  Output cloud;
  for (std::size_t i = 0; i < count; ++i) {
    pcl::PointXYZI point;
    point.x = i % 17 == 3 ? not_a_number : side(generator);
    point.y = i % 19 == 5 ? infinity : side(generator);
    point.z = i % 23 == 7 ? -infinity : depth(generator);
    point.intensity = static_cast<float>(intensity(generator));
    cloud.push_back(point);
  }
  return cloud;
}

Eigen::Isometry3d
somePose()
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(1.5, -2.25, 3.0));
  pose.rotate(Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()));
  return pose;
}

void
expectAgreement(const Output& output, const NaiveResult& naive)
{
  ASSERT_EQ(output.size(), naive.points.size());
  EXPECT_EQ(output.width, naive.points.size());
  EXPECT_EQ(output.height, 1u);
  EXPECT_TRUE(output.is_dense);
  for (std::size_t i = 0; i < output.size(); ++i) {
    EXPECT_NEAR(output[i].x, naive.points[i].x, 1e-4f) << "point " << i;
    EXPECT_NEAR(output[i].y, naive.points[i].y, 1e-4f) << "point " << i;
    EXPECT_NEAR(output[i].z, naive.points[i].z, 1e-4f) << "point " << i;
    EXPECT_NEAR(output[i].intensity, naive.points[i].intensity, 1e-5f) << "point " << i;
  }
}

void
expectStatistics(const PreprocessingStatistics& statistics,
                 const PreprocessingStatistics& expected)
{
  EXPECT_EQ(statistics.points, expected.points);
  EXPECT_EQ(statistics.points_not_finite, expected.points_not_finite);
  EXPECT_EQ(statistics.points_cropped, expected.points_cropped);
}

/** \brief An output that still holds what an earlier call left in it. */
Output
usedOutput()
{
  Output output;
  output.resize(7);
  output.is_dense = false;
  return output;
}

template <typename PointT>
pcl::PointCloud<PointT>
typedCloud(const Output& points)
{
  pcl::PointCloud<PointT> cloud;
  for (const pcl::PointXYZI& point : points) {
    PointT typed;
    typed.getVector3fMap() = point.getVector3fMap();
    if constexpr (pcl::traits::has_intensity<PointT>::value)
      typed.intensity = point.intensity;
    cloud.push_back(typed);
  }
  cloud.is_dense = false;
  return cloud;
}

pcl::PointCloud<pcl::PointXYZ>
cloudOf(const std::vector<Eigen::Vector3f>& places)
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (const Eigen::Vector3f& place : places)
    cloud.push_back(pcl::PointXYZ(place.x(), place.y(), place.z()));
  return cloud;
}

template <typename PointT>
class TypedClouds : public ::testing::Test {};

using TypedPoints = ::testing::Types<pcl::PointXYZ,
                                     pcl::PointXYZI,
                                     pcl::PointXYZL,
                                     pcl::PointXYZRGB,
                                     pcl::PointXYZRGBA,
                                     pcl::PointXYZRGBNormal,
                                     pcl::PointXYZINormal,
                                     pcl::PointNormal>;
TYPED_TEST_SUITE(TypedClouds, TypedPoints);

TYPED_TEST(TypedClouds, AgreeWithThreeNaivePasses)
{
  const Output measurements = randomMeasurements(1, 2000);
  const BoundingBox box{{-6.0, -7.0, -8.0}, {9.0, 5.0, 7.0}};
  SensorPreprocessor<QuadraticIntensity> preprocessor{
      QuadraticIntensity(preprocessed_resolution)};
  preprocessor.setSensorPose(somePose());
  preprocessor.setCropBox({-6.0, -7.0, -8.0}, {9.0, 5.0, 7.0});
  Output output = usedOutput();
  const PreprocessingStatus status =
      preprocessor.process(typedCloud<TypeParam>(measurements), output);
  ASSERT_TRUE(status.ok()) << status.message();
  const NaiveResult naive =
      processNaively(measurements, naiveQuadratic, somePose(), box);
  ASSERT_GT(naive.points.size(), 100u);
  ASSERT_GT(naive.statistics.points_cropped, 100u);
  expectAgreement(output, naive);
  expectStatistics(preprocessor.statistics(), naive.statistics);
}

TYPED_TEST(TypedClouds, NativeModelNeedsAnIntensity)
{
  const Output measurements = randomMeasurements(2, 100);
  SensorPreprocessor<NativeIntensity> preprocessor{
      NativeIntensity(preprocessed_resolution)};
  Output output = usedOutput();
  const PreprocessingStatus status =
      preprocessor.process(typedCloud<TypeParam>(measurements), output);
  if (pcl::traits::has_intensity<TypeParam>::value) {
    ASSERT_TRUE(status.ok()) << status.message();
    expectAgreement(
        output,
        processNaively(
            measurements, naiveNative, Eigen::Isometry3d::Identity(), std::nullopt));
  }
  else {
    EXPECT_EQ(status.code(), PreprocessingCode::MissingField);
    EXPECT_NE(status.message().find("intensity"), std::string::npos);
    EXPECT_TRUE(output.empty());
  }
}

TEST(SensorPreprocessor, BothEndsOfTheCropBoxBelongToIt)
{
  const Eigen::Vector3f min(-1.0f, -2.0f, -3.0f);
  const Eigen::Vector3f max(1.5f, 2.5f, 3.5f);
  std::vector<Eigen::Vector3f> on_edges;
  std::vector<Eigen::Vector3f> just_outside;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true}) {
      Eigen::Vector3f point(0.0f, 0.0f, 0.0f);
      point[axis] = is_upper ? max[axis] : min[axis];
      on_edges.push_back(point);
      point[axis] = std::nextafter(point[axis], is_upper ? infinity : -infinity);
      just_outside.push_back(point);
    }
  SensorPreprocessor<CountIntensity> preprocessor{
      CountIntensity(preprocessed_resolution)};
  preprocessor.setCropBox(min.cast<double>(), max.cast<double>());
  Output output;
  ASSERT_TRUE(preprocessor.process(cloudOf(on_edges), output).ok());
  EXPECT_EQ(output.size(), 6u);
  ASSERT_TRUE(preprocessor.process(cloudOf(just_outside), output).ok());
  EXPECT_EQ(output.size(), 0u);
  EXPECT_EQ(preprocessor.statistics().points_cropped, 6u);
  preprocessor.setCropBox(max.cast<double>(), max.cast<double>()); // a single point
  ASSERT_TRUE(preprocessor.process(cloudOf({max, min}), output).ok());
  EXPECT_EQ(output.size(), 1u);
}

TEST(SensorPreprocessor, ClearingTheCropBoxKeepsAllPointsAgain)
{
  SensorPreprocessor<CountIntensity> preprocessor{
      CountIntensity(preprocessed_resolution)};
  preprocessor.setCropBox(Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
  const auto cloud = cloudOf({{0.5f, 0.5f, 0.5f}, {1e6f, -1e6f, 1e6f}});
  Output output;
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  EXPECT_EQ(output.size(), 1u);
  preprocessor.clearCropBox();
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  ASSERT_EQ(output.size(), 2u);
  EXPECT_EQ(output[1].y, -1e6f);
  EXPECT_EQ(output[1].intensity, 1.0f);
  EXPECT_EQ(preprocessor.statistics().points_cropped, 0u);
}

TEST(SensorPreprocessor, ScaleMultipliesTheModelsIntensity)
{
  const Output measurements = randomMeasurements(3, 200);
  SensorPreprocessor<QuadraticIntensity> preprocessor{
      QuadraticIntensity(preprocessed_resolution)};
  Output plain;
  Output scaled;
  ASSERT_TRUE(
      preprocessor.process(typedCloud<pcl::PointXYZ>(measurements), plain).ok());
  preprocessor.setIntensityScale(255.0f);
  ASSERT_TRUE(
      preprocessor.process(typedCloud<pcl::PointXYZ>(measurements), scaled).ok());
  ASSERT_EQ(plain.size(), scaled.size());
  ASSERT_FALSE(plain.empty());
  for (std::size_t i = 0; i < plain.size(); ++i)
    EXPECT_FLOAT_EQ(scaled[i].intensity, 255.0f * plain[i].intensity);
}

TEST(SensorPreprocessor, OutputCarriesHeaderAndSensorPose)
{
  auto cloud = cloudOf({{1.0f, 2.0f, 3.0f}});
  cloud.header.frame_id = "cell";
  cloud.header.stamp = 1234567890123u;
  cloud.header.seq = 42;
  SensorPreprocessor<CountIntensity> preprocessor{
      CountIntensity(preprocessed_resolution)};
  preprocessor.setSensorPose(somePose());
  Output output;
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  EXPECT_EQ(output.header.frame_id, "cell");
  EXPECT_EQ(output.header.stamp, 1234567890123u);
  EXPECT_EQ(output.header.seq, 42u);
  const Eigen::Vector3d origin = somePose().translation();
  EXPECT_NEAR(output.sensor_origin_.x(), origin.x(), 1e-6);
  EXPECT_NEAR(output.sensor_origin_.y(), origin.y(), 1e-6);
  EXPECT_NEAR(output.sensor_origin_.z(), origin.z(), 1e-6);
  EXPECT_TRUE(output.sensor_orientation_.toRotationMatrix().isApprox(
      somePose().linear().cast<float>(), 1e-5f));
}

TEST(SensorPreprocessor, OneInstanceServesManyCloudsAndSurvivesBadOnes)
{
  SensorPreprocessor<QuadraticIntensity> preprocessor{
      QuadraticIntensity(preprocessed_resolution)};
  Output output;
  for (unsigned int seed = 10; seed < 15; ++seed) {
    const Output measurements = randomMeasurements(seed, 100 * (seed - 9));
    ASSERT_TRUE(
        preprocessor.process(typedCloud<pcl::PointXYZ>(measurements), output).ok());
    const NaiveResult naive = processNaively(
        measurements, naiveQuadratic, Eigen::Isometry3d::Identity(), std::nullopt);
    expectAgreement(output, naive);
    expectStatistics(preprocessor.statistics(), naive.statistics);

    EXPECT_FALSE(preprocessor.process(pcl::PCLPointCloud2(), output).ok());
    EXPECT_TRUE(output.empty());
    expectStatistics(preprocessor.statistics(), PreprocessingStatistics());
  }
}

TEST(SensorPreprocessor, AnEmptyCloudGivesAnEmptyCloud)
{
  SensorPreprocessor<CountIntensity> preprocessor{
      CountIntensity(preprocessed_resolution)};
  Output output = usedOutput();
  ASSERT_TRUE(preprocessor.process(pcl::PointCloud<pcl::PointXYZ>(), output).ok());
  EXPECT_TRUE(output.empty());
  EXPECT_TRUE(output.is_dense);
  expectStatistics(preprocessor.statistics(), PreprocessingStatistics());
}

using CountingPreprocessor = SensorPreprocessor<CountIntensity>;

/** \brief Expects that settings are refused with a word, in both ways to call it. */
template <typename SetT>
void
expectInvalidSettings(const SetT& set, const std::string& culprit)
{
  CountingPreprocessor preprocessor{CountIntensity(preprocessed_resolution)};
  set(preprocessor);
  const auto cloud = cloudOf({{1.0f, 2.0f, 3.0f}});
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  for (const bool is_typed : {true, false}) {
    Output output = usedOutput();
    const PreprocessingStatus status = is_typed ? preprocessor.process(cloud, output)
                                                : preprocessor.process(message, output);
    EXPECT_EQ(status.code(), PreprocessingCode::InvalidSettings);
    EXPECT_NE(status.message().find(culprit), std::string::npos) << status.message();
    EXPECT_TRUE(output.empty());
  }
  // It goes on with others.
  preprocessor.setSensorPose(Eigen::Isometry3d::Identity());
  preprocessor.setIntensityScale(1.0f);
  preprocessor.clearCropBox();
  Output output;
  EXPECT_TRUE(preprocessor.process(cloud, output).ok());
}

TEST(SensorPreprocessorSettings, InvalidOnesAreRefused)
{
  for (const Eigen::Isometry3d& pose :
       invalidPoses<Eigen::Isometry3d>(Eigen::Isometry3d::Identity()))
    expectInvalidSettings(
        [&](CountingPreprocessor& preprocessor) { preprocessor.setSensorPose(pose); },
        "pose");
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true})
      for (const float bad : {is_upper ? -1.5f : 1.5f, not_a_number}) {
        Eigen::Vector3d min = Eigen::Vector3d::Constant(-1.0);
        Eigen::Vector3d max = Eigen::Vector3d::Constant(1.0);
        (is_upper ? max : min)[axis] = double{bad};
        expectInvalidSettings(
            [&](CountingPreprocessor& preprocessor) {
              preprocessor.setCropBox(min, max);
            },
            "crop box");
      }
  for (const float bad : {0.0f, -0.0f, -1.0f, not_a_number, infinity, -infinity})
    expectInvalidSettings(
        [bad](CountingPreprocessor& preprocessor) {
          preprocessor.setIntensityScale(bad);
        },
        "scale");
}

TEST(SensorPreprocessorSettings, CropBoxMayReachBeyondTheRangeOfFloats)
{
  CountingPreprocessor preprocessor{CountIntensity(preprocessed_resolution)};
  const Eigen::Vector3d far = Eigen::Vector3d::Constant(1e300);
  const auto cloud = cloudOf({{1.0f, 2.0f, 3.0f}});
  Output output;
  preprocessor.setCropBox(-far, far);
  EXPECT_TRUE(preprocessor.process(cloud, output).ok());
  EXPECT_EQ(output.size(), 1u);
  preprocessor.setCropBox(far, far);
  EXPECT_TRUE(preprocessor.process(cloud, output).ok());
  EXPECT_EQ(output.size(), 0u);
}

} // namespace
