#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/intensity/sensor.h>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace {

using pcl_ext::CountIntensity;
using pcl_ext::NativeIntensity;
using pcl_ext::io::BoundingBox;
using pcl_ext::io::CompressionCode;
using pcl_ext::io::CompressionStatus;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::test::expectIntensities;
using pcl_ext::test::expectVoxelCentres;
using pcl_ext::test::NaiveVoxel;
using pcl_ext::test::NaiveVoxels;
using pcl_ext::test::naiveVoxels;
using pcl_ext::test::randomCloud;
using pcl_ext::test::roundTrip;
using pcl_ext::test::settingsWith;
using pcl_ext::test::voxelOf;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

// The model that nobody chose: native if there is something native.
static_assert(std::is_same<pcl_ext::io::DefaultIntensityModel<pcl::PointXYZI>,
                           NativeIntensity>::value,
              "");
static_assert(std::is_same<pcl_ext::io::DefaultIntensityModel<pcl::PointXYZINormal>,
                           NativeIntensity>::value,
              "");
static_assert(std::is_same<pcl_ext::io::DefaultIntensityModel<pcl::PointXYZ>,
                           CountIntensity>::value,
              "");
static_assert(std::is_same<pcl_ext::io::DefaultIntensityModel<pcl::PointXYZRGB>,
                           CountIntensity>::value,
              "");

/** \brief Where a cloud lies and how finely it is voxelized. */
struct Place {
  double resolution;
  std::array<double, 3> centre;
};

class VoxelsOfPlace : public ::testing::TestWithParam<Place> {};

TEST_P(VoxelsOfPlace, PointXYZBecomesVoxelCentres)
{
  const Place& place = GetParam();
  const auto cloud = randomCloud<pcl::PointXYZ>(1, 3000, place.centre);
  const auto decoded = roundTrip<pcl::PointXYZ>(place.resolution, cloud);
  expectVoxelCentres(*decoded, naiveVoxels(*cloud, place.resolution), place.resolution);
}

TEST_P(VoxelsOfPlace, PointXYZIKeepsItsMeanIntensityInItsUnit)
{
  const Place& place = GetParam();
  const auto cloud = randomCloud<pcl::PointXYZI>(2, 3000, place.centre);
  const auto decoded = roundTrip<pcl::PointXYZI>(place.resolution, cloud);
  const NaiveVoxels voxels = naiveVoxels(*cloud, place.resolution);
  expectVoxelCentres(*decoded, voxels, place.resolution);
  // Whole numbers up to 255 are coded in steps of one.
  expectIntensities(
      *decoded,
      voxels,
      place.resolution,
      [](const NaiveVoxel& voxel) { return voxel.mean(); },
      0.5 + 1e-6);
}

TEST_P(VoxelsOfPlace, VoxelsOfOnePointKeepAWholeIntensityExactly)
{
  const Place& place = GetParam();
  const auto cloud = randomCloud<pcl::PointXYZI>(3, 40, place.centre);
  const NaiveVoxels voxels = naiveVoxels(*cloud, place.resolution);
  std::size_t single_points = 0;
  const auto decoded = roundTrip<pcl::PointXYZI>(place.resolution, cloud);
  for (const pcl::PointXYZI& point : *decoded) {
    const NaiveVoxel& voxel = voxels.at(voxelOf(point, place.resolution));
    if (voxel.count != 1)
      continue;
    EXPECT_EQ(static_cast<double>(point.intensity), voxel.sum);
    ++single_points;
  }
  EXPECT_GT(single_points, 10u);
}

INSTANTIATE_TEST_SUITE_P(Places,
                         VoxelsOfPlace,
                         ::testing::Values(Place{0.01, {0.0, 0.0, 0.0}},
                                           Place{0.02, {0.0, 0.0, 0.0}},
                                           Place{0.04, {0.0, 0.0, 0.0}},
                                           Place{0.1, {0.0, 0.0, 0.0}},
                                           Place{0.01, {5000.0, -5000.0, 5000.0}},
                                           Place{0.02, {-5000.0, 5000.0, 5000.0}},
                                           Place{0.04, {5000.0, 5000.0, -5000.0}},
                                           Place{0.1, {-5000.0, -5000.0, -5000.0}},
                                           Place{0.04, {-3.0, -7.0, -0.5}},
                                           Place{0.03, {12.3, 0.0, -4.5}}));

TEST(IntensityCompression, PointsOnVoxelFacesGoToTheVoxelThatTheyBegin)
{
  const double resolution = 0.25; // exact
  Cloud::Ptr cloud(new Cloud);
  for (int i = -4; i <= 4; ++i) {
    pcl::PointXYZI point;
    point.x = 0.25f * static_cast<float>(i);
    point.y = point.z = 0.0f;
    point.intensity = static_cast<float>(i + 4);
    cloud->push_back(point);
  }
  const auto decoded = roundTrip<pcl::PointXYZI>(resolution, cloud);
  ASSERT_EQ(decoded->size(), 9u);
  for (const pcl::PointXYZI& point : *decoded)
    EXPECT_EQ(point.x, 0.25f * (point.intensity - 4.0f) + 0.125f);
}

TEST(IntensityCompression, VoxelsDoNotMoveWithTheCloud)
{
  // The grid is the world's: further points must not shift where a voxel lies.
  const double resolution = 0.04;
  Cloud::Ptr cloud(new Cloud);
  cloud->push_back(pcl::PointXYZI(0.1f, 0.2f, 0.3f, 9.0f));
  const auto alone = roundTrip<pcl::PointXYZI>(resolution, cloud);
  cloud->push_back(pcl::PointXYZI(-17.777f, 33.21f, 2.0f, 9.0f));
  const auto in_company = roundTrip<pcl::PointXYZI>(resolution, cloud);
  ASSERT_EQ(alone->size(), 1u);
  ASSERT_EQ(in_company->size(), 2u);
  EXPECT_TRUE(
      std::any_of(in_company->begin(), in_company->end(), [&](const auto& point) {
        return point.getVector3fMap() == alone->front().getVector3fMap();
      }));
}

TEST(IntensityCompression, PointsThatAreNotFiniteAreCountedAndLeftOut)
{
  auto cloud = randomCloud<pcl::PointXYZI>(4, 100);
  cloud->push_back(pcl::PointXYZI(not_a_number, 0.0f, 0.0f, 1.0f));
  cloud->push_back(pcl::PointXYZI(0.0f, infinity, 0.0f, 1.0f));
  cloud->push_back(pcl::PointXYZI(0.0f, 0.0f, -infinity, 1.0f));
  cloud->push_back(pcl::PointXYZI(3e38f, 0.0f, 0.0f, 1.0f));
  cloud->is_dense = false;
  OctreePointCloudIntensityCompression<pcl::PointXYZI> encoder(settingsWith(0.04));
  const auto decoded = roundTrip<decltype(encoder), pcl::PointXYZI>(encoder, cloud);
  cloud->resize(100);
  expectVoxelCentres(*decoded, naiveVoxels(*cloud, 0.04), 0.04);
  const auto& statistics = encoder.getStatistics().voxelization;
  EXPECT_EQ(statistics.points, 104u);
  EXPECT_EQ(statistics.points_used, 100u);
  EXPECT_EQ(statistics.points_not_finite, 3u);
  EXPECT_EQ(statistics.points_outside_grid, 1u);
}

TEST(IntensityCompression, OnlyPointsInTheBoundingBoxAreEncoded)
{
  IntensityCompressionSettings settings = settingsWith(0.04);
  settings.bounding_box = BoundingBox{{-0.25, -0.3, -0.2}, {0.3, 0.25, 0.4}};
  const auto cloud = randomCloud<pcl::PointXYZI>(5, 2000);
  OctreePointCloudIntensityCompression<pcl::PointXYZI> encoder(settings);
  const auto decoded = roundTrip<decltype(encoder), pcl::PointXYZI>(encoder, cloud);
  Cloud inside;
  for (const pcl::PointXYZI& point : *cloud)
    if (point.x >= -0.25 && point.x <= 0.3 && point.y >= -0.3 && point.y <= 0.25 &&
        point.z >= -0.2 && point.z <= 0.4)
      inside.push_back(point);
  expectVoxelCentres(*decoded, naiveVoxels(inside, 0.04), 0.04);
  const auto& statistics = encoder.getStatistics().voxelization;
  EXPECT_EQ(statistics.points_used, inside.size());
  EXPECT_EQ(statistics.points_outside_box, 2000u - inside.size());
}

template <typename PointT>
class PointTypes : public ::testing::Test {};

using TestedPointTypes = ::testing::Types<pcl::PointXYZ,
                                          pcl::PointXYZI,
                                          pcl::PointXYZL,
                                          pcl::PointXYZRGB,
                                          pcl::PointXYZRGBA,
                                          pcl::PointXYZRGBNormal,
                                          pcl::PointXYZINormal,
                                          pcl::PointNormal>;
TYPED_TEST_SUITE(PointTypes, TestedPointTypes);

TYPED_TEST(PointTypes, AllGoThroughTheSameVoxels)
{
  const auto cloud = randomCloud<TypeParam>(14, 2000, {1.0, -2.0, 3.0});
  const auto decoded = roundTrip<TypeParam>(0.05, cloud);
  expectVoxelCentres(*decoded, naiveVoxels(*cloud, 0.05), 0.05);
}

TYPED_TEST(PointTypes, FieldsThatAreNotCarriedHaveTheirDefault)
{
  using Compression = OctreePointCloudIntensityCompression<TypeParam>;
  auto cloud = randomCloud<TypeParam>(15, 100);
  // Neither what was encoded nor what lay in the output may shine through.
  const auto paint = [](pcl::PointCloud<TypeParam>& canvas) {
    for (TypeParam& point : canvas) {
      if constexpr (pcl::traits::has_color<TypeParam>::value) {
        point.r = 200;
        point.g = 100;
        point.b = 50;
        point.a = 7;
      }
      if constexpr (pcl::traits::has_normal<TypeParam>::value)
        point.normal_x = point.curvature = 0.75f;
      if constexpr (pcl::traits::has_label<TypeParam>::value)
        point.label = 77;
    }
  };
  paint(*cloud);
  Compression encoder(settingsWith(0.05));
  std::stringstream stream;
  ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  typename pcl::PointCloud<TypeParam>::Ptr decoded(
      new pcl::PointCloud<TypeParam>(5000, 1));
  paint(*decoded);
  ASSERT_TRUE(encoder.decodePointCloud(stream, decoded).ok());
  ASSERT_FALSE(decoded->empty());
  const TypeParam blank;
  for (const TypeParam& point : *decoded) {
    if constexpr (pcl::traits::has_color<TypeParam>::value) {
      EXPECT_EQ(point.rgba, blank.rgba);
    }
    if constexpr (pcl::traits::has_normal<TypeParam>::value) {
      EXPECT_EQ(point.normal_x, blank.normal_x);
      EXPECT_EQ(point.curvature, blank.curvature);
    }
    if constexpr (pcl::traits::has_label<TypeParam>::value) {
      EXPECT_EQ(point.label, blank.label);
    }
    EXPECT_EQ(point.data[3], blank.data[3]);
  }
}

TEST(HeaderPassthrough, OnCarriesStampAndFrame)
{
  using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  IntensityCompressionSettings settings = settingsWith(0.04);
  settings.carry_header = true;
  Compression encoder(settings);
  Compression decoder; // what arrives decides, not the receiver's settings
  std::stringstream stream;
  const std::vector<std::string> frames = {"cell", "cell", "map", "", "map"};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto cloud = randomCloud<pcl::PointXYZI>(20, 200);
    cloud->header.frame_id = frames[i];
    cloud->header.stamp = 18446744073709551000u + i;
    ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    EXPECT_EQ(decoded->header.frame_id, frames[i]);
    EXPECT_EQ(decoded->header.stamp, 18446744073709551000u + i);
  }
}

TEST(HeaderPassthrough, OffCostsNothingAndLeavesTheOutputsHeaderAlone)
{
  using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  Compression first(settingsWith(0.04));
  Compression second(settingsWith(0.04));
  for (unsigned int frame = 0; frame < 3; ++frame) {
    const auto plain = randomCloud<pcl::PointXYZI>(21 + frame, 200);
    const Cloud::Ptr stamped(new Cloud(*plain));
    stamped->header.frame_id = "cell";
    stamped->header.stamp = 123456789;
    std::stringstream plain_stream;
    std::stringstream stamped_stream;
    ASSERT_TRUE(first.encodePointCloud(plain, plain_stream).ok());
    ASSERT_TRUE(second.encodePointCloud(stamped, stamped_stream).ok());
    EXPECT_EQ(plain_stream.str(), stamped_stream.str());

    Cloud::Ptr decoded(new Cloud);
    decoded->header.frame_id = "mine";
    decoded->header.stamp = 5;
    ASSERT_TRUE(second.decodePointCloud(stamped_stream, decoded).ok());
    EXPECT_EQ(decoded->header.frame_id, "mine");
    EXPECT_EQ(decoded->header.stamp, 5u);
  }
}

TEST(HeaderPassthrough, OnCostsWhatItCarries)
{
  using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  IntensityCompressionSettings settings = settingsWith(0.04);
  Compression without(settings);
  settings.carry_header = true;
  Compression with(settings);
  const auto cloud = randomCloud<pcl::PointXYZI>(22, 200);
  cloud->header.frame_id = "cell";
  // I-frame with all of the header, then P-frame with the change of the stamp: 50 ms
  // are three bytes.
  for (const std::size_t cost : {8u + 1u + 4u, 3u}) {
    cloud->header.stamp += 50000;
    std::ostringstream plain;
    std::ostringstream stamped;
    ASSERT_TRUE(without.encodePointCloud(cloud, plain).ok());
    ASSERT_TRUE(with.encodePointCloud(cloud, stamped).ok());
    EXPECT_EQ(stamped.str().size(), plain.str().size() + cost);
  }
}

TEST(HeaderPassthrough, ALongFrameIdIsReportedAndTheStreamGoesOn)
{
  using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;
  IntensityCompressionSettings settings = settingsWith(0.04);
  settings.carry_header = true;
  Compression compression(settings);
  std::stringstream stream;
  const auto cloud = randomCloud<pcl::PointXYZI>(23, 50);
  cloud->header.frame_id = std::string(1024, 'a');
  ASSERT_TRUE(compression.encodePointCloud(cloud, stream).ok());
  cloud->header.frame_id.push_back('b');
  const CompressionStatus status = compression.encodePointCloud(cloud, stream);
  EXPECT_EQ(status.code(), CompressionCode::InvalidInput);
  EXPECT_NE(status.message().find("frame_id"), std::string::npos) << status.message();
  cloud->header.frame_id = "short";
  ASSERT_TRUE(compression.encodePointCloud(cloud, stream).ok());
  Cloud::Ptr decoded;
  ASSERT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  EXPECT_EQ(decoded->header.frame_id, std::string(1024, 'a'));
  ASSERT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  EXPECT_EQ(decoded->header.frame_id, "short");
}

} // namespace
