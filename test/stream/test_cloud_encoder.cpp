// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/cloud_encoder.h>

#include "support/point_views.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <new>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using pcl_ext::IntensityUnit;
using pcl_ext::io::test::viewOf;

TEST(SetIntensities, OfPointsBeyondTheRangeOfFloatsAreThoseOfTheirDepth)
{
  const pcl_ext::IntensityModel<pcl_ext::KinectV2, pcl_ext::LinearLaw> model(0.04);
  const std::vector<std::array<double, 3>> points{
      {0.0, 0.0, 5.0}, {1e300, 0.0, 5.0}, {0.0, 0.0, 1e300}, {0.0, 0.0, -1e300}};
  PointView view = viewOf(points);
  std::vector<float> intensities;
  const auto no_native_intensity = [](std::size_t) { return 0.0f; };
  EXPECT_EQ(setIntensities(model,
                           depthAxisOf(pcl_ext::WorldPose::Identity()),
                           no_native_intensity,
                           intensities,
                           view),
            1u);
  EXPECT_EQ(intensities[1], intensities[0]);
  EXPECT_EQ(intensities[2], 1.0f);
  EXPECT_EQ(intensities[3], 0.0f);
}

/** \brief Points along a line, up to a distance on both sides, and the frames of a
 * stream that coarsens. */
class WideClouds : public ::testing::Test {
protected:
  WideClouds()
  {
    settings_.resolution = 1e-4;
    settings_.coarsen_wide_clouds = true;
    settings_.i_frame_rate = 2;
  }

  /** \brief Encodes points from -half_width to half_width, and some further out. */
  CompressionStatus
  encode(float half_width,
         std::size_t far_points = 0,
         float far = 0.0f,
         IntensityUnit unit = IntensityUnit::None)
  {
    std::vector<std::array<float, 3>> points;
    for (int i = -50; i <= 50; ++i)
      points.push_back({static_cast<float>(i) / 50.0f * half_width, 0.0f, 1.0f});
    points.insert(points.end(), far_points, {far, 0.0f, 0.0f});
    const PointView view = viewOf(points);
    if (!encoder_)
      encoder_.emplace(settings_, unit);
    std::vector<std::uint8_t> bytes;
    return encoder_->encode(view, {}, bytes);
  }

  const VoxelizationStatistics&
  statistics() const
  {
    return encoder_->statistics().voxelization;
  }

  IntensityCompressionSettings settings_;
  std::optional<CloudEncoder> encoder_;
};

TEST_F(WideClouds, AreCoarsenedAsFarAsNeededUntilTheyAreNarrow)
{
  EXPECT_FALSE(encode(100.0f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
  // 1024 m are 10.24 million voxels of 0.1 mm; 2^21 * 8 are 16.8 million.
  const CompressionStatus status = encode(512.0f);
  EXPECT_TRUE(status.hasWarning());
  EXPECT_NE(status.message().find("edges of 0.0008 m were used"), std::string::npos)
      << status;
  EXPECT_EQ(statistics().resolution, 8e-4);
  EXPECT_EQ(encoder_->frame().grid.resolution, 8e-4);
  EXPECT_EQ(statistics().points_outside_grid, 0u);
  EXPECT_TRUE(encoder_->statistics().coding.is_i_frame);
  EXPECT_TRUE(encode(512.0f).hasWarning()); // a P-frame of the same grid
  EXPECT_FALSE(encoder_->statistics().coding.is_i_frame);
  EXPECT_FALSE(encode(100.0f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
}

TEST_F(WideClouds, FewFarPointsAreTakenInUpTo16Fold)
{
  EXPECT_TRUE(encode(100.0f, 3, 400.0f).hasWarning());
  EXPECT_EQ(statistics().resolution, 4e-4);
  EXPECT_EQ(statistics().points_outside_grid, 0u);
  encoder_.reset();
  EXPECT_TRUE(encode(100.0f, 3, 4000.0f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
  EXPECT_EQ(statistics().points_outside_grid, 3u);
  // In a frame that would be a P-frame, too.
  encode(100.0f, 3, 400.0f);
  EXPECT_EQ(statistics().points_outside_grid, 0u);
}

TEST_F(WideClouds, ManyPointsThatAreTooFarDoNotCostTheOthersTheirVoxels)
{
  settings_.i_frame_rate = 100;
  EXPECT_FALSE(encode(100.0f).hasWarning());
  EXPECT_TRUE(encode(100.0f, 10, 1e9f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
  EXPECT_EQ(statistics().points_outside_grid, 10u);
  EXPECT_TRUE(encode(1e9f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
  // Coarser voxels end with the first cloud that needs much finer ones.
  encode(1000.0f);
  EXPECT_EQ(statistics().resolution, 1.6e-3);
  EXPECT_FALSE(encode(100.0f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
}

TEST_F(WideClouds, KeepWhatTheyCanIfManyPointsAreTooFarForAnyGrid)
{
  for (int frame = 0; frame < 4; ++frame) {
    EXPECT_TRUE(encode(5000.0f).hasWarning());
    EXPECT_EQ(statistics().resolution, 1.6e-3);
    // 1,677 m of 5,000 on each side.
    EXPECT_EQ(statistics().points_used, 33u);
    EXPECT_EQ(encoder_->statistics().coding.is_i_frame, frame % 2 == 0);
  }
}

TEST_F(WideClouds, ThatKeepPointsAreCoarsenedForThese)
{
  settings_.keep_points = true;
  for (int frame = 0; frame < 4; ++frame) {
    EXPECT_TRUE(encode(5000.0f).hasWarning());
    // 10 km are 1.5 * 2^26 times 0.1 mm.
    EXPECT_EQ(statistics().resolution, 2e-4);
    EXPECT_EQ(statistics().points_used, 101u);
  }
  EXPECT_FALSE(encode(100.037f).hasWarning());
  EXPECT_EQ(statistics().resolution, 1e-4);
}

TEST_F(WideClouds, ThatKeepPointsFitVoxelsOfTheEdgeThatIsAdvised)
{
  settings_.coarsen_wide_clouds = false;
  settings_.keep_points = true;
  constexpr float width = 0.1234f;
  const std::string advice = encode(width, 1, 1e6f).message();
  const std::string words = "a resolution of ";
  const std::size_t number = advice.find(words);
  ASSERT_NE(number, std::string::npos) << advice;
  settings_.resolution = std::stod(advice.substr(number + words.size()));
  encoder_.reset();
  EXPECT_FALSE(encode(width, 1, 1e6f).hasWarning());
  EXPECT_EQ(statistics().points_used, 102u);
}

TEST_F(WideClouds, OnOneSideOfTheOriginTakeNoMoreThanTheirWidth)
{
  // 0 to 211 m.
  std::vector<std::array<float, 3>> points;
  for (int i = 0; i <= 211; ++i)
    points.push_back({static_cast<float>(i), 0.0f, 0.0f});
  const PointView view = viewOf(points);
  CloudEncoder encoder(settings_, IntensityUnit::None);
  VoxelFrame frame;
  EXPECT_TRUE(encoder.voxelize(view, pcl_ext::WorldPose::Identity(), frame).ok());
  EXPECT_EQ(frame.size(), points.size());
  EXPECT_EQ(frame.grid.resolution, 2e-4);
}

TEST_F(WideClouds, KeepTheirVoxelsUnlessToldAndForShares)
{
  encode(512.0f, 0, 0.0f, IntensityUnit::Share);
  EXPECT_EQ(statistics().resolution, 1e-4);
  EXPECT_GT(statistics().points_outside_grid, 0u);
  settings_.coarsen_wide_clouds = false;
  encoder_.reset();
  encode(512.0f);
  EXPECT_EQ(statistics().resolution, 1e-4);
  EXPECT_GT(statistics().points_outside_grid, 0u);
}

/** \brief What a sensor at the origin sees of a wall 3 m away, and of a plate at 1.5 m
 * that hides a part of it. */
std::vector<std::array<float, 3>>
wallOf(bool has_plate, unsigned int seed)
{
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0f, 0.01f);
  std::vector<std::array<float, 3>> points;
  for (int column = -60; column <= 60; ++column)
    for (int row = -60; row <= 60; ++row) {
      const float x = 0.006f * static_cast<float>(column);
      const float y = 0.006f * static_cast<float>(row);
      const bool is_plate = has_plate && std::abs(x) < 0.2f && std::abs(y) < 0.2f;
      const float depth = (is_plate ? 1.5f : 3.0f) + noise(random);
      points.push_back({depth * x, depth * y, depth});
    }
  return points;
}

TEST(CloudEncoder, ItsTemporalFilterSeesWhatIsBeyondTheBox)
{
  EncoderSettings settings;
  settings.resolution = 0.04;
  settings.temporal_filter = 64;
  settings.bounding_box = BoundingBox{{-10.0, -10.0, 0.0}, {10.0, 10.0, 2.0}};
  CloudEncoder encoder(settings, IntensityUnit::Points);
  std::size_t hidden = 0;
  std::size_t held = 0;
  const auto voxels = [&](bool has_plate, unsigned int seed) {
    auto points = wallOf(has_plate, seed);
    for (int i = 0; i < 200; ++i) // a shelf, so that the scene is the same
      for (int j = 0; j < 180; ++j)
        points.push_back({0.8f + 0.01f * static_cast<float>(i),
                          0.01f * static_cast<float>(j),
                          1.5f});
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(encoder.encode(viewOf(points), {}, bytes).ok());
    const FrameStatistics& statistics = encoder.statistics();
    EXPECT_EQ(statistics.coding.voxels,
              statistics.voxelization.voxels - statistics.voxels_hidden +
                  statistics.voxels_held);
    hidden += statistics.voxels_hidden;
    held += statistics.voxels_held;
    return encoder.frame().size();
  };
  const std::size_t of_shelf = voxels(false, 0);
  encoder = CloudEncoder(settings, IntensityUnit::Points);
  std::size_t with_plate = 0;
  for (unsigned int frame = 0; frame < 6; ++frame) {
    with_plate = voxels(true, frame);
    EXPECT_GT(with_plate, of_shelf + 100u);
  }
  // Without the points beyond the box all voxels of the plate would be held once.
  EXPECT_LT(voxels(false, 6), with_plate);
  EXPECT_EQ(voxels(false, 7), of_shelf);
  EXPECT_GT(hidden, 0u);
  EXPECT_GT(held, 0u);
}

TEST(CloudEncoder, WhatItsTemporalFilterHoldsStaysInTheGrid)
{
  // A plate far away is missing in a cloud that begins with an I-frame.
  EncoderSettings settings;
  settings.resolution = 0.04;
  settings.temporal_filter = 8;
  settings.i_frame_rate = 6;
  CloudEncoder encoder(settings, IntensityUnit::Points);
  std::vector<std::size_t> far_voxels;
  for (unsigned int frame = 0; frame < 8; ++frame) {
    auto points = wallOf(false, 1);
    for (int i = 0; i < 40 && frame != 6; ++i)
      for (int j = 0; j < 40; ++j)
        points.push_back(
            {300.0f, 0.05f * static_cast<float>(i), 0.05f * static_cast<float>(j)});
    std::vector<std::uint8_t> bytes;
    EXPECT_TRUE(encoder.encode(viewOf(points), {}, bytes).ok());
    far_voxels.push_back(0);
    forEachVoxelCentre(encoder.frame(), [&](float x, float, float, float) {
      far_voxels.back() += x > 200.0f ? 1 : 0;
    });
  }
  EXPECT_GT(far_voxels[5], 100u);
  EXPECT_EQ(far_voxels[6], far_voxels[5]);
  EXPECT_EQ(far_voxels[7], far_voxels[5]);
}

template <typename ExceptionT>
class FailingBatches : public PointBatches {
public:
  explicit FailingBatches(ExceptionT failure) : failure_(std::move(failure)) {}

  std::size_t
  size() const override
  {
    return 1;
  }

  bool
  hasIntensities() const override
  {
    return false;
  }

  bool
  hasColours() const override
  {
    return false;
  }

  void
  restart() override
  {}

  bool
  next(PointView& /*points*/) override
  {
    throw failure_;
  }

private:
  ExceptionT failure_;
};

class BatchSource : public CloudSource {
public:
  explicit BatchSource(PointBatches& batches) : batches_(batches) {}

  std::optional<DepthLaw>
  takeStep(const EncoderSettings& /*settings*/,
           const std::optional<float>& /*min_log_odds*/) override
  {
    return std::nullopt;
  }

  CompressionStatus
  open(OpenedCloud& cloud) override
  {
    cloud.batches = &batches_;
    return {};
  }

private:
  PointBatches& batches_;
};

TEST(CloudEncoder, PassesOnWhatBatchesThrowButForMemory)
{
  const std::vector<std::array<float, 3>> points{{0.1f, 0.2f, 3.0f}};
  const PointView view = viewOf(points);
  CloudEncoder encoder(EncoderSettings(), IntensityUnit::None);
  std::vector<std::uint8_t> bytes;
  const auto expectIFrame = [&](bool is_i_frame) {
    ASSERT_TRUE(encoder.encode(view, {}, bytes).ok());
    EXPECT_EQ(encoder.statistics().coding.is_i_frame, is_i_frame);
  };
  expectIFrame(true);
  expectIFrame(false);
  FailingBatches unreadable(std::runtime_error("the file is gone"));
  BatchSource source(unreadable);
  EXPECT_THROW(encoder.encode(source, {}, bytes), std::runtime_error);
  EXPECT_TRUE(bytes.empty());
  EXPECT_EQ(encoder.frame().size(), 0u);
  expectIFrame(true);
  expectIFrame(false);
  FailingBatches too_large{std::bad_alloc()};
  BatchSource other(too_large);
  EXPECT_EQ(encoder.encode(other, {}, bytes).code(), CompressionCode::OutOfMemory);
  expectIFrame(true);
}

TEST(CloudEncoder, ViewsWithoutCoordinatesOrStridesAreRefused)
{
  const std::vector<double> coordinates(9);
  CloudEncoder encoder(EncoderSettings(), IntensityUnit::None);
  VoxelFrame frame;
  PointView view;
  view.count = 3;
  const auto expectRefused = [&](const char* name) {
    frame.keys.assign(1, 0);
    const auto status = encoder.voxelize(view, pcl_ext::WorldPose::Identity(), frame);
    EXPECT_EQ(status.code(), CompressionCode::InvalidInput);
    EXPECT_NE(status.message().find(name), std::string::npos) << status;
    EXPECT_EQ(frame.size(), 0u);
  };
  expectRefused("coordinates is null");
  view.double_coordinates = coordinates.data();
  for (const std::size_t stride : {0, 3, 12, 23, 28}) {
    view.coordinate_stride = stride;
    expectRefused("coordinate_stride is ");
  }
  view.coordinate_stride = 24;
  EXPECT_TRUE(encoder.voxelize(view, pcl_ext::WorldPose::Identity(), frame).ok());
}

TEST(CloudEncoder, FramesHaveADepthModelInVersion1Only)
{
  const std::vector<std::array<float, 3>> point{{0.1f, 0.2f, 3.0f}};
  for (const StreamFormat format : {StreamFormat::Version1, StreamFormat::Published}) {
    EncoderSettings settings;
    settings.format = format;
    CloudEncoder encoder(settings, IntensityUnit::Share, DepthLaw{2, 10.0, 255.0});
    VoxelFrame frame;
    EXPECT_TRUE(
        encoder.voxelize(viewOf(point), pcl_ext::WorldPose::Identity(), frame).ok());
    EXPECT_EQ(frame.depth_model.has_value(), format == StreamFormat::Version1);
  }
}

} // namespace
