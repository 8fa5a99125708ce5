#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

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

using Output = pcl::PointCloud<pcl::PointXYZI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double resolution = 0.04;
constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/** \brief One point as a sensor sees it. */
struct Measurement {
  double x;
  double y;
  double z;
  double intensity;
};

struct NaiveBox {
  Eigen::Vector3d min;
  Eigen::Vector3d max;
};

struct NaiveResult {
  std::vector<Eigen::Vector4d> points; // x, y, z, intensity
  PreprocessingStatistics statistics;
};

/** \brief Intensity over depth for each kind of model, from the paper's formulas. */
double
naiveQuadratic(const Measurement& measurement)
{
  const double pi = std::acos(-1.0);
  const double footprint =
      4.0 * std::tan(35.3 * pi / 180.0) * std::tan(30.0 * pi / 180.0) / (512.0 * 424.0);
  const double share =
      footprint * measurement.z * measurement.z / (resolution * resolution);
  return measurement.z < 0.0 ? 0.0 : std::min(share, 1.0);
}

double
naiveNative(const Measurement& measurement)
{
  return measurement.intensity;
}

/** \brief The three steps one after the other, each over all points, in double. */
NaiveResult
processNaively(const std::vector<Measurement>& measurements,
               double (*intensity_of)(const Measurement&),
               const Eigen::Isometry3d& pose,
               const std::optional<NaiveBox>& box)
{
  NaiveResult result;
  result.statistics.points = measurements.size();
  std::vector<Measurement> finite;
  for (const Measurement& measurement : measurements)
    if (std::isfinite(measurement.x) && std::isfinite(measurement.y) &&
        std::isfinite(measurement.z))
      finite.push_back(measurement);
  result.statistics.points_not_finite = measurements.size() - finite.size();

  std::vector<Eigen::Vector4d> moved;
  for (const Measurement& measurement : finite) {
    const Eigen::Vector3d place =
        pose * Eigen::Vector3d(measurement.x, measurement.y, measurement.z);
    moved.emplace_back(place.x(), place.y(), place.z(), intensity_of(measurement));
  }
  for (const Eigen::Vector4d& point : moved)
    if (!box || ((point.head<3>().array() >= box->min.array()).all() &&
                 (point.head<3>().array() <= box->max.array()).all()))
      result.points.push_back(point);
  result.statistics.points_cropped = moved.size() - result.points.size();
  return result;
}

std::vector<Measurement>
randomMeasurements(unsigned int seed, std::size_t count)
{
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> side(-3.0f, 3.0f);
  std::uniform_real_distribution<float> depth(-0.5f, 20.0f); // beyond the cut-off, too
  std::uniform_int_distribution<int> intensity(0, 100);
  std::vector<Measurement> measurements;
  for (std::size_t i = 0; i < count; ++i) {
    Measurement measurement{static_cast<double>(side(generator)),
                            static_cast<double>(side(generator)),
                            static_cast<double>(depth(generator)),
                            static_cast<double>(intensity(generator))};
    if (i % 17 == 3)
      measurement.x = std::numeric_limits<double>::quiet_NaN();
    if (i % 19 == 5)
      measurement.y = std::numeric_limits<double>::infinity();
    if (i % 23 == 7)
      measurement.z = -std::numeric_limits<double>::infinity();
    measurements.push_back(measurement);
  }
  return measurements;
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
expectAgreement(const Output& output, const NaiveResult& naive, double tolerance = 1e-4)
{
  ASSERT_EQ(output.size(), naive.points.size());
  EXPECT_EQ(output.width, naive.points.size());
  EXPECT_EQ(output.height, 1u);
  EXPECT_TRUE(output.is_dense);
  for (std::size_t i = 0; i < output.size(); ++i) {
    EXPECT_NEAR(output[i].x, naive.points[i].x(), tolerance) << "point " << i;
    EXPECT_NEAR(output[i].y, naive.points[i].y(), tolerance) << "point " << i;
    EXPECT_NEAR(output[i].z, naive.points[i].z(), tolerance) << "point " << i;
    EXPECT_NEAR(output[i].intensity, naive.points[i].w(), 1e-5) << "point " << i;
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
typedCloud(const std::vector<Measurement>& measurements)
{
  pcl::PointCloud<PointT> cloud;
  for (const Measurement& measurement : measurements) {
    PointT point;
    point.x = static_cast<float>(measurement.x);
    point.y = static_cast<float>(measurement.y);
    point.z = static_cast<float>(measurement.z);
    if constexpr (pcl::traits::has_intensity<PointT>::value)
      point.intensity = static_cast<float>(measurement.intensity);
    cloud.push_back(point);
  }
  cloud.is_dense = false;
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
  const std::vector<Measurement> measurements = randomMeasurements(1, 2000);
  const NaiveBox box{Eigen::Vector3d(-6.0, -7.0, -8.0), Eigen::Vector3d(9.0, 5.0, 7.0)};
  SensorPreprocessor<QuadraticIntensity> preprocessor{QuadraticIntensity(resolution)};
  preprocessor.setSensorPose(somePose());
  preprocessor.setCropBox(box.min.cast<float>(), box.max.cast<float>());
  Output output = usedOutput();
  const PreprocessingStatus status =
      preprocessor.process(typedCloud<TypeParam>(measurements), output);
  ASSERT_TRUE(status.ok()) << status.message();
  const NaiveResult naive =
      processNaively(measurements, naiveQuadratic, somePose(), box);
  ASSERT_GT(naive.points.size(), 100u);
  ASSERT_GT(naive.statistics.points_cropped, 100u);
  expectAgreement(output, naive);
  expectStatistics(preprocessor.getStatistics(), naive.statistics);
}

TYPED_TEST(TypedClouds, NativeModelNeedsAnIntensity)
{
  const std::vector<Measurement> measurements = randomMeasurements(2, 100);
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(resolution)};
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

TEST(SensorPreprocessor, KeepsEverythingFiniteWithoutACropBox)
{
  const std::vector<Measurement> measurements = {
      {1e6, -1e6, 1e6, 0.0}, {0.0, 0.0, 0.0, 0.0}, {-5e5, 3.0, -1.0, 0.0}};
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
  Output output;
  ASSERT_TRUE(
      preprocessor.process(typedCloud<pcl::PointXYZ>(measurements), output).ok());
  ASSERT_EQ(output.size(), 3u);
  EXPECT_EQ(output[0].x, 1e6f);
  EXPECT_EQ(output[2].x, -5e5f);
  EXPECT_EQ(output[1].intensity, 1.0f);
  EXPECT_EQ(preprocessor.getStatistics().points_cropped, 0u);
}

TEST(SensorPreprocessor, BothEndsOfTheCropBoxBelongToIt)
{
  const Eigen::Vector3f min(-1.0f, -2.0f, -3.0f);
  const Eigen::Vector3f max(1.5f, 2.5f, 3.5f);
  std::vector<Measurement> on_edges;
  std::vector<Measurement> just_outside;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool is_upper : {false, true}) {
      Eigen::Vector3f point(0.0f, 0.0f, 0.0f);
      point[axis] = is_upper ? max[axis] : min[axis];
      const Eigen::Vector3d edge = point.cast<double>();
      on_edges.push_back({edge.x(), edge.y(), edge.z(), 0.0});
      point[axis] = std::nextafter(point[axis], is_upper ? infinity : -infinity);
      const Eigen::Vector3d outside = point.cast<double>();
      just_outside.push_back({outside.x(), outside.y(), outside.z(), 0.0});
    }
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
  preprocessor.setCropBox(min, max);
  Output output;
  ASSERT_TRUE(preprocessor.process(typedCloud<pcl::PointXYZ>(on_edges), output).ok());
  EXPECT_EQ(output.size(), 6u);
  ASSERT_TRUE(
      preprocessor.process(typedCloud<pcl::PointXYZ>(just_outside), output).ok());
  EXPECT_EQ(output.size(), 0u);
  EXPECT_EQ(preprocessor.getStatistics().points_cropped, 6u);
}

TEST(SensorPreprocessor, ACropBoxMayBeASinglePoint)
{
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
  preprocessor.setCropBox(Eigen::Vector3f(1.0f, 2.0f, 3.0f),
                          Eigen::Vector3f(1.0f, 2.0f, 3.0f));
  Output output;
  ASSERT_TRUE(preprocessor
                  .process(typedCloud<pcl::PointXYZ>(
                               {{1.0, 2.0, 3.0, 0.0}, {1.0, 2.0, 3.0001, 0.0}}),
                           output)
                  .ok());
  EXPECT_EQ(output.size(), 1u);
}

TEST(SensorPreprocessor, CropsInTheGlobalFrameAndTakesDepthInTheSensors)
{
  // A sensor at (0, 0, 10) that looks along the world's x axis.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(0.0, 0.0, 10.0);
  pose.linear().col(0) = Eigen::Vector3d(0.0, -1.0, 0.0);
  pose.linear().col(1) = Eigen::Vector3d(0.0, 0.0, -1.0);
  pose.linear().col(2) = Eigen::Vector3d(1.0, 0.0, 0.0);
  const IntensityModel<KinectV2, LinearLaw> model(resolution);
  SensorPreprocessor<IntensityModel<KinectV2, LinearLaw>> preprocessor{model};
  preprocessor.setSensorPose(pose);
  preprocessor.setCropBox(Eigen::Vector3f(3.0f, -1.0f, 9.0f),
                          Eigen::Vector3f(5.0f, 1.0f, 11.0f));
  Output output;
  ASSERT_TRUE(preprocessor
                  .process(typedCloud<pcl::PointXYZ>(
                               {{0.0, 0.5, 4.0, 0.0}, {0.0, 0.5, 2.0, 0.0}}),
                           output)
                  .ok());
  ASSERT_EQ(output.size(), 1u);
  EXPECT_NEAR(output[0].x, 4.0f, 1e-6f);
  EXPECT_NEAR(output[0].y, 0.0f, 1e-6f);
  EXPECT_NEAR(output[0].z, 9.5f, 1e-6f);
  EXPECT_NEAR(output[0].intensity, 4.0 / model.cutOffDepth(), 1e-6);
}

TEST(SensorPreprocessor, ClearingTheCropBoxKeepsAllPointsAgain)
{
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
  preprocessor.setCropBox(Eigen::Vector3f::Zero(), Eigen::Vector3f::Ones());
  const auto cloud = typedCloud<pcl::PointXYZ>({{0.5, 0.5, 0.5, 0.0}, {9, 9, 9, 0.0}});
  Output output;
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  EXPECT_EQ(output.size(), 1u);
  preprocessor.clearCropBox();
  ASSERT_TRUE(preprocessor.process(cloud, output).ok());
  EXPECT_EQ(output.size(), 2u);
}

TEST(SensorPreprocessor, ScaleMultipliesTheModelsIntensity)
{
  const std::vector<Measurement> measurements = randomMeasurements(3, 200);
  SensorPreprocessor<QuadraticIntensity> preprocessor{QuadraticIntensity(resolution)};
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
  auto cloud = typedCloud<pcl::PointXYZ>({{1.0, 2.0, 3.0, 0.0}});
  cloud.header.frame_id = "cell";
  cloud.header.stamp = 1234567890123u;
  cloud.header.seq = 42;
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
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
  SensorPreprocessor<QuadraticIntensity> preprocessor{QuadraticIntensity(resolution)};
  Output output;
  for (unsigned int seed = 10; seed < 15; ++seed) {
    const std::vector<Measurement> measurements =
        randomMeasurements(seed, 100 * (seed - 9));
    ASSERT_TRUE(
        preprocessor.process(typedCloud<pcl::PointXYZ>(measurements), output).ok());
    const NaiveResult naive = processNaively(
        measurements, naiveQuadratic, Eigen::Isometry3d::Identity(), std::nullopt);
    expectAgreement(output, naive);
    expectStatistics(preprocessor.getStatistics(), naive.statistics);

    EXPECT_FALSE(preprocessor.process(pcl::PCLPointCloud2(), output).ok());
    EXPECT_TRUE(output.empty());
    expectStatistics(preprocessor.getStatistics(), PreprocessingStatistics());
  }
}

TEST(SensorPreprocessor, AnEmptyCloudGivesAnEmptyCloud)
{
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
  Output output = usedOutput();
  ASSERT_TRUE(preprocessor.process(pcl::PointCloud<pcl::PointXYZ>(), output).ok());
  EXPECT_TRUE(output.empty());
  EXPECT_TRUE(output.is_dense);
  expectStatistics(preprocessor.getStatistics(), PreprocessingStatistics());

  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(pcl::PointCloud<pcl::PointXYZ>(), message);
  output = usedOutput();
  const PreprocessingStatus status = preprocessor.process(message, output);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_TRUE(output.empty());
}

TEST(SensorPreprocessor, MayWriteIntoTheCloudThatItReads)
{
  // As PCL's filters: filter(*cloud) into the input.
  auto cloud = typedCloud<pcl::PointXYZI>({{1.0, 2.0, 3.0, 7.0}, {4.0, 5.0, 6.0, 8.0}});
  SensorPreprocessor<NativeIntensity> preprocessor{NativeIntensity(resolution)};
  preprocessor.setIntensityScale(2.0f);
  ASSERT_TRUE(preprocessor.process(cloud, cloud).ok());
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud[1].x, 4.0f);
  EXPECT_EQ(cloud[1].intensity, 16.0f);
}

TEST(SensorPreprocessor, DensePromiseHoldsForPointsThatLeaveTheFloatsWhenMoved)
{
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.rotate(Eigen::AngleAxisd(std::acos(-1.0) / 4.0, Eigen::Vector3d::UnitZ()));
  SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
  preprocessor.setSensorPose(pose);
  Output output;
  ASSERT_TRUE(preprocessor
                  .process(typedCloud<pcl::PointXYZ>(
                               {{3.3e38, 3.3e38, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}}),
                           output)
                  .ok());
  ASSERT_TRUE(output.is_dense);
  for (const pcl::PointXYZI& point : output)
    EXPECT_TRUE(point.getVector3fMap().allFinite()) << point;
  const PreprocessingStatistics& statistics = preprocessor.getStatistics();
  EXPECT_EQ(statistics.points,
            output.size() + statistics.points_not_finite + statistics.points_cropped);
}

/** \brief Expects both kinds of input to be refused because of the settings. */
template <typename IntensityModelT>
void
expectInvalidSettings(SensorPreprocessor<IntensityModelT>& preprocessor,
                      const std::string& culprit)
{
  const auto cloud = typedCloud<pcl::PointXYZ>({{1.0, 2.0, 3.0, 0.0}});
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  Output output = usedOutput();
  PreprocessingStatus status = preprocessor.process(cloud, output);
  EXPECT_EQ(status.code(), PreprocessingCode::InvalidSettings);
  EXPECT_NE(status.message().find(culprit), std::string::npos) << status.message();
  EXPECT_TRUE(output.empty());
  output = usedOutput();
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
    SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
    preprocessor.setSensorPose(pose);
    expectInvalidSettings(preprocessor, "pose");
    preprocessor.setSensorPose(somePose());
    Output output;
    EXPECT_TRUE(
        preprocessor.process(typedCloud<pcl::PointXYZ>({{1, 2, 3, 0}}), output).ok());
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
        SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
        preprocessor.setCropBox(bad_min, bad_max);
        expectInvalidSettings(preprocessor, "crop box");
      }
}

TEST(SensorPreprocessorSettings, ScaleMustBeAboveZero)
{
  for (const float bad : {0.0f, -0.0f, -1.0f, not_a_number, infinity, -infinity}) {
    SensorPreprocessor<CountIntensity> preprocessor{CountIntensity(resolution)};
    preprocessor.setIntensityScale(bad);
    expectInvalidSettings(preprocessor, "scale");
  }
}

} // namespace
