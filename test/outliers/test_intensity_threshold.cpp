// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "support/float_values.h"
#include "support/point_frames.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace {

using pcl_ext::removeVoxelsBelow;
using pcl_ext::io::IntensityScale;
using pcl_ext::io::isConsistent;
using pcl_ext::io::VoxelFrame;
using pcl_ext::io::test::expectSameFrame;
using pcl_ext::io::test::randomFrame;
using pcl_ext::test::infinity;

VoxelFrame
withScale(VoxelFrame frame, const IntensityScale& scale)
{
  frame.intensity_scale = scale;
  for (std::uint16_t& symbol : frame.intensities)
    symbol = static_cast<std::uint16_t>(symbol & scale.maxSymbol());
  return frame;
}

/** \brief One voxel after the other, by the value that it is decoded to. */
VoxelFrame
filteredNaively(const VoxelFrame& frame, float min_intensity)
{
  VoxelFrame filtered = frame;
  pcl_ext::io::test::clearVoxels(filtered);
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (frame.intensity_scale.value(frame.intensities[i]) >= min_intensity) {
      filtered.keys.push_back(frame.keys[i]);
      filtered.intensities.push_back(frame.intensities[i]);
      if (frame.colour_bits > 0)
        filtered.colours.push_back(frame.colours[i]);
    }
  return filtered;
}

void
expectFiltered(const VoxelFrame& frame, float min_intensity)
{
  SCOPED_TRACE("threshold " + std::to_string(min_intensity));
  const VoxelFrame expected = filteredNaively(frame, min_intensity);
  VoxelFrame filtered = frame;
  EXPECT_EQ(removeVoxelsBelow(filtered, min_intensity), frame.size() - expected.size());
  expectSameFrame(filtered, expected);
  EXPECT_TRUE(isConsistent(filtered));
}

/** \brief Scales of all kinds: steps that are no binary fraction, that are lost beside
 * the offset and that leave the floats; offsets on both sides of 0; companded ones. */
std::vector<IntensityScale>
scales()
{
  std::vector<IntensityScale> scales;
  for (const unsigned int bits : {1u, 3u, 8u, 16u})
    for (const float offset : {0.0f, 1.0f, -32.0f})
      for (const float step : {1.0f, 0.1f, 1e-30f, 1e34f}) {
        IntensityScale scale;
        scale.bits = bits;
        scale.offset = offset;
        scale.step = step;
        scales.push_back(scale);
      }
  for (const unsigned int bits : {2u, 4u, 8u}) {
    IntensityScale scale;
    scale.offset = 1.0f;
    scale.bits = bits;
    scale.companded_range = 1000;
    scales.push_back(scale);
  }
  return scales;
}

TEST(IntensityThreshold, AreBelowTheThresholdWhenDecoded)
{
  std::mt19937_64 random(1);
  VoxelFrame symbols = randomFrame(random, 6, 700, 16);
  pcl_ext::io::test::addColours(random, 5, symbols);
  for (const IntensityScale& scale : scales()) {
    SCOPED_TRACE(std::to_string(scale.bits) + " bits from " +
                 std::to_string(scale.offset) + " in steps of " +
                 std::to_string(scale.step));
    const VoxelFrame frame = withScale(symbols, scale);
    // At, just below and just above what symbols stand for.
    for (const std::uint32_t symbol :
         {0u, 1u, scale.maxSymbol() / 2, scale.maxSymbol() - 1, scale.maxSymbol()}) {
      const float value = scale.value(static_cast<std::uint16_t>(symbol));
      expectFiltered(frame, value);
      expectFiltered(frame, std::nextafter(value, infinity));
      expectFiltered(frame, std::nextafter(value, -infinity));
    }
  }
}

TEST(IntensityThreshold, ThresholdsOutsideTheScaleRemoveNothingOrAll)
{
  std::mt19937_64 random(2);
  for (const unsigned int bits : {8u, 16u}) {
    const VoxelFrame frame = randomFrame(random, 5, 200, bits);
    for (const float threshold : {0.0f, -1.0f, -infinity, 65536.0f, infinity}) {
      VoxelFrame filtered = frame;
      EXPECT_EQ(removeVoxelsBelow(filtered, threshold), threshold > 0.0f ? 200u : 0u);
      expectFiltered(frame, threshold);
    }
  }
  expectFiltered(pcl_ext::io::test::emptyFrame(4), 10.0f);
}

TEST(IntensityThreshold, FramesOfPointsGetVoxelsWhereAnyMayBeRemoved)
{
  std::mt19937_64 random(3);
  for (const std::uint32_t height : {1u, 32u}) {
    pcl_ext::io::test::PointContent content;
    content.height = height;
    const VoxelFrame frame = pcl_ext::io::test::frameOfPoints(random, content);
    VoxelFrame with_voxels = frame;
    pcl_ext::io::setVoxels(with_voxels);
    const std::size_t removed = removeVoxelsBelow(with_voxels, 100.0f);
    EXPECT_GT(removed, 0u);
    EXPECT_GT(with_voxels.size(), 0u);
    VoxelFrame filtered = frame;
    EXPECT_EQ(removeVoxelsBelow(filtered, 100.0f), removed);
    expectSameFrame(filtered, with_voxels);
    EXPECT_TRUE(isConsistent(filtered));
    filtered = frame;
    EXPECT_EQ(removeVoxelsBelow(filtered, 0.0f), 0u);
    expectSameFrame(filtered, frame);
  }
}

} // namespace
