/** \file
 * \brief A resolution that is set while a stream runs, and intensity fields of whole
 * numbers.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "support/cloud_streams.h"

#include <pcl/register_point_struct.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <sstream>
#include <vector>

/** \brief A point as many lidar drivers have it. */
struct PointWithByteIntensity {
  PCL_ADD_POINT4D;
  std::uint8_t intensity;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
} EIGEN_ALIGN16;

POINT_CLOUD_REGISTER_POINT_STRUCT(PointWithByteIntensity,
                                  (float, x, x)(float, y, y)(float, z, z)(std::uint8_t,
                                                                          intensity,
                                                                          intensity))

namespace {

using pcl_ext::IntensityModel;
using pcl_ext::KinectV2;
using pcl_ext::LinearLaw;
using pcl_ext::QuadraticLaw;
using pcl_ext::RuntimeSensor;
using pcl_ext::io::CompressionCode;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::OctreePointCloudIntensityCompression;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;

Cloud::Ptr
pointsAtOneMetre()
{
  const Cloud::Ptr cloud(new Cloud);
  cloud->emplace_back(0.01f, 0.01f, 1.0f, 0.0f);
  return cloud;
}

template <typename CompressionT>
float
decodedIntensity(CompressionT& compression)
{
  std::stringstream stream;
  EXPECT_TRUE(compression.encodePointCloud(pointsAtOneMetre(), stream).ok());
  Cloud::Ptr decoded(new Cloud);
  EXPECT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  EXPECT_EQ(decoded->size(), 1u);
  return decoded->front().intensity;
}

TEST(SetResolution, TheModelFollows)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.04;
  settings.intensity_bits = 16;
  OctreePointCloudIntensityCompression<pcl::PointXYZI,
                                       IntensityModel<KinectV2, QuadraticLaw>>
      compression(settings);
  const float at_4cm = decodedIntensity(compression);
  compression.setResolution(0.02);
  EXPECT_EQ(compression.getIntensityModel().resolution(), 0.02);
  EXPECT_TRUE(compression.getSettings().resolution == 0.02);
  // A quarter of the face, so four times the share.
  EXPECT_NEAR(decodedIntensity(compression), 4.0f * at_4cm, 0.02f);
}

TEST(SetResolution, TheSensorOfTheModelStays)
{
  using Model = IntensityModel<RuntimeSensor, LinearLaw>;
  IntensityCompressionSettings settings;
  settings.resolution = 0.04;
  OctreePointCloudIntensityCompression<pcl::PointXYZI, Model> compression(
      settings, Model(0.04, RuntimeSensor(90.0, 90.0, 100, 100)));
  compression.setResolution(0.1);
  EXPECT_EQ(compression.getIntensityModel().sensor().columns, 100u);
  EXPECT_NEAR(compression.getIntensityModel().cutOffDepth(), 5.0, 1e-9);
}

TEST(SetResolution, TheNextFrameIsAnIFrameAndTheStreamGoesOn)
{
  OctreePointCloudIntensityCompression<pcl::PointXYZI> encoder;
  OctreePointCloudIntensityCompression<pcl::PointXYZI> decoder;
  std::vector<bool> is_i_frame;
  for (const double resolution : {0.0, 0.0, 0.2, 0.0, 0.05}) {
    if (resolution > 0.0)
      encoder.setResolution(resolution);
    std::stringstream stream;
    ASSERT_TRUE(encoder.encodePointCloud(pointsAtOneMetre(), stream).ok());
    is_i_frame.push_back(encoder.getStatistics().coding.is_i_frame);
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    ASSERT_EQ(decoded->size(), 1u);
  }
  EXPECT_EQ(is_i_frame, (std::vector<bool>{true, false, true, false, true}));
}

TEST(SetResolution, ABadOneIsSaidByTheNextCallAndCanBeMended)
{
  IntensityCompressionSettings settings;
  settings.retain_octree = true;
  OctreePointCloudIntensityCompression<pcl::PointXYZI> compression(settings);
  decodedIntensity(compression);
  compression.setResolution(-1.0);
  std::stringstream stream;
  EXPECT_EQ(
      static_cast<int>(compression.encodePointCloud(pointsAtOneMetre(), stream).code()),
      static_cast<int>(CompressionCode::InvalidSettings));
  compression.setResolution(0.5);
  decodedIntensity(compression);
}

TEST(WholeNumberFields, AreRoundedAndHeldAtTheirEnds)
{
  const Cloud::Ptr cloud(new Cloud);
  const std::vector<float> intensities{-5.0f, 0.4f, 99.6f, 100.7f, 254.6f, 300.0f};
  for (std::size_t i = 0; i < intensities.size(); ++i)
    cloud->emplace_back(static_cast<float>(i) + 0.5f, 0.5f, 0.5f, intensities[i]);
  IntensityCompressionSettings settings;
  settings.resolution = 1.0;
  OctreePointCloudIntensityCompression<pcl::PointXYZI> encoder(settings);
  std::stringstream stream;
  ASSERT_TRUE(encoder.encodePointCloud(cloud, stream).ok());
  OctreePointCloudIntensityCompression<PointWithByteIntensity> decoder;
  pcl::PointCloud<PointWithByteIntensity>::Ptr decoded;
  ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
  ASSERT_EQ(decoded->size(), intensities.size());
  const std::vector<int> expected{0, 0, 100, 101, 255, 255};
  for (const PointWithByteIntensity& point : *decoded)
    EXPECT_EQ(point.intensity, expected[static_cast<std::size_t>(point.x)]) << point.x;
}

TEST(WholeNumberFields, AreTakenAsTheyAre)
{
  pcl::PointCloud<PointWithByteIntensity>::Ptr cloud(
      new pcl::PointCloud<PointWithByteIntensity>);
  for (int i = 0; i < 256; ++i) {
    PointWithByteIntensity point;
    point.x = static_cast<float>(i) + 0.5f;
    point.y = 0.5f;
    point.z = 0.5f;
    point.intensity = static_cast<std::uint8_t>(i);
    cloud->push_back(point);
  }
  IntensityCompressionSettings settings;
  settings.resolution = 1.0;
  OctreePointCloudIntensityCompression<PointWithByteIntensity> compression(settings);
  std::stringstream stream;
  ASSERT_TRUE(compression.encodePointCloud(cloud, stream).ok());
  pcl::PointCloud<PointWithByteIntensity>::Ptr decoded;
  ASSERT_TRUE(compression.decodePointCloud(stream, decoded).ok());
  ASSERT_EQ(decoded->size(), 256u);
  for (const PointWithByteIntensity& point : *decoded)
    EXPECT_EQ(point.intensity, static_cast<int>(point.x));
}

} // namespace
