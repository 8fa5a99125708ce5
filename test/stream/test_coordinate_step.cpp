// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>

#include "support/point_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace {

using namespace pcl_ext::io;
using pcl_ext::IntensityUnit;
using pcl_ext::io::test::viewOf;

/** \brief Points with coordinates that are multiples of a step, and the frames of a
 * stream that looks for steps. */
class CoordinateSteps : public ::testing::Test {
protected:
  CoordinateSteps()
  {
    settings_.resolution = 1e-4;
    settings_.use_coordinate_step = true;
    settings_.i_frame_rate = 4;
  }

  /** \brief Encodes points at multiples of a step, shifted.
   * \param[in] step metres; what a sensor's driver computes as a float
   * \param[in] shift metres
   */
  void
  encode(double step, double shift = 0.0)
  {
    points_.clear();
    for (int i = -300; i < 300; ++i)
      points_.push_back({static_cast<float>(shift + step * 71 * i),
                         static_cast<float>(shift + step * (i * i % 83)),
                         static_cast<float>(shift + step * (7 * i + 3))});
    points_.push_back({std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f});
    const PointView view = viewOf(points_);
    if (!encoder_)
      encoder_.emplace(settings_, IntensityUnit::None);
    std::vector<std::uint8_t> bytes;
    const CompressionStatus status = encoder_->encode(view, {}, bytes);
    EXPECT_TRUE(status.ok() && !status.hasWarning()) << status;
    points_.pop_back();
  }

  const VoxelFrame&
  frame() const
  {
    return encoder_->frame();
  }

  std::vector<std::array<float, 3>>
  centres() const
  {
    std::vector<std::array<float, 3>> centres;
    forEachVoxelCentre(frame(), [&](float x, float y, float z, float) {
      centres.push_back({x, y, z});
    });
    std::sort(centres.begin(), centres.end());
    return centres;
  }

  IntensityCompressionSettings settings_;
  std::optional<CloudEncoder> encoder_;
  std::vector<std::array<float, 3>> points_; // ascending
};

TEST_F(CoordinateSteps, AreTheVoxelsAndTheCoordinatesTheCentres)
{
  for (const double step : {0.01, 0.002, 0.001, 0.0005}) {
    encoder_.reset();
    encode(step);
    EXPECT_EQ(frame().grid.resolution, step);
    EXPECT_EQ(centres(), points_) << step;
  }
}

TEST_F(CoordinateSteps, EndWithOtherCoordinatesAndAreFoundAgainWithAnIFrame)
{
  const auto is_i_frame = [&] { return encoder_->statistics().coding.is_i_frame; };
  encode(0.001);
  encode(0.001);
  EXPECT_FALSE(is_i_frame());
  encode(0.001, 0.00004); // not to a quarter of the resolution
  EXPECT_EQ(frame().grid.resolution, 1e-4);
  EXPECT_TRUE(is_i_frame());
  encode(0.001);
  EXPECT_EQ(frame().grid.resolution, 1e-4);
  EXPECT_FALSE(is_i_frame());
  for (int i = 0; i < 4; ++i)
    encode(0.001);
  EXPECT_EQ(frame().grid.resolution, 0.001);
}

TEST_F(CoordinateSteps, AreNotUsedUnlessToldNorForShares)
{
  encoder_.emplace(settings_, IntensityUnit::Share);
  encode(0.001);
  EXPECT_EQ(frame().grid.resolution, 1e-4);
  EXPECT_EQ(frame().grid.origin, VoxelGrid().origin);
  settings_.use_coordinate_step = false;
  encoder_.reset();
  encode(0.001);
  EXPECT_EQ(frame().grid.resolution, 1e-4);
  // Nor are those of the resolution with an origin.
  settings_.resolution = 0.001;
  settings_.origin = {0.0, 0.0, 1.0};
  encoder_.reset();
  encode(0.001);
  EXPECT_EQ(frame().grid.origin, *settings_.origin);
}

TEST_F(CoordinateSteps, OfTheResolutionAreTheCentresWithoutBeingToldSo)
{
  settings_.use_coordinate_step = false;
  const auto is_i_frame = [&] { return encoder_->statistics().coding.is_i_frame; };
  for (const double step : {0.01, 0.001}) {
    settings_.resolution = step;
    encoder_.reset();
    encode(step);
    EXPECT_EQ(frame().grid.resolution, step);
    EXPECT_EQ(centres(), points_) << step;
    encode(step);
    EXPECT_EQ(centres(), points_) << step;
    EXPECT_FALSE(is_i_frame());
    encode(step, step / 10.0); // not to a sixteenth of the resolution
    EXPECT_EQ(frame().grid.origin, VoxelGrid().origin);
    EXPECT_TRUE(is_i_frame());
  }
}

TEST_F(CoordinateSteps, MayBeFarFromTheOrigin)
{
  // More than 2^20 multiples, which floats hold.
  settings_.resolution = 1.0 / 128.0;
  settings_.use_coordinate_step = false;
  encode(settings_.resolution, 100000.0);
  EXPECT_EQ(centres(), points_);
  const auto origin = frame().grid.origin;
  for (int i = 0; i < 6; ++i) { // with I-frames
    encode(settings_.resolution, 100000.0 + i);
    EXPECT_EQ(centres(), points_);
    EXPECT_EQ(frame().grid.origin, origin);
  }
  for (int i = 0; i < 5; ++i) // until an I-frame
    encode(settings_.resolution, -50000.0);
  EXPECT_EQ(centres(), points_);
  for (int i = 0; i < 5; ++i)
    encode(settings_.resolution, 0.0);
  EXPECT_EQ(centres(), points_);
}

TEST_F(CoordinateSteps, OfDoublesAreFound)
{
  const std::vector<std::array<double, 3>> points{{0.001, -2.5, 3.017},
                                                  {0.002, 1.25, -0.009}};
  CloudEncoder encoder(settings_, IntensityUnit::None);
  VoxelFrame voxels;
  EXPECT_TRUE(
      encoder.voxelize(viewOf(points), pcl_ext::WorldPose::Identity(), voxels).ok());
  EXPECT_EQ(voxels.grid.resolution, 0.001);
  EXPECT_EQ(voxels.size(), 2u);
}

} // namespace
