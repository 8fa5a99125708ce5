#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/intensity/sensor.h>

#include "support/cloud_streams.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::test;
using pcl_ext::CountIntensity;
using pcl_ext::IntensityModel;
using pcl_ext::KinectV2;
using pcl_ext::NativeIntensity;
using pcl_ext::QuadraticLaw;
using pcl_ext::io::Aggregation;
using pcl_ext::io::compandedEdge;
using pcl_ext::io::IntensityCompressionSettings;
using pcl_ext::io::IntensityCurve;
using pcl_ext::io::IntensityScale;
using pcl_ext::io::OctreePointCloudIntensityCompression;
using pcl_ext::io::VoxelFrame;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double resolution = 0.04;

/** \brief The numbers that a symbol stands for, as an interval of intensities. */
struct SymbolInterval {
  SymbolInterval(const IntensityScale& scale, std::uint32_t symbol)
  {
    std::uint32_t first = symbol;
    std::uint32_t end = symbol + 1;
    if (scale.companded_range != 0) {
      first = compandedEdge(scale.bits, scale.companded_range, symbol);
      end = compandedEdge(scale.bits, scale.companded_range, symbol + 1);
    }
    const auto offset = static_cast<double>(scale.offset);
    const auto step = static_cast<double>(scale.step);
    // What leaves the scale at an end is there; the float depth takes its part.
    low = symbol == 0 ? -1e30 : offset + step * (first - 0.501) - 1e-3;
    high = symbol == scale.maxSymbol() ? 1e30 : offset + step * (end - 0.499) + 1e-3;
  }

  double low;
  double high;
};

/** \brief Sends clouds through the class, and expects each voxel to hold a symbol of its
 * intensity, and each decoded point that symbol's intensity. */
template <typename ModelT, typename IntensityOfVoxel>
void
expectRoundTrips(const IntensityCompressionSettings& settings,
                 const std::vector<Cloud::Ptr>& clouds,
                 const std::vector<NaiveVoxels>& voxels,
                 IntensityOfVoxel intensity_of)
{
  OctreePointCloudIntensityCompression<pcl::PointXYZI, ModelT> encoder(settings);
  OctreePointCloudIntensityCompression<pcl::PointXYZI> decoder;
  std::stringstream stream;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    ASSERT_TRUE(encoder.encodePointCloud(clouds[i], stream).ok());
    Cloud::Ptr decoded;
    const auto status = decoder.decodePointCloud(stream, decoded);
    ASSERT_TRUE(status.ok()) << status.message();
    const VoxelFrame& frame = decoder.getVoxelFrame();
    ASSERT_EQ(frame.intensity_scale, encoder.getVoxelFrame().intensity_scale);
    ASSERT_EQ(frame.intensities, encoder.getVoxelFrame().intensities);
    ASSERT_EQ(decoded->size(), voxels[i].size());
    for (std::size_t point = 0; point < decoded->size(); ++point) {
      const std::uint16_t symbol = frame.intensities[point];
      ASSERT_EQ((*decoded)[point].intensity, frame.intensity_scale.value(symbol));
      const auto voxel = voxels[i].find(voxelOf((*decoded)[point], resolution));
      ASSERT_NE(voxel, voxels[i].end());
      const SymbolInterval interval(frame.intensity_scale, symbol);
      ASSERT_GE(intensity_of(voxel->second), interval.low);
      ASSERT_LE(intensity_of(voxel->second), interval.high);
    }
  }
}

/** \brief Three clouds, so that frames follow each other, with up to 300 points in a
 * voxel. */
std::vector<Cloud::Ptr>
someClouds()
{
  std::vector<Cloud::Ptr> clouds;
  for (const unsigned int seed : {1u, 2u, 3u}) {
    clouds.push_back(randomCloud<pcl::PointXYZI>(seed, 2000, {0.0, 0.0, 2.0}, 0.2));
    for (int points = 3; points <= 300; points += 11)
      for (int i = 0; i < points; ++i)
        clouds.back()->push_back(
            {0.5f + 0.04f * static_cast<float>(points / 11), 0.42f, 2.02f, 7.0f});
  }
  return clouds;
}

/** \brief Settings with each number of bits, 0 among them, on both scales. */
template <typename Try>
void
forAllScales(Try try_settings)
{
  for (const auto curve : {IntensityCurve::Linear, IntensityCurve::Companded})
    for (unsigned int bits = 0; bits <= 16; ++bits) {
      SCOPED_TRACE(std::to_string(bits) + " bits" +
                   (curve == IntensityCurve::Companded ? ", companded" : ""));
      IntensityCompressionSettings settings = settingsWith(resolution);
      settings.intensity_bits = bits;
      settings.intensity_curve = curve;
      try_settings(settings);
    }
}

TEST(IntensityScales, CountsRoundTrip)
{
  const std::vector<Cloud::Ptr> clouds = someClouds();
  std::vector<NaiveVoxels> voxels;
  for (const Cloud::Ptr& cloud : clouds)
    voxels.push_back(naiveVoxels(*cloud, resolution));
  forAllScales([&](const IntensityCompressionSettings& settings) {
    expectRoundTrips<CountIntensity>(
        settings, clouds, voxels, [](const NaiveVoxel& voxel) {
          return static_cast<double>(voxel.count);
        });
  });
}

TEST(IntensityScales, SharesRoundTrip)
{
  const std::vector<Cloud::Ptr> clouds = someClouds();
  const double cut_off = QuadraticIntensity(resolution).cutOffDepth();
  std::vector<NaiveVoxels> voxels;
  for (const Cloud::Ptr& cloud : clouds)
    voxels.push_back(
        naiveVoxels(*cloud, resolution, [cut_off](const pcl::PointXYZI& point) {
          return std::pow(std::min(1.0, static_cast<double>(point.z) / cut_off), 2);
        }));
  forAllScales([&](const IntensityCompressionSettings& settings) {
    expectRoundTrips<QuadraticIntensity>(
        settings, clouds, voxels, [](const NaiveVoxel& voxel) {
          return 255.0 * voxel.sum;
        });
  });
}

TEST(IntensityScales, NativeIntensitiesRoundTrip)
{
  std::vector<Cloud::Ptr> clouds = someClouds();
  for (pcl::PointXYZI& point : *clouds[1])
    point.intensity *= 200.0f; // 16 bits
  for (pcl::PointXYZI& point : *clouds[2])
    point.intensity = 0.5f - point.intensity; // fractions of both signs
  std::vector<NaiveVoxels> voxels;
  for (const Cloud::Ptr& cloud : clouds)
    voxels.push_back(naiveVoxels(*cloud, resolution));
  forAllScales([&](IntensityCompressionSettings settings) {
    expectRoundTrips<NativeIntensity>(
        settings, clouds, voxels, [](const NaiveVoxel& voxel) { return voxel.mean(); });
    settings.aggregation = Aggregation::Sum;
    expectRoundTrips<NativeIntensity>(
        settings, clouds, voxels, [](const NaiveVoxel& voxel) { return voxel.sum; });
  });
}

} // namespace
