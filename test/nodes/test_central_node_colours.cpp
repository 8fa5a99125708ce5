// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A CentralNode keeps colours through noise removal and merging.
 */
#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::VoxelColour;

/** \brief Some voxels, with colours of a number of bits, or 0. */
VoxelFrame
colouredFrame(std::uint64_t seed, unsigned int colour_bits)
{
  std::mt19937_64 random(seed);
  VoxelFrame frame = pcl_ext::io::test::randomFrame(random, 4, 900, 6);
  frame.colour_bits = colour_bits;
  const auto channel = [&] {
    return static_cast<std::uint8_t>(below(random, std::uint64_t{1} << colour_bits));
  };
  for (std::size_t i = 0; colour_bits > 0 && i < frame.size(); ++i) {
    const std::uint8_t r = channel();
    const std::uint8_t g = channel();
    frame.colours.push_back({r, g, channel()});
  }
  return frame;
}

/** \brief Colours by key; of frames of the same grid. */
using Colours = std::map<std::uint64_t, std::vector<VoxelColour>>;

void
addColours(const VoxelFrame& frame, Colours& colours)
{
  for (std::size_t i = 0; i < frame.size(); ++i) {
    std::vector<VoxelColour>& all = colours[frame.keys[i]];
    if (frame.colour_bits > 0)
      all.push_back(frame.fullColour(i));
  }
}

using CentralColours = OneStream;

TEST_F(CentralColours, AreThoseOfTheVoxelsThatAreKept)
{
  const VoxelFrame frame = colouredFrame(3, 5);
  node.setMinIntensity("a", 3.0f);
  sendAndWait(node, "a", coded(frame));
  const VoxelFrame kept = latestVoxels(node);
  ASSERT_TRUE(isConsistent(kept));
  ASSERT_LT(kept.size(), frame.size());
  Colours colours;
  addColours(frame, colours);
  for (std::size_t i = 0; i < kept.size(); ++i)
    EXPECT_TRUE(kept.fullColour(i) == colours.at(kept.keys[i]).at(0));
}

TEST_F(CentralColours, OfMergedVoxelsAreTheMeanOfTheStreamsThatHaveThem)
{
  Colours expected;
  for (const unsigned int bits : {8u, 0u, 5u, 1u}) {
    const std::string name = "of bits " + std::to_string(bits);
    node.addStream(name);
    VoxelFrame frame = colouredFrame(bits, bits);
    if (bits == 0) { // so that the merged grid is that of the streams
      frame.keys.front() = 0;
      frame.keys.back() = 4095;
    }
    sendAndWait(node, name, coded(frame));
    addColours(frame, expected);
  }
  VoxelFrame merged;
  node.merge(merged);
  ASSERT_TRUE(isConsistent(merged));
  ASSERT_EQ(merged.colour_bits, 8u);
  ASSERT_EQ(merged.size(), expected.size());
  std::size_t without = 0;
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const std::vector<VoxelColour>& all = expected.at(merged.keys[i]);
    std::array<double, 3> sum{};
    for (const VoxelColour& colour : all) {
      sum[0] += colour.r;
      sum[1] += colour.g;
      sum[2] += colour.b;
    }
    without += all.empty() ? 1 : 0;
    const double count = all.empty() ? 1.0 : static_cast<double>(all.size());
    const VoxelColour colour = merged.fullColour(i);
    EXPECT_NEAR(colour.r, sum[0] / count, 0.5 + 1e-9);
    EXPECT_NEAR(colour.g, sum[1] / count, 0.5 + 1e-9);
    EXPECT_NEAR(colour.b, sum[2] / count, 0.5 + 1e-9);
  }
  EXPECT_GT(without, 0u);
}

TEST_F(CentralColours, AreNotInventedWhereNoStreamHasThem)
{
  sendAndWait(node, "a", coded(colouredFrame(1, 8)));
  VoxelFrame merged;
  node.merge(merged);
  EXPECT_EQ(merged.colours.size(), merged.size());
  sendAndWait(node, "a", coded(colouredFrame(1, 0)));
  node.merge(merged);
  EXPECT_TRUE(isConsistent(merged));
  EXPECT_EQ(merged.colour_bits, 0u);
}

} // namespace
