// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/impl/point_intensity.h>

#include "stream/frame_encoder.h"
#include "support/cloud_streams.h"
#include "support/text_parts.h"
#include "voxelizing/voxelizer.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::test;
using pcl_ext::IntensityModel;
using pcl_ext::QuadraticLaw;
using pcl_ext::RuntimeSensor;

using Cloud = pcl::PointCloud<pcl::PointXYZI>;
using Compression = OctreePointCloudIntensityCompression<pcl::PointXYZI>;

// ---------------------------------------------------------------- what reaches the
// codec

TEST(CodecSettings, BytesAreThoseOfVoxelizerAndFrameEncoder)
{
  using Settings = IntensityCompressionSettings;
  const std::vector<std::function<void(Settings&)>> changes = {
      [](Settings&) {},
      [](Settings& settings) { settings.i_frame_rate = 2; },
      [](Settings& settings) { settings.effort = Effort::Balanced; },
      [](Settings& settings) { settings.effort = Effort::Small; },
      [](Settings& settings) { settings.format = StreamFormat::Published; },
      [](Settings& settings) { settings.aggregation = Aggregation::Sum; },
      [](Settings& settings) { settings.intensity_bits = 5; },
      [](Settings& settings) { settings.intensity_range = 100.0f; },
      [](Settings& settings) { settings.intensity_curve = IntensityCurve::Companded; },
      [](Settings& settings) {
        settings.bounding_box = BoundingBox{{-0.25, -0.3, -0.2}, {0.3, 0.25, 0.4}};
      }};
  std::set<std::string> streams;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE(i);
    Settings settings = settingsWith(usual_resolution);
    changes[i](settings);
    Compression compression(settings);
    Voxelizer voxelizer(settings, pcl_ext::IntensityUnit::Native);
    FrameEncoder encoder(settings.format, settings.i_frame_rate, settings.effort);
    std::string stream;
    for (unsigned int frame = 0; frame < 3; ++frame) {
      // The same grid in each frame, for P-frames.
      const auto cloud = randomCloud<pcl::PointXYZI>(2, 500 - frame);
      VoxelFrame voxels;
      const VoxelizationStatistics statistics = voxelizer.voxelize(
          pcl_ext::pointViewWithIntensities(*cloud), encoder.isIFrameDue(), voxels);
      std::vector<std::uint8_t> bytes;
      ASSERT_TRUE(encoder.encode(voxels, std::nullopt, bytes).ok());
      const std::string encoded = encodeFrame(compression, cloud);
      EXPECT_EQ(encoded, std::string(bytes.begin(), bytes.end()));
      EXPECT_EQ(compression.voxelFrame().keys, voxels.keys);
      EXPECT_EQ(compression.statistics().voxelization.points_used,
                statistics.points_used);
      stream += encoded;
    }
    EXPECT_TRUE(streams.insert(stream).second) << "the setting has no effect";
  }
}

TEST(CodecSettings, DepthLaw)
{
  // Intensities that follow the quadratic law, as SensorPreprocessor makes them.
  const auto cloud = randomCloud<pcl::PointXYZI>(3, 2000, {0.0, 0.0, 3.0}, 1.0);
  for (pcl::PointXYZI& point : *cloud)
    point.intensity = 10.0f * point.z * point.z;
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.aggregation = Aggregation::Sum;
  settings.intensity_bits = 8;
  settings.intensity_range = 255.0f;
  settings.depth_law = DepthLaw{2, std::sqrt(25.5), 255.0};
  Compression compression(settings);
  roundTrip(compression, compression, cloud);
  ASSERT_TRUE(compression.voxelFrame().depth_model.has_value());
  EXPECT_EQ(compression.voxelFrame().depth_model->exponent, 2);
}

TEST(CodecSettings, DecoderLimits)
{
  Compression encoder(settingsWith(usual_resolution));
  const std::string large_frame =
      encodeFrame(encoder, randomCloud<pcl::PointXYZI>(11, 5000));
  encoder.requestIFrame();
  const std::string small_frame =
      encodeFrame(encoder, randomCloud<pcl::PointXYZI>(10, 100));
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.decoder_limits.max_voxels = 100;
  Compression decoder(settings);
  Cloud::Ptr decoded;
  expectCode(decodeBytes(decoder, large_frame, decoded),
             CompressionCode::LimitExceeded);
  EXPECT_TRUE(decodeBytes(decoder, small_frame, decoded).ok());
}

// ---------------------------------------------------------------- invalid settings

template <typename CompressionT>
void
expectEncodingToRefuse(double resolution)
{
  SCOPED_TRACE(resolution);
  IntensityCompressionSettings settings = settingsWith(resolution);
  settings.retain_octree = true;
  CompressionT compression(settings);
  const auto expect_refusal = [&](const CompressionStatus& status) {
    expectCode(status, CompressionCode::InvalidSettings);
    EXPECT_TRUE(hasPart(status.message(), "resolution"));
  };
  for (int round = 0; round < 2; ++round) {
    std::stringstream stream;
    expect_refusal(
        compression.encodePointCloud(randomCloud<pcl::PointXYZI>(12, 50), stream));
    EXPECT_TRUE(stream.str().empty());
    expect_refusal(compression.encodePointCloud(nullptr, stream));
    std::vector<std::uint8_t> bytes(1);
    expect_refusal(
        compression.encodePointCloud(randomCloud<pcl::PointXYZI>(12, 50), bytes));
    EXPECT_TRUE(bytes.empty());
    compression.requestIFrame();
  }
  EXPECT_EQ(compression.getLeafCount(), 0u);
  EXPECT_FALSE(compression.isVoxelOccupiedAtPoint(pcl::PointXYZI()));
  EXPECT_EQ(compression.getVoxelIntensityAtPoint(pcl::PointXYZI()), 0.0f);
  EXPECT_GT(compression.getResolution(), 0.0);
  EXPECT_EQ(compression.statistics().coding.bytes, 0u);
}

TEST(InvalidCompressionSettings, EncodingReportsThem)
{
  for (const double resolution : {0.0,
                                  -1.0,
                                  std::numeric_limits<double>::infinity(),
                                  std::numeric_limits<double>::quiet_NaN()}) {
    expectEncodingToRefuse<Compression>(resolution);
    expectEncodingToRefuse<Compression::SinglePointCloudCompressionLowMemory>(
        resolution);
  }
}

TEST(InvalidCompressionSettings, OnlyInvalidLimitsPreventDecoding)
{
  Compression encoder(settingsWith(usual_resolution));
  const std::string frame = encodeFrame(encoder, randomCloud<pcl::PointXYZI>(13, 50));
  IntensityCompressionSettings settings = settingsWith(-1.0);
  Cloud::Ptr decoded;
  Compression decoder(settings);
  expectCode(decodeBytes(decoder, frame, decoded), CompressionCode::Ok);
  settings.resolution = usual_resolution;
  settings.decoder_limits.max_points = 0;
  Compression without_limits(settings);
  const CompressionStatus status = decodeBytes(without_limits, frame, decoded);
  expectCode(status, CompressionCode::InvalidSettings);
  EXPECT_TRUE(hasPart(status.message(), "max_points"));
}

// ---------------------------------------------------------------- setResolution

Cloud::Ptr
pointsAtOneMetre()
{
  const Cloud::Ptr cloud(new Cloud);
  cloud->emplace_back(0.01f, 0.01f, 1.0f, 0.0f);
  return cloud;
}

TEST(SetResolution, TheModelFollows)
{
  IntensityCompressionSettings settings = settingsWith(usual_resolution);
  settings.intensity_bits = 16;
  using Model = IntensityModel<RuntimeSensor, QuadraticLaw>;
  OctreePointCloudIntensityCompression<pcl::PointXYZI, Model> compression(
      settings, Model(usual_resolution, RuntimeSensor(90.0, 90.0, 200, 200)));
  const auto intensity = [&] {
    return roundTrip(compression, pointsAtOneMetre())->at(0).intensity;
  };
  const float at_4cm = intensity();
  compression.setResolution(0.02);
  EXPECT_EQ(compression.intensityModel().resolution(), 0.02);
  EXPECT_TRUE(compression.settings().resolution == 0.02);
  // A quarter of the face, so four times the share.
  EXPECT_NEAR(intensity(), 4.0f * at_4cm, 0.02f);
  compression.setResolution(0.1);
  EXPECT_EQ(compression.intensityModel().sensor().columns, 200u); // its sensor stays
  EXPECT_NEAR(compression.intensityModel().cutOffDepth(), 10.0, 1e-9);
}

TEST(SetResolution, TheNextFrameIsAnIFrameAlsoAfterAnInvalidOne)
{
  IntensityCompressionSettings settings;
  settings.retain_octree = true;
  Compression encoder(settings);
  Compression decoder;
  std::string frame_types;
  for (const double new_resolution : {0.0, 0.0, 0.2, 0.0, -1.0, 0.05}) {
    if (new_resolution != 0.0)
      encoder.setResolution(new_resolution);
    std::stringstream stream;
    const CompressionStatus status =
        encoder.encodePointCloud(pointsAtOneMetre(), stream);
    if (new_resolution < 0.0) {
      expectCode(status, CompressionCode::InvalidSettings);
      continue;
    }
    Cloud::Ptr decoded;
    ASSERT_TRUE(decoder.decodePointCloud(stream, decoded).ok());
    frame_types += encoder.statistics().coding.is_i_frame ? 'I' : 'P';
    ASSERT_EQ(decoded->size(), 1u);
  }
  EXPECT_EQ(frame_types, "IPIPI");
}

} // namespace
