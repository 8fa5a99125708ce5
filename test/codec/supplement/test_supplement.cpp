// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "codec/supplement/coarse_voxels.h"
#include "codec/supplement/supplement.h"
#include "support/status_codes.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

struct ContentCase {
  bool is_fine;
  bool has_intensities;
  unsigned int colour_bits;
  bool has_point_counts;
  bool has_fields;
};

std::vector<ContentCase>
allContents()
{
  std::vector<ContentCase> contents;
  for (const bool is_fine : {false, true})
    for (const bool has_intensities : {false, true})
      for (const unsigned int colour_bits : {0u, 1u, 5u, 8u})
        for (const bool has_point_counts : {false, true})
          for (const bool has_fields : {false, true})
            contents.push_back(
                {is_fine, has_intensities, colour_bits, has_point_counts, has_fields});
  return contents;
}

std::string
descriptionOf(const ContentCase& content)
{
  return std::string(content.is_fine ? "fine" : "room") +
         (content.has_intensities ? ", intensities" : "") + ", colour bits " +
         std::to_string(content.colour_bits) +
         (content.has_point_counts ? ", points" : "") +
         (content.has_fields ? ", fields" : "");
}

std::vector<VoxelFrame>
framesOf(const ContentCase& content)
{
  std::mt19937_64 random(11);
  RoomStream room(roomSettings(6, 20));
  std::vector<VoxelFrame> frames;
  for (int i = 0; i < 7; ++i) {
    VoxelFrame frame = content.is_fine ? fineFrame(random, 8) : room.next();
    if (i == 4)
      frame.clearVoxels();
    if (!content.has_intensities)
      removeIntensities(frame);
    if (content.colour_bits > 0)
      addColours(random, content.colour_bits, frame);
    if (content.has_point_counts)
      addPointCounts(random, frame);
    if (content.has_fields)
      addFields(random, frame);
    frames.push_back(frame);
  }
  return frames;
}

TEST(Supplements, WhatIsEncodedIsDecoded)
{
  for (const ContentCase& content : allContents())
    for (const Effort effort : all_efforts) {
      SCOPED_TRACE(descriptionOf(content) + ", " + nameOf(effort));
      FrameEncoder encoder(StreamFormat::Version1, 3, effort);
      FrameDecoder decoder;
      for (const VoxelFrame& frame : framesOf(content)) {
        const Bytes bytes = encoded(encoder, frame);
        VoxelFrame after;
        ASSERT_EQ(decoded(decoder, bytes, after), CompressionCode::Ok);
        expectSameFrame(after, frame);
        const CodedFrameStatistics& coded = encoder.statistics();
        EXPECT_EQ(coded.header_bytes + coded.occupancy_bytes + coded.intensity_bytes +
                      coded.attribute_bytes,
                  bytes.size());
        EXPECT_EQ(coded.voxels, frame.size());
        const CodedFrameStatistics& seen = decoder.statistics();
        EXPECT_EQ(seen.bytes, bytes.size());
        EXPECT_EQ(seen.voxels, frame.size());
        EXPECT_EQ(seen.frame_number, coded.frame_number);
        EXPECT_EQ(seen.is_i_frame, coded.is_i_frame);
        EXPECT_EQ(seen.header_bytes, coded.header_bytes);
        EXPECT_EQ(seen.skipped_bytes, 0u);
      }
    }
}

TEST(Supplements, ColoursOfAnUnchangedRoomCostNearlyNothing)
{
  std::mt19937_64 random(5);
  RoomStream room(roomSettings(6, 20));
  VoxelFrame frame = room.next();
  addColours(random, 6, frame);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  encoded(encoder, frame);
  const std::size_t first = encoder.statistics().attribute_bytes;
  for (int i = 0; i < 12; ++i)
    encoded(encoder, frame);
  EXPECT_LT(10 * encoder.statistics().attribute_bytes, first);
}

TEST(Supplements, VoxelsOfMoreBytesThanThereAreAreRefused)
{
  supplement::Content content;
  content.refinement_levels = 1;
  const std::vector<std::uint64_t> coarse_voxels = {0};
  const std::array<std::int32_t, 3> viewpoint{};
  const supplement::Parameters parameters{
      content, coarse_voxels, Effort::Fast, true, 1, 0, viewpoint};
  for (const Bytes& bytes :
       {Bytes(), Bytes{0x80}, Bytes{1}, Bytes{200, 1, 0}, Bytes(11, 0xff)}) {
    supplement::SupplementCoder coder;
    VoxelFrame frame;
    supplement::Sizes sizes;
    EXPECT_FALSE(coder.decode(
        parameters, bytes.data(), bytes.data() + bytes.size(), frame, sizes));
  }
}

TEST(Supplements, PointsAreLimitedByTheLimitOnVoxels)
{
  std::mt19937_64 random(3);
  VoxelFrame frame = randomFrame(random, 4, 10);
  frame.has_point_counts = true;
  frame.point_counts.assign(frame.size(), 16);
  FrameEncoder encoder(StreamFormat::Version1, 30, Effort::Fast);
  DecoderLimits limits;
  limits.max_voxels = frame.size();
  VoxelFrame after;
  FrameDecoder decoder(limits);
  EXPECT_EQ(decoded(decoder, encoded(encoder, frame), after), CompressionCode::Ok);
  ++frame.point_counts[0];
  encoder.requestIFrame();
  EXPECT_EQ(decoded(decoder, encoded(encoder, frame), after),
            CompressionCode::LimitExceeded);
}

TEST(Refinement, StaysWhereAFrameHasNoVoxels)
{
  std::mt19937_64 random(7);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Fast);
  std::vector<bool> is_i_frame;
  for (int i = 0; i < 6; ++i) {
    VoxelFrame frame = fineFrame(random, 8);
    if (i % 3 == 2)
      frame.clearVoxels();
    encoded(encoder, frame);
    is_i_frame.push_back(encoder.statistics().is_i_frame);
  }
  EXPECT_FALSE(is_i_frame[2]);
  EXPECT_FALSE(is_i_frame[5]);
}

TEST(Refinement, IsChosenWhereVoxelsAreAlone)
{
  std::mt19937_64 random(7);
  const VoxelFrame fine = fineFrame(random, 8);
  const unsigned int levels = supplement::chooseRefinement(fine);
  EXPECT_GE(levels, 4u);
  EXPECT_LE(levels, 8u);
  VoxelFrame surface = RoomStream(roomSettings(7, 45)).next();
  surface.grid.resolution = fine.grid.resolution;
  ASSERT_GE(surface.size(), 1024u);
  EXPECT_EQ(supplement::chooseRefinement(surface), 0u);
  // Larger voxels are coded within smaller cells.
  VoxelFrame coarse = fine;
  coarse.grid.resolution = 0.001;
  EXPECT_LT(supplement::chooseRefinement(coarse), levels);
  EXPECT_GE(supplement::chooseRefinement(coarse), 2u);
  // Large voxels come again, however sparse they are.
  VoxelFrame other = fine;
  other.grid.resolution = 0.0051;
  EXPECT_EQ(supplement::chooseRefinement(other), 0u);
  other = fine;
  other.keys.resize(1023);
  EXPECT_EQ(supplement::chooseRefinement(other), 0u);
  // In many voxels the coders find what is not noise.
  other.keys.clear();
  for (std::uint64_t i = 0; i < 16384; ++i)
    other.keys.push_back(i << 12);
  EXPECT_GE(supplement::chooseRefinement(other), 4u);
  other.grid.resolution = 0.00051;
  EXPECT_EQ(supplement::chooseRefinement(other), 0u);
  other.keys.pop_back();
  EXPECT_GE(supplement::chooseRefinement(other), 4u);
}

TEST(Refinement, EndsWhereVoxelsComeAgain)
{
  // The voxels of a frame that is repeated are tracked: a history is smaller than
  // cells.
  std::mt19937_64 random(7);
  const VoxelFrame fine = fineFrame(random, 8);
  FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
  const std::size_t with_cells = encoded(encoder, fine).size();
  for (int i = 0; i < 8; ++i)
    encoded(encoder, fine);
  EXPECT_FALSE(encoder.statistics().is_i_frame);
  EXPECT_LT(4 * encoder.statistics().bytes, with_cells);
}

} // namespace
