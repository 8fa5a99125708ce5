// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"
#include "support/text_parts.h"

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <string>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
using Quadratic = OctreePointCloudIntensityCompression<
    pcl::PointXYZI,
    pcl_ext::IntensityModel<pcl_ext::KinectV2, pcl_ext::QuadraticLaw>>;

TEST(CompressionWarnings, PointsBehindTheSensor)
{
  // As PCL writes the files of a Kinect: y up and z towards the viewer, VIEWPOINT
  // 0 0 0 0 1 0 0, which turns the optical axis away from the points.
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 100, {0.0, 0.0, 3.0}, 1.0);
  cloud->sensor_orientation_ = Eigen::Quaternionf(0.0f, 1.0f, 0.0f, 0.0f);
  std::stringstream stream;
  Quadratic behind(settingsWith(usual_resolution));
  const CompressionStatus status = behind.encodePointCloud(cloud, stream);
  EXPECT_TRUE(status.hasWarning());
  EXPECT_TRUE(hasPart(status.message(), "100 of 100 points are behind the sensor"));
  EXPECT_EQ(behind.statistics().voxelization.points_behind_sensor, 100u);

  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.sensor_pose = SensorPose::Identity();
  Quadratic before(settings);
  EXPECT_FALSE(before.encodePointCloud(cloud, stream).hasWarning());
  Compression native(settingsWith(usual_resolution));
  EXPECT_FALSE(native.encodePointCloud(cloud, stream).hasWarning());
}

TEST(CompressionWarnings, APoseThatIsNotFiniteIsRefused)
{
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 100, {0.0, 0.0, 3.0}, 1.0);
  const float undefined = std::numeric_limits<float>::quiet_NaN();
  std::stringstream stream;
  Quadratic encoder(settingsWith(usual_resolution));
  cloud->sensor_origin_.y() = undefined;
  expectCode(encoder.encodePointCloud(cloud, stream), CompressionCode::InvalidInput);
  cloud->sensor_origin_.y() = 0.0f;
  cloud->sensor_orientation_.w() = undefined;
  expectCode(encoder.encodePointCloud(cloud, stream), CompressionCode::InvalidInput);
  Compression native(settingsWith(usual_resolution)); // does not use it
  expectCode(native.encodePointCloud(cloud, stream), CompressionCode::Ok);
}

TEST(CompressionWarnings, AreOnPclsConsoleOnceForEachKind)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.bounding_box = BoundingBox{{-1.0, -1.0, 0.0}, {1.0, 1.0, 1.0}};
  settings.intensity_range = 300.0f;
  Compression compression(settings);
  const auto printed = [&](std::initializer_list<pcl::PointXYZI> points) {
    const Cloud::Ptr cloud(new Cloud);
    for (const pcl::PointXYZI& point : points)
      cloud->push_back(point);
    std::stringstream stream;
    ::testing::internal::CaptureStderr();
    const CompressionStatus status = compression.encodePointCloud(cloud, stream);
    EXPECT_TRUE(status.hasWarning());
    const std::string text = ::testing::internal::GetCapturedStderr();
    EXPECT_TRUE(text.empty() || text.find(status.message()) != std::string::npos);
    return !text.empty();
  };
  const pcl::PointXYZI inside(0.0f, 0.0f, 0.5f, 1.0f);
  const pcl::PointXYZI outside(0.0f, 0.0f, 1.5f, 1.0f);
  const pcl::PointXYZI bright(0.0f, 0.0f, 0.5f, 301.0f);
  const auto verbosity = pcl::console::getVerbosityLevel();
  pcl::console::setVerbosityLevel(pcl::console::L_WARN);
  EXPECT_TRUE(printed({inside, outside}));
  EXPECT_FALSE(printed({inside, outside, outside})); // another number of them
  EXPECT_TRUE(printed({bright}));
  EXPECT_FALSE(printed({bright}));
  pcl::console::setVerbosityLevel(verbosity);
}

// ---------------------------------------------------------------- memory and moves

TEST(CompressionInMemory, HasTheBytesOfAStream)
{
  Compression to_stream(settingsWith(usual_resolution));
  Compression to_memory(settingsWith(usual_resolution));
  const auto cloud = randomCloud<pcl::PointXYZI>(1, 300);
  for (int frame = 0; frame < 2; ++frame) {
    std::vector<std::uint8_t> bytes(7, 1);
    expectCode(to_memory.encodePointCloud(cloud, bytes), CompressionCode::Ok);
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), encodeFrame(to_stream, cloud));
    bytes.push_back('P'); // of the next frame
    Cloud::Ptr decoded;
    expectCode(to_memory.decodePointCloud(bytes.data(), bytes.size(), decoded),
               CompressionCode::Ok);
    expectVoxelCentres(
        *decoded, naiveVoxels(*cloud, usual_resolution), usual_resolution);
    EXPECT_EQ(to_memory.statistics().coding.bytes, bytes.size() - 1);
  }
}

/** \brief Encodes and decodes the next frame, with an octree of the decoded voxels. */
template <typename CompressionT>
void
expectStreamsToContinue(CompressionT& compression,
                        CompressionT& peer,
                        unsigned int seed)
{
  const auto cloud = randomCloud<pcl::PointXYZI>(seed, 300);
  Cloud::Ptr decoded;
  EXPECT_TRUE(decodeBytes(peer, encodeFrame(compression, cloud), decoded).ok());
  EXPECT_TRUE(decodeBytes(compression, encodeFrame(peer, cloud), decoded).ok());
  expectVoxelCentres(*decoded, naiveVoxels(*cloud, usual_resolution), usual_resolution);
  EXPECT_EQ(compression.getLeafCount(), decoded->size());
}

template <typename CompressionT>
void
expectMovesToContinue()
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.retain_octree = true;
  CompressionT compression(settings);
  CompressionT peer(settings);
  expectStreamsToContinue(compression, peer, 1);
  const std::size_t leaves = compression.getLeafCount();
  CompressionT moved(std::move(compression));
  EXPECT_EQ(moved.getLeafCount(), leaves);
  EXPECT_TRUE(moved.getOutputCloud());
  expectStreamsToContinue(moved, peer, 1);
  EXPECT_FALSE(moved.statistics().coding.is_i_frame);
  CompressionT assigned(settingsWith(1.0));
  EXPECT_FALSE(assigned.isVoxelOccupiedAtPoint(pcl::PointXYZI()));
  assigned = std::move(moved);
  EXPECT_EQ(assigned.getLeafCount(), leaves);
  EXPECT_EQ(assigned.getResolution(), usual_resolution);
  EXPECT_TRUE(assigned.isVoxelOccupiedAtPoint(assigned.getOutputCloud()->front()));
  expectStreamsToContinue(assigned, peer, 1);
  EXPECT_FALSE(assigned.statistics().coding.is_i_frame);
}

TEST(CompressionMoves, StreamsAndOctreeContinue)
{
  expectMovesToContinue<Compression>();
  expectMovesToContinue<Compression::SinglePointCloudCompressionLowMemory>();
}
} // namespace
