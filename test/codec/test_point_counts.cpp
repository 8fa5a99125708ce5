// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "codec/payload_coder.h"
#include "support/forged_frames.h"
#include "support/status_codes.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief Frames of a room with 12 bits of intensity, which are numbers of points. */
std::vector<VoxelFrame>
roomFrames()
{
  RoomStream room(roomSettings(7, 45, false, 12));
  std::vector<VoxelFrame> frames;
  for (int i = 0; i < 12; ++i)
    frames.push_back(room.next());
  return frames;
}

std::size_t
sizeOf(const std::vector<VoxelFrame>& frames, Effort effort)
{
  FrameEncoder encoder(StreamFormat::Version1, 100, effort);
  std::size_t size = 0;
  for (const VoxelFrame& frame : frames)
    size += encoded(encoder, frame).size();
  return size;
}

void
setPointCounts(VoxelFrame& frame)
{
  frame.has_point_counts = true;
  frame.point_counts.assign(frame.intensities.begin(), frame.intensities.end());
}

TEST(PointCounts, CostNoMoreThanTheSameIntensities)
{
  const std::vector<VoxelFrame> intensities = roomFrames();
  std::vector<VoxelFrame> voxels = intensities;
  std::vector<VoxelFrame> counts = intensities;
  std::vector<VoxelFrame> both = intensities;
  for (VoxelFrame& frame : voxels)
    removeIntensities(frame);
  for (VoxelFrame& frame : counts) {
    setPointCounts(frame);
    removeIntensities(frame);
  }
  for (VoxelFrame& frame : both)
    setPointCounts(frame);
  // What the header has to say: the content, and the sum of all numbers. Effort fast has
  // words of two bytes.
  const std::size_t of_headers = (4 + 2) * intensities.size();
  for (const Effort effort : all_efforts) {
    SCOPED_TRACE(nameOf(effort));
    const std::size_t size = sizeOf(intensities, effort);
    EXPECT_LE(sizeOf(counts, effort), size + of_headers);
    // Effort small also derives the next occupancy from the first numbers of a voxel.
    const std::size_t of_numbers = size - sizeOf(voxels, effort);
    EXPECT_LE(sizeOf(both, effort) - size, of_numbers + of_numbers / 100 + of_headers);
  }
}

TEST(PointCounts, OfAllSizesAreDecoded)
{
  const std::vector<std::uint32_t> sizes = {
      1, 15, 16, 4094, 4095, 4096, 4097, 1u << 16, (1u << 24) + 1};
  DecoderLimits limits;
  limits.free_voxels = limits.max_voxels; // many points of few bytes
  std::vector<VoxelFrame> frames = roomFrames();
  for (const bool has_intensities : {false, true})
    for (const Effort effort : all_efforts) {
      SCOPED_TRACE(nameOf(effort) + (has_intensities ? ", intensities" : ""));
      FrameEncoder encoder(StreamFormat::Version1, 3, effort);
      FrameDecoder decoder(limits);
      std::size_t next = 0;
      for (VoxelFrame frame : frames) {
        setPointCounts(frame);
        for (std::size_t i = 0; i < frame.size(); i += 40)
          frame.point_counts[i] = sizes[next++ % sizes.size()];
        if (!has_intensities)
          removeIntensities(frame);
        VoxelFrame after;
        ASSERT_EQ(decoded(decoder, encoded(encoder, frame), after),
                  CompressionCode::Ok);
        expectSameFrame(after, frame);
      }
    }
}

/** \brief The answer to an I-frame of a frame that an encoder would refuse. */
CompressionCode
answerToPayloadOf(const VoxelFrame& forged, Effort effort, const Bytes& good)
{
  Parts parts = takeApart(good);
  PayloadCoders coders;
  CodingWorkspace memory;
  parts.payload.clear();
  coders.of(effort).encode(memory, forged, true, parts.payload);
  FrameDecoder decoder;
  VoxelFrame after;
  return decoded(decoder, putTogetherSized(parts), after);
}

TEST(PointCounts, OfNoPointsAndWithAnotherSumAreRefused)
{
  VoxelFrame frame = roomFrames().front();
  setPointCounts(frame);
  frame.point_counts[0] = 7;
  for (const bool has_intensities : {true, false})
    for (const Effort effort : all_efforts) {
      SCOPED_TRACE(nameOf(effort) + (has_intensities ? ", intensities" : ""));
      if (!has_intensities)
        removeIntensities(frame);
      FrameEncoder encoder(StreamFormat::Version1, 3, effort);
      const Bytes good = encoded(encoder, frame);
      EXPECT_EQ(answerToPayloadOf(frame, effort, good), CompressionCode::Ok);
      VoxelFrame forged = frame;
      forged.point_counts[0] = 8;
      EXPECT_EQ(answerToPayloadOf(forged, effort, good), CompressionCode::Corrupt);
      forged.point_counts[0] = 0;
      forged.point_counts[1] += 7;
      EXPECT_EQ(answerToPayloadOf(forged, effort, good), CompressionCode::Corrupt);
    }
}

} // namespace
