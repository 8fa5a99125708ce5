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
#include <random>
#include <sstream>
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

/** \brief What a voxel shows of a share: 255 times it, saturated. */
double
shownShare(const NaiveVoxel& voxel)
{
  return 255.0 * std::min(voxel.sum, 1.0);
}

constexpr double half_a_step = 0.5 + 1e-3; // the float depth takes its part

/** \brief A cloud in front of a sensor, depths on both sides of the cut-off, and the
 * same in the world. */
struct SensedCloud {
  std::vector<double> depths;
  Cloud::Ptr in_world{new Cloud};
};

SensedCloud
senseCloud(unsigned int seed, const Eigen::Isometry3f& pose, std::size_t size = 3000)
{
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> side(-0.3f, 0.3f);
  std::uniform_real_distribution<float> depth(0.5f, 6.0f);
  SensedCloud sensed;
  const Eigen::Isometry3d exact_pose = pose.cast<double>();
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector3f in_sensor(side(generator), side(generator), depth(generator));
    pcl::PointXYZI point;
    point.getVector3fMap() = (exact_pose * in_sensor.cast<double>()).cast<float>();
    point.intensity = -1000.0f; // not read by laws of depth
    sensed.in_world->push_back(point);
  }
  // The depths of the points as the floats have them, read back in a loop of their own:
  // GCC 12 vectorizes double to float to double without the rounding between.
  for (const pcl::PointXYZI& point : *sensed.in_world) {
    const Eigen::Vector3d place = point.getVector3fMap().cast<double>();
    sensed.depths.push_back(
        exact_pose.linear().col(2).dot(place - exact_pose.translation()));
  }
  return sensed;
}

NaiveVoxels
naiveShares(const SensedCloud& sensed,
            double resolution,
            double (*share)(double, double))
{
  NaiveVoxels voxels;
  for (std::size_t i = 0; i < sensed.depths.size(); ++i) {
    NaiveVoxel& voxel = voxels[voxelOf((*sensed.in_world)[i], resolution)];
    voxel.sum += share(sensed.depths[i], resolution);
    ++voxel.count;
  }
  return voxels;
}

Eigen::Isometry3f
somePose()
{
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translate(Eigen::Vector3f(2.0f, -1.5f, 3.25f));
  pose.rotate(Eigen::AngleAxisf(2.3f, Eigen::Vector3f(0.2f, 0.9f, -0.4f).normalized()));
  return pose;
}

template <typename CompressionT>
void
expectShares(CompressionT& encoder,
             const SensedCloud& sensed,
             double (*share)(double, double),
             double tolerance = half_a_step)
{
  const double resolution = encoder.settings().resolution;
  const NaiveVoxels voxels = naiveShares(sensed, resolution, share);
  const Cloud::Ptr decoded = roundTrip(encoder, sensed.in_world);
  expectVoxelCentres(*decoded, voxels, resolution);
  expectIntensities(*decoded, voxels, resolution, shownShare, tolerance);
}

/** \brief Expects a law to take the depth from the pose of the cloud, unless the
 * settings have one. */
template <typename LawT>
void
expectSharesOfPose(double (*share)(double, double))
{
  using Encoder = CompressionWith<IntensityModel<KinectV2, LawT>>;
  for (const double resolution : {0.02, 0.04, 0.1}) {
    SCOPED_TRACE("resolution " + std::to_string(resolution));
    const SensedCloud sensed = senseCloud(7, somePose());
    sensed.in_world->sensor_origin_ << somePose().translation(), 1.0f;
    sensed.in_world->sensor_orientation_ = Eigen::Quaternionf(somePose().linear());
    Encoder by_cloud(settingsWith(resolution));
    expectShares(by_cloud, sensed, share);

    sensed.in_world->sensor_origin_ << 50.0f, 50.0f, 50.0f, 1.0f;
    IntensityCompressionSettings settings = settingsWith(resolution);
    settings.sensor_pose = somePose();
    Encoder by_settings(settings);
    expectShares(by_settings, sensed, share);
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
  const SensedCloud sensed = senseCloud(8, Eigen::Isometry3f::Identity());
  sensed.in_world->sensor_orientation_.coeffs().setZero(); // is no rotation
  CompressionWith<Model> encoder(settingsWith(0.04),
                                 Model(0.04, RuntimeSensor(70.6, 60.0, 512, 424)));
  expectShares(encoder, sensed, kinectShare);
}

TEST(IntensityModels, DepthIsAsExactFiveKilometresFromTheOrigin)
{
  // Points and pose are rounded to floats; the depth between them must not lose more.
  Eigen::Isometry3f pose = somePose();
  pose.pretranslate(Eigen::Vector3f(5000.0f, -5000.0f, 5000.0f));
  const SensedCloud sensed = senseCloud(10, pose);
  IntensityCompressionSettings settings = settingsWith(0.1);
  settings.sensor_pose = pose;
  settings.intensity_bits = 16;
  CompressionWith<IntensityModel<KinectV2, LinearLaw>> encoder(settings);
  expectShares(encoder, sensed, linearShare, 255.0 / 65535.0);
}

TEST(IntensityModels, ALawOfDepthGivesFramesADepthModel)
{
  const SensedCloud sensed = senseCloud(12, Eigen::Isometry3f::Identity());
  const auto exponentOf = [&](auto encoder) {
    std::stringstream stream(encodeFrame(encoder, sensed.in_world));
    OctreePointCloudIntensityCompression<pcl::PointXYZI> decoder;
    Cloud::Ptr decoded;
    EXPECT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    const auto& model = decoder.voxelFrame().depth_model;
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
