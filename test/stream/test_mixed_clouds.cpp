// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/point_views.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

struct Cloud {
  std::vector<std::array<float, 3>> points;
  std::vector<std::uint16_t> rings;
  ImageSize image{};
};

enum class Kind { Image, MissingImage, Lidar, Scattered, Wide, Empty };
constexpr std::uint64_t kind_count = 6;

Cloud
image(std::mt19937_64& random, bool has_points)
{
  Cloud cloud;
  cloud.image = {40, 30};
  for (int row = 0; row < 30; ++row)
    for (int column = 0; column < 40; ++column) {
      const float z = !has_points || below(random, 9) == 0
                          ? NAN
                          : 2.0f + 0.3f * std::sin(0.1f * static_cast<float>(column));
      cloud.points.push_back({static_cast<float>(column - 20) * 0.004f * z,
                              static_cast<float>(row - 15) * 0.004f * z,
                              z});
    }
  return cloud;
}

Cloud
lidar()
{
  Cloud cloud;
  for (int column = 0; column < 90; ++column)
    for (int ring = 0; ring < 8; ++ring) {
      const double angle = -2.0 * M_PI * column / 90;
      const double elevation = 0.03 * ring - 0.1;
      cloud.points.push_back(
          {static_cast<float>(4.0 * std::cos(elevation) * std::cos(angle)),
           static_cast<float>(4.0 * std::cos(elevation) * std::sin(angle)),
           static_cast<float>(4.0 * std::sin(elevation))});
      cloud.rings.push_back(static_cast<std::uint16_t>(ring));
    }
  return cloud;
}

Cloud
scattered(std::mt19937_64& random, float extent)
{
  Cloud cloud;
  for (std::size_t i = 0; i < 400; ++i) {
    cloud.points.push_back({uniform(random, -extent, extent),
                            uniform(random, -extent, extent),
                            uniform(random, -extent, extent)});
    cloud.rings.push_back(static_cast<std::uint16_t>(below(random, 4)));
  }
  return cloud;
}

Cloud
cloudOf(Kind kind, std::mt19937_64& random)
{
  switch (kind) {
  case Kind::Image:
    return image(random, true);
  case Kind::MissingImage:
    return image(random, false);
  case Kind::Lidar:
    return lidar();
  case Kind::Scattered:
    return scattered(random, 1.0f);
  case Kind::Wide:
    return scattered(random, 2000.0f);
  default:
    return {};
  }
}

PointView
viewOf(const Cloud& cloud)
{
  PointView view;
  view.count = cloud.points.size();
  view.coordinates = cloud.points.empty() ? nullptr : cloud.points.front().data();
  view.coordinate_stride = sizeof(cloud.points.front());
  view.image = cloud.image;
  if (cloud.rings.empty())
    return view;
  FieldView ring;
  ring.description.name = "ring";
  ring.description.type = FieldType::UInt16;
  ring.first = cloud.rings.data();
  ring.stride = sizeof(std::uint16_t);
  view.fields.push_back(ring);
  return view;
}

class MixedClouds : public ::testing::TestWithParam<std::tuple<std::uint64_t, bool>> {};

TEST_P(MixedClouds, DecodeAndLoseNoPoints)
{
  const bool keeps_order = std::get<1>(GetParam());
  std::mt19937_64 random(std::get<0>(GetParam()));
  EncoderSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  settings.keep_order = keeps_order;
  settings.i_frame_rate = 30;
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (std::size_t frame = 0; frame < 60; ++frame) {
    const auto kind = static_cast<Kind>(below(random, kind_count));
    SCOPED_TRACE(testing::Message() << frame << ", kind " << static_cast<int>(kind));
    const Cloud cloud = cloudOf(kind, random);
    std::size_t finite = 0;
    for (const auto& point : cloud.points)
      finite += std::isfinite(point[2]) ? 1 : 0;
    Bytes bytes;
    const CompressionStatus status = encoder.encode(viewOf(cloud), {}, bytes);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(status.hasWarning(), kind == Kind::MissingImage) << status.message();
    EXPECT_EQ(encoder.statistics().voxelization.points_used, finite);
    EXPECT_EQ(encoder.statistics().voxelization.points_outside_grid, 0u);
    EXPECT_EQ(encoder.statistics().voxelization.resolution, settings.resolution);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    if (!keeps_order)
      continue;
    EXPECT_EQ(back.cloudWidth(),
              cloud.image.width > 0 ? cloud.image.width : cloud.points.size());
    EXPECT_EQ(back.cloudHeight(), cloud.image.width > 0 ? cloud.image.height : 1u);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds,
                         MixedClouds,
                         ::testing::Combine(::testing::Values(1, 2, 3, 4, 5, 6),
                                            ::testing::Bool()));

} // namespace
