// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/point_views.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;

/** \brief More than 2 * 32768 points, as fewer are for one thread. */
struct LargeCloud {
  std::vector<std::array<float, 3>> points;
  std::vector<std::uint16_t> rings; // none: an image
  std::vector<double> times;
  ImageSize image{1, 1};
};

/** \brief A wall that a camera sees; some points are missing, some beside their rays. */
LargeCloud
cameraCloud(std::mt19937& random)
{
  LargeCloud cloud;
  cloud.image = {320, 300};
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (std::uint32_t row = 0; row < cloud.image.height; ++row)
    for (std::uint32_t column = 0; column < cloud.image.width; ++column) {
      const double z =
          share(random) < 0.05 ? std::nan("") : 2.0 + 0.3 * std::sin(0.02 * column);
      const double beside = share(random) < 0.02 ? 0.05 : 0.0;
      cloud.points.push_back({static_cast<float>(z * (column - 160.0) / 300.0 + beside),
                              static_cast<float>(z * (row - 150.0) / 300.0),
                              static_cast<float>(z)});
    }
  return cloud;
}

/** \brief A room around a lidar that fires 64 lasers at each of 1,200 angles; some beams
 * are turned from those of their firing. */
LargeCloud
lidarCloud(std::mt19937& random)
{
  LargeCloud cloud;
  std::uniform_real_distribution<double> share(0.0, 1.0);
  constexpr double step = 2.0 * 3.14159265358979323846 / 36000.0;
  for (std::uint32_t column = 0; column < 1200; ++column)
    for (std::uint16_t ring = 0; ring < 64; ++ring) {
      const double turned = share(random) < 0.1 ? 7.0 : 0.0;
      const double angle = (30.0 * column + turned) * step;
      const double elevation = 0.01 * (ring - 32.0);
      const double range =
          std::round(250.0 * (6.0 + std::sin(5.0 * angle) + 0.01 * share(random))) /
          250.0;
      cloud.points.push_back(
          {static_cast<float>(range * std::cos(elevation) * std::cos(angle)),
           static_cast<float>(range * std::cos(elevation) * std::sin(angle)),
           static_cast<float>(range * std::sin(elevation))});
      cloud.rings.push_back(ring);
    }
  cloud.image = {static_cast<std::uint32_t>(cloud.points.size()), 1};
  return cloud;
}

template <typename T>
FieldView
fieldOf(const char* name, FieldType type, const std::vector<T>& values)
{
  return {{name, type}, values.data(), sizeof(T)};
}

/** \brief The frames of a stream, each of which decodes to as many points. */
std::vector<std::vector<std::uint8_t>>
framesOf(const std::vector<LargeCloud>& clouds, unsigned int threads)
{
  EncoderSettings settings;
  settings.resolution = 0.002;
  settings.keep_points = true;
  settings.keep_order = true;
  settings.i_frame_rate = 2;
  settings.threads = threads;
  settings.fields = {{"time", 0.0}};
  CloudEncoder encoder(settings, IntensityUnit::None, std::nullopt, std::nullopt);
  FrameDecoder decoder;
  std::vector<std::vector<std::uint8_t>> frames;
  for (const LargeCloud& cloud : clouds) {
    PointView points = io::test::viewOf(cloud.points, cloud.image);
    points.fields.push_back(fieldOf("time", FieldType::Float64, cloud.times));
    if (!cloud.rings.empty())
      points.fields.push_back(fieldOf("ring", FieldType::UInt16, cloud.rings));
    CloudInfo info;
    std::vector<std::uint8_t>& frame = frames.emplace_back();
    EXPECT_TRUE(encoder.encode(points, info, frame).ok());
    VoxelFrame decoded;
    EXPECT_TRUE(decoder.decode(frame.data(), frame.size(), decoded).ok());
    EXPECT_GT(decoded.points.indices.size(), 65536u);
  }
  return frames;
}

TEST(ScanThreads, GiveTheBytesOfOne)
{
  std::mt19937 random(7);
  for (const auto make : {cameraCloud, lidarCloud}) {
    std::vector<LargeCloud> clouds;
    for (unsigned int frame = 0; frame < 3; ++frame) {
      clouds.push_back(make(random));
      LargeCloud& cloud = clouds.back();
      for (std::size_t point = 0; point < cloud.points.size(); ++point)
        cloud.times.push_back(100.0 * frame + 1e-6 * static_cast<double>(point));
    }
    const auto expected = framesOf(clouds, 1);
    EXPECT_EQ(framesOf(clouds, 2), expected);
    EXPECT_EQ(framesOf(clouds, 7), expected);
  }
}

} // namespace
