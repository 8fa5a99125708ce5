// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/organised_clouds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

enum class MixedKind { Image, MissingImage, Lidar, Scattered, Wide, Empty };
constexpr std::uint64_t kind_count = 6;

struct MixedCloud {
  OrganisedCloud points{0, 0, {}};
  std::vector<std::uint16_t> rings;

  PointView
  view() const
  {
    PointView view = viewOf(points);
    if (!rings.empty())
      view.fields = {{{"ring", FieldType::UInt16}, rings.data(), sizeof(rings[0])}};
    return view;
  }
};

MixedCloud
mixedCloud(MixedKind kind, std::mt19937_64& random)
{
  MixedCloud cloud;
  std::vector<float>& coordinates = cloud.points.coordinates;
  if (kind == MixedKind::Image || kind == MixedKind::MissingImage)
    cloud.points = cameraCloud(WorldPose::Identity(), random());
  if (kind == MixedKind::MissingImage)
    std::fill(coordinates.begin(), coordinates.end(), NAN);
  if (kind == MixedKind::Lidar) {
    const OrganisedCloud image = lidarCloud(WorldPose::Identity(), random());
    for (std::size_t i = 0; i < image.coordinates.size(); ++i)
      if (std::isfinite(image.coordinates[i])) {
        coordinates.push_back(image.coordinates[i]);
        if (i % 3 == 0)
          cloud.rings.push_back(static_cast<std::uint16_t>(i / 3 / image.width));
      }
  }
  if (kind == MixedKind::Scattered || kind == MixedKind::Wide) {
    const double extent = kind == MixedKind::Wide ? 2000.0 : 1.0;
    for (std::size_t i = 0; i < 1200; ++i)
      coordinates.push_back(uniform(random, -extent, extent));
    for (std::size_t i = 0; i < 400; ++i)
      cloud.rings.push_back(static_cast<std::uint16_t>(below(random, 4)));
  }
  return cloud;
}

class MixedClouds : public ::testing::TestWithParam<std::tuple<std::uint64_t, bool>> {};

TEST_P(MixedClouds, DecodeAndLoseNoPoints)
{
  const bool keeps_order = std::get<1>(GetParam());
  std::mt19937_64 random(std::get<0>(GetParam()));
  EncoderSettings settings = fineSettings();
  settings.keep_order = keeps_order;
  settings.i_frame_rate = 30;
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (std::size_t frame = 0; frame < 60; ++frame) {
    const auto kind = static_cast<MixedKind>(below(random, kind_count));
    SCOPED_TRACE(testing::Message() << frame << ", kind " << static_cast<int>(kind));
    const MixedCloud cloud = mixedCloud(kind, random);
    const std::vector<float>& coordinates = cloud.points.coordinates;
    const auto finite = static_cast<std::size_t>(
        std::count_if(coordinates.begin(), coordinates.end(), [](float coordinate) {
          return std::isfinite(coordinate);
        }));
    Bytes bytes;
    const CompressionStatus status = encoder.encode(cloud.view(), {}, bytes);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(status.hasWarning(), kind == MixedKind::MissingImage) << status.message();
    EXPECT_EQ(encoder.statistics().voxelization.points_used, finite / 3);
    EXPECT_EQ(encoder.statistics().voxelization.points_outside_grid, 0u);
    EXPECT_EQ(encoder.statistics().voxelization.resolution, settings.resolution);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    if (!keeps_order)
      continue;
    const bool is_image = cloud.points.width > 0;
    EXPECT_EQ(back.cloudWidth(),
              is_image ? cloud.points.width : coordinates.size() / 3);
    EXPECT_EQ(back.cloudHeight(), is_image ? cloud.points.height : 1u);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds,
                         MixedClouds,
                         ::testing::Combine(::testing::Values(1, 2, 3),
                                            ::testing::Bool()));

} // namespace
