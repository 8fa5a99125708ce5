// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "support/cloud_streams.h"
#include "support/naive_preprocessing.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext::test;
using pcl_ext::CountIntensity;
using pcl_ext::IntensityModel;
using pcl_ext::IntensityUnit;
using pcl_ext::KinectV2;
using pcl_ext::LinearLaw;
using pcl_ext::QuadraticLaw;
using pcl_ext::RuntimeSensor;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;

template <typename ModelT>
using CompressionWith = OctreePointCloudIntensityCompression<pcl::PointXYZI, ModelT>;

double
linearShare(double depth, double resolution)
{
  return std::sqrt(kinectShare(depth, resolution));
}

/** \brief A cloud in front of a sensor, whose pose it has. */
struct SensedCloud {
  explicit SensedCloud(const Eigen::Isometry3f& pose)
  {
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> side(-0.3, 0.3);
    std::uniform_real_distribution<double> depth(0.5, 6.0);
    const Eigen::Isometry3d exact_pose = pose.cast<double>();
    while (cloud->size() < 3000) {
      const Eigen::Vector3d in_sensor(
          side(generator), side(generator), depth(generator));
      pcl::PointXYZI point;
      point.getVector3fMap() = (exact_pose * in_sensor).cast<float>();
      point.intensity = -1000.0f; // not read by laws of depth
      cloud->push_back(point);
    }
    cloud->sensor_origin_.head<3>() = pose.translation();
    cloud->sensor_orientation_ = Eigen::Quaternionf(pose.linear());
    // The depths of the points as the floats have them, read back in a loop of their
    // own: GCC 12 vectorizes double to float to double without the rounding between.
    for (const pcl::PointXYZI& point : *cloud)
      depths.push_back(exact_pose.linear().col(2).dot(
          point.getVector3fMap().cast<double>() - exact_pose.translation()));
  }

  Cloud::Ptr cloud{new Cloud};
  std::vector<double> depths;
};

/** \brief Expects of each voxel 255 times its shares, saturated, within half a step. */
template <typename CompressionT>
void
expectShares(CompressionT&& encoder,
             const SensedCloud& sensed,
             double (*share)(double, double),
             double tolerance = 0.5 + 1e-3) // the float depth takes its part
{
  const double resolution = encoder.settings().resolution;
  std::map<VoxelIndex, double> expected;
  for (std::size_t i = 0; i < sensed.depths.size(); ++i)
    expected[voxelOf((*sensed.cloud)[i], resolution)] +=
        255.0 * share(sensed.depths[i], resolution);
  const Cloud::Ptr decoded = roundTrip(encoder, sensed.cloud);
  ASSERT_EQ(decoded->size(), expected.size());
  for (const pcl::PointXYZI& point : *decoded)
    EXPECT_NEAR(point.intensity,
                std::min(expected.at(voxelOf(point, resolution)), 255.0),
                tolerance);
}

Eigen::Isometry3f
somePose()
{
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translate(Eigen::Vector3f(2.0f, -1.5f, 3.25f));
  pose.rotate(Eigen::AngleAxisf(2.3f, Eigen::Vector3f(0.2f, 0.9f, -0.4f).normalized()));
  return pose;
}

/** \brief Expects a law to take the depth from the pose of the cloud, unless the
 * settings have one. */
template <typename LawT>
void
expectSharesOfPose(double (*share)(double, double))
{
  using Encoder = CompressionWith<IntensityModel<KinectV2, LawT>>;
  for (const double resolution : {0.02, 0.04, 0.1}) {
    SCOPED_TRACE(resolution);
    const SensedCloud sensed(somePose());
    IntensityCompressionSettings settings = settingsWith(resolution);
    expectShares(Encoder(settings), sensed, share);
    sensed.cloud->sensor_origin_ << 50.0f, 50.0f, 50.0f, 1.0f;
    settings.sensor_pose = somePose();
    expectShares(Encoder(settings), sensed, share);
  }
}

TEST(IntensityModels, LawsTakeTheDepthFromTheSensorsPose)
{
  expectSharesOfPose<QuadraticLaw>(kinectShare);
  expectSharesOfPose<LinearLaw>(linearShare);
}

TEST(IntensityModels, AModelMayHaveASensorOfItsOwn)
{
  using Model = IntensityModel<RuntimeSensor, QuadraticLaw>;
  const SensedCloud sensed(Eigen::Isometry3f::Identity());
  sensed.cloud->sensor_orientation_.coeffs().setZero(); // is no rotation
  expectShares(CompressionWith<Model>(settingsWith(0.04),
                                      Model(0.04, RuntimeSensor(70.6, 60.0, 512, 424))),
               sensed,
               kinectShare);
}

TEST(IntensityModels, DepthIsAsExactFiveKilometresFromTheOrigin)
{
  // Points and pose are rounded to floats; the depth between them must not lose more.
  Eigen::Isometry3f pose = somePose();
  pose.pretranslate(Eigen::Vector3f(5000.0f, -5000.0f, 5000.0f));
  IntensityCompressionSettings settings = settingsWith(0.1);
  settings.sensor_pose = pose;
  settings.intensity_bits = 16;
  expectShares(CompressionWith<IntensityModel<KinectV2, LinearLaw>>(settings),
               SensedCloud(pose),
               linearShare,
               255.0 / 65535.0);
}

TEST(IntensityModels, ALawOfDepthGivesFramesADepthModel)
{
  const SensedCloud sensed(Eigen::Isometry3f::Identity());
  const auto exponentOf = [&](auto encoder) {
    roundTrip(encoder, encoder, sensed.cloud);
    const auto& model = encoder.voxelFrame().depth_model;
    return model ? static_cast<int>(model->exponent) : 0;
  };
  const IntensityCompressionSettings settings = settingsWith(0.1);
  EXPECT_EQ(
      exponentOf(CompressionWith<IntensityModel<KinectV2, QuadraticLaw>>(settings)), 2);
  EXPECT_EQ(exponentOf(CompressionWith<IntensityModel<KinectV2, LinearLaw>>(settings)),
            1);
  EXPECT_EQ(exponentOf(CompressionWith<CountIntensity>(settings)), 0);
}

/** \brief A model of a user, by the contract alone: no base, no typedefs, no default or
 * resolution constructor. */
class HeightIntensity {
public:
  static constexpr IntensityUnit unit = IntensityUnit::Points;
  static constexpr bool uses_depth = true;
  static constexpr bool uses_native = false;

  HeightIntensity(float offset, int factor) : offset_(offset), factor_(factor) {}

  float
  operator()(float depth, float /*native*/) const
  {
    return std::floor(depth + offset_) * static_cast<float>(factor_);
  }

private:
  float offset_;
  int factor_;
};

TEST(IntensityModels, AUsersModelNeedsTheContractOnly)
{
  Cloud::Ptr cloud(new Cloud);
  for (int i = 0; i < 20; ++i)
    cloud->push_back(pcl::PointXYZI(0.01f, 0.01f, static_cast<float>(i) + 0.5f, 0.0f));
  CompressionWith<HeightIntensity> encoder(settingsWith(0.04),
                                           HeightIntensity(1.0f, 3));
  const Cloud::Ptr decoded = roundTrip(encoder, cloud);
  ASSERT_EQ(decoded->size(), 20u);
  for (const pcl::PointXYZI& point : *decoded)
    EXPECT_EQ(point.intensity, 3.0f * (std::floor(point.z) + 1.0f));
}

/** \brief A model of a user that is made from the voxel edge, as the contract allows.
 */
struct EdgeIntensity {
  static constexpr IntensityUnit unit = IntensityUnit::Native;
  static constexpr bool uses_depth = false;
  static constexpr bool uses_native = false;

  explicit EdgeIntensity(double resolution) : edge(resolution) {}

  float
  operator()(float depth, float native) const
  {
    return depth == 0.0f && native == 0.0f ? static_cast<float>(edge * 100.0) : -1.0f;
  }

  double edge;
};

TEST(IntensityModels, AUsersModelMayBeMadeFromTheResolution)
{
  Cloud::Ptr cloud(new Cloud(1, 1, pcl::PointXYZI(1.0f, 2.0f, 3.0f, 0.0f)));
  CompressionWith<EdgeIntensity> encoder(settingsWith(0.5));
  const Cloud::Ptr decoded = roundTrip(encoder, cloud);
  ASSERT_EQ(decoded->size(), 1u);
  EXPECT_EQ(decoded->front().intensity, 50.0f);
}

} // namespace
