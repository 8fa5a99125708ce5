// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/point_types.h>

#include "filters/preprocessed_batches.h"
#include "support/message_layouts.h"

#include <pcl/conversions.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace {

using pcl_ext::CountIntensity;
using pcl_ext::IntensityModel;
using pcl_ext::KinectV2;
using pcl_ext::NativeIntensity;
using pcl_ext::PointXYZRGBI;
using pcl_ext::PreprocessedBatches;
using pcl_ext::PreprocessingCode;
using pcl_ext::PreprocessingStatistics;
using pcl_ext::QuadraticLaw;
using pcl_ext::SensorPreprocessor;
using pcl_ext::io::PointView;

pcl::PCLPointCloud2
randomCloud(std::uint32_t width, std::uint32_t height)
{
  std::mt19937 random(width);
  std::uniform_real_distribution<float> side(-3.0f, 3.0f);
  pcl::PointCloud<PointXYZRGBI> cloud(width, height);
  for (PointXYZRGBI& point : cloud) {
    point.x =
        random() % 20 == 0 ? std::numeric_limits<float>::quiet_NaN() : side(random);
    point.y = side(random);
    point.z = side(random) + 2.0f;
    point.intensity = side(random);
    point.rgba = static_cast<std::uint32_t>(random());
  }
  pcl::PCLPointCloud2 message;
  pcl::toPCLPointCloud2(cloud, message);
  return message;
}

template <typename ModelT>
SensorPreprocessor<ModelT, PointXYZRGBI>
makePreprocessor(const ModelT& model)
{
  SensorPreprocessor<ModelT, PointXYZRGBI> preprocessor(model);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(0.3, -0.2, 1.0));
  pose.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 0.5).normalized()));
  preprocessor.setSensorPose(pose);
  preprocessor.setCropBox({-2.0f, -2.0f, -1.0f}, {1.5f, 2.0f, 4.0f});
  return preprocessor;
}

void
expectEqual(const PreprocessingStatistics& a, const PreprocessingStatistics& b)
{
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.points_not_finite, b.points_not_finite);
  EXPECT_EQ(a.points_cropped, b.points_cropped);
  EXPECT_EQ(a.points_behind_sensor, b.points_behind_sensor);
  EXPECT_EQ(a.has_colours, b.has_colours);
}

template <typename BatchesT>
void
expectPoints(BatchesT& batches, const pcl::PointCloud<PointXYZRGBI>& expected)
{
  std::size_t read = 0;
  for (PointView points; batches.next(points);) {
    ASSERT_LE(read + points.count, expected.size());
    EXPECT_EQ(points.intensities != nullptr, batches.hasIntensities());
    EXPECT_EQ(points.colours != nullptr, batches.hasColours());
    for (std::size_t i = 0; i < points.count; ++i, ++read) {
      const float* const place = pcl_ext::io::detail::atOffset(
          points.coordinates, i * points.coordinate_stride);
      ASSERT_EQ(place[0], expected[read].x);
      ASSERT_EQ(place[1], expected[read].y);
      ASSERT_EQ(place[2], expected[read].z);
      if (points.intensities != nullptr) {
        ASSERT_EQ(*pcl_ext::io::detail::atOffset(points.intensities,
                                                 i * points.intensity_stride),
                  expected[read].intensity);
      }
      std::uint32_t colour = expected[read].rgba;
      if (points.colours != nullptr)
        std::memcpy(&colour,
                    static_cast<const unsigned char*>(points.colours) +
                        i * points.colour_stride,
                    sizeof(colour));
      ASSERT_EQ(colour, expected[read].rgba);
    }
  }
  EXPECT_EQ(read, expected.size());
  EXPECT_EQ(batches.pointsBehindSensor(), batches.statistics().points_behind_sensor);
}

template <typename ModelT>
void
expectBatches(const ModelT& model, const pcl::PCLPointCloud2& cloud)
{
  auto preprocessor = makePreprocessor(model);
  PreprocessedBatches<ModelT, PointXYZRGBI> batches(preprocessor);
  pcl::PointCloud<PointXYZRGBI> expected;
  ASSERT_TRUE(preprocessor.process(cloud, expected).ok());
  ASSERT_TRUE(batches.open(cloud).ok());
  EXPECT_EQ(batches.size(), std::size_t{cloud.width} * cloud.height);
  expectPoints(batches, expected);
  expectEqual(batches.statistics(), preprocessor.statistics());
  batches.restart();
  PointView some;
  batches.next(some);
  batches.restart();
  expectPoints(batches, expected);
  expectEqual(batches.statistics(), preprocessor.statistics());
}

/** \brief Expects that one point of a datatype is at a place to the last bit. */
void
expectPlace(std::uint8_t datatype,
            const Eigen::Vector3d& point,
            const Eigen::Vector3d& translation,
            const Eigen::Vector3d& expected)
{
  SensorPreprocessor<CountIntensity> preprocessor(CountIntensity(0.04));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = translation;
  preprocessor.setSensorPose(pose);
  // Floats are 0.5 m apart there.
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.01);
  preprocessor.setCropBox(expected - margin, expected + margin);
  PreprocessedBatches<CountIntensity> batches(preprocessor);
  using pcl_ext::test::makeField;
  const std::uint32_t size = datatype == pcl::PCLPointField::FLOAT64 ? 8 : 4;
  pcl::PCLPointCloud2 cloud =
      pcl_ext::test::makeMessage({makeField("x", 0, datatype),
                                  makeField("y", size, datatype),
                                  makeField("z", 2 * size, datatype)},
                                 3 * size,
                                 1);
  for (std::size_t axis = 0; axis < 3; ++axis)
    pcl_ext::test::writeNumber(
        &cloud.data[size * axis], datatype, point[static_cast<Eigen::Index>(axis)]);
  ASSERT_TRUE(batches.open(cloud).ok());
  PointView points;
  ASSERT_TRUE(batches.next(points));
  ASSERT_EQ(points.count, 1u);
  ASSERT_NE(points.double_coordinates, nullptr);
  EXPECT_EQ(points.coordinates, nullptr) << "they have another stride";
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    EXPECT_EQ(points.double_coordinates[axis], expected[axis]);
}

TEST(PreprocessedBatches, FarPointsKeepThePrecisionOfDoubles)
{
  using Field = pcl::PCLPointField;
  const Eigen::Vector3d far(600000.125, 5200000.0625, 400.0);
  const Eigen::Vector3d near(1.5, -2.0, 3.0);
  expectPlace(Field::FLOAT64, far, Eigen::Vector3d::Zero(), far);
  expectPlace(Field::FLOAT64, far, -far, Eigen::Vector3d::Zero());
  expectPlace(Field::FLOAT32, near, far, far + near);
}

TEST(PreprocessedBatches, HaveThePointsThatThePreprocessorWrites)
{
  for (const std::uint32_t width : {1u, 255u, 256u, 257u, 5000u})
    for (const std::uint32_t height : {1u, 7u}) {
      const pcl::PCLPointCloud2 cloud = randomCloud(width, height);
      expectBatches(CountIntensity(0.04), cloud);
      expectBatches(NativeIntensity(0.04), cloud);
      expectBatches(IntensityModel<KinectV2, QuadraticLaw>(0.04), cloud);
    }
}

TEST(PreprocessedBatches, HaveNoPointsOfEmptyAndInvalidClouds)
{
  PreprocessedBatches<NativeIntensity, PointXYZRGBI> batches(
      makePreprocessor(NativeIntensity(0.04)));
  PointView points;
  EXPECT_FALSE(batches.next(points));
  ASSERT_TRUE(batches.open(randomCloud(100, 1)).ok());
  pcl::PCLPointCloud2 cloud = randomCloud(0, 0);
  cloud.height = 4000000000u;
  ASSERT_TRUE(batches.open(cloud).ok());
  EXPECT_FALSE(batches.next(points));
  cloud = randomCloud(100, 1);
  cloud.fields.clear();
  EXPECT_EQ(batches.open(cloud).code(), PreprocessingCode::MissingField);
  batches.restart();
  EXPECT_EQ(batches.size(), 0u);
  EXPECT_FALSE(batches.next(points));
}

} // namespace
