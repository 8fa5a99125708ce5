// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/decoder_limits.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "codec/frame_limits.h"
#include "codec/memory_share.h"
#include "support/forged_frames.h"
#include "support/payload_frames.h"
#include "support/supplement_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

/** \brief Voxels that take few bytes, as they are each so many keys from the next one. */
VoxelFrame
regularFrame(std::size_t voxels, std::uint64_t step)
{
  VoxelFrame frame = emptyFrame(12);
  for (std::uint64_t i = 0; i < voxels; ++i)
    frame.keys.push_back(i * step);
  frame.intensities.assign(voxels, 7);
  return frame;
}

TEST(MemoryBudget, OfAllStreamsIsKeptByDroppingTheIdleOnes)
{
  constexpr std::size_t voxels = 50000;
  constexpr std::size_t streams = 40;
  constexpr std::size_t limit = 8 * bytes_of_voxel * voxels;
  for (const Effort effort : all_efforts) {
    SCOPED_TRACE(nameOf(effort));
    const VoxelFrame cube = regularFrame(voxels, 1);
    FrameEncoder encoder(StreamFormat::Version1, 100, effort);
    const Bytes i_frame = encoded(encoder, cube);
    const Bytes p_frame = encoded(encoder, cube);
    ASSERT_LT(i_frame.size(), 2000u);

    DecoderLimits limits;
    limits.budget = std::make_shared<MemoryBudget>(limit);
    std::vector<FrameDecoder> decoders;
    VoxelFrame back;
    const MemoryUse memory_use;
    for (std::size_t i = 0; i < streams; ++i) {
      decoders.emplace_back(limits);
      ASSERT_EQ(decoded(decoders.back(), i_frame, back), CompressionCode::Ok);
    }
    EXPECT_LE(limits.budget->used(), limit);
    EXPECT_LE(memory_use.live(), limits.budget->used() + bytes_of_voxel * voxels);
    EXPECT_LE(memory_use.peak(), limit + 2 * bytes_of_voxel * voxels);
    EXPECT_GT(limits.budget->drops(), streams / 2);

    // The one that was used last goes on; the first one after its next I-frame.
    EXPECT_EQ(decoded(decoders.back(), p_frame, back), CompressionCode::Ok);
    const CompressionStatus status =
        decoders.front().decode(p_frame.data(), p_frame.size(), back);
    EXPECT_EQ(status.code(), CompressionCode::MissingReference);
    EXPECT_NE(status.message().find("dropped to keep the memory limit of 48 MB"),
              std::string::npos)
        << status;
    encoder.requestIFrame();
    EXPECT_EQ(decoded(decoders.front(), encoded(encoder, cube), back),
              CompressionCode::Ok);
    EXPECT_EQ(decoded(decoders.front(), encoded(encoder, cube), back),
              CompressionCode::Ok);
    expectSameFrame(back, cube);
    decoders.clear();
    EXPECT_EQ(limits.budget->used(), 0u);
  }
}

/** \brief Expects that decoders of equal frames keep what is counted, and not much less.
 * \tparam DecodedT what they decode to: frames or their changes
 */
template <typename DecodedT>
void
expectMemoryCounted(const VoxelFrame& frame, Effort effort, std::size_t frames)
{
  SCOPED_TRACE(std::string(nameOf(effort)) + ", " + std::to_string(frame.size()));
  FrameEncoder encoder(StreamFormat::Version1, 100, effort);
  std::vector<Bytes> stream;
  for (std::size_t i = 0; i < frames; ++i)
    stream.push_back(encoded(encoder, frame));
  DecoderLimits limits;
  limits.budget = std::make_shared<MemoryBudget>(std::size_t{1} << 40);
  DecodingMemory memory;
  DecodedT back;
  const auto decode = [&](FrameDecoder& decoder) {
    for (const Bytes& bytes : stream)
      EXPECT_TRUE(decoder.decode(bytes.data(), bytes.size(), back, memory).ok());
  };
  FrameDecoder first; // whose memory for a frame the others share
  decode(first);
  const MemoryUse memory_use;
  std::vector<FrameDecoder> decoders;
  for (std::size_t i = 0; i < 4; ++i) {
    decoders.emplace_back(limits);
    decode(decoders.back());
  }
  EXPECT_LE(memory_use.live(), limits.budget->used());
  EXPECT_GE(3 * memory_use.live(), limits.budget->used());
}

TEST(MemoryBudget, CountsWhatDecodersKeepAndNotMuchMore)
{
  std::mt19937_64 random(4);
  for (const Effort effort : all_efforts)
    for (const VoxelFrame& frame : {randomFrame(random, 8, 400),
                                    randomFrame(random, 12, 20000),
                                    regularFrame(30000, 1),
                                    regularFrame(20000, block_cells)})
      expectMemoryCounted<VoxelFrame>(frame, effort, 3);
  VoxelFrame coloured = randomFrame(random, 12, 20000);
  for (const std::size_t frames : {1u, 3u, 12u})
    expectMemoryCounted<VoxelChanges>(coloured, Effort::Fast, frames);
  addColours(random, 5, coloured);
  for (const std::size_t frames : {1u, 3u, 12u})
    expectMemoryCounted<VoxelChanges>(coloured, Effort::Fast, frames);
}

TEST(MemoryBudget, FramesBeyondTheWholeOfItAreRefusedWithTheReason)
{
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Fast);
  const auto message_of = [&](const VoxelFrame& frame, std::size_t bytes) {
    DecoderLimits limits;
    limits.budget = std::make_shared<MemoryBudget>(bytes);
    const Bytes coded = encoded(encoder, frame);
    VoxelFrame back;
    const CompressionStatus status =
        FrameDecoder(limits).decode(coded.data(), coded.size(), back);
    EXPECT_TRUE(status.ok() || status.code() == CompressionCode::LimitExceeded);
    return status.message();
  };
  constexpr std::size_t voxels = 20000;
  constexpr std::size_t of_voxel = bytes_of_voxel / 2; // without a history
  EXPECT_EQ(message_of(regularFrame(voxels, 1), (of_voxel + 10) * voxels), "");
  EXPECT_EQ(message_of(regularFrame(voxels, 1), of_voxel * voxels - 1),
            "the frame takes 1.2 MB of memory or more, and the memory limit is 1.1 MB");
  EXPECT_EQ(message_of(regularFrame(voxels, block_cells),
                       (of_voxel + bytes_of_block) * voxels),
            "");
  EXPECT_EQ(
      message_of(regularFrame(voxels, block_cells),
                 (of_voxel + bytes_of_block) * voxels - bytes_of_block),
      "the frame takes 10.8 MB of memory or more, and the memory limit is 10.7 MB");
}

TEST(MemoryBudget, IsAQuarterOfTheMachinesMemoryByDefault)
{
  EXPECT_EQ(MemoryBudget().limit(), MemoryBudget::machineBytes() / 4);
  EXPECT_GT(MemoryBudget::machineBytes(), std::size_t{1} << 28);
}

TEST(FreeVoxels, FramesOfFewBytesHaveFewBlocks)
{
  const VoxelFrame frame = regularFrame(free_blocks + 1, block_cells);
  for (const Effort effort : {Effort::Fast, Effort::Balanced}) {
    SCOPED_TRACE(nameOf(effort));
    FrameEncoder encoder(StreamFormat::Version1, 1, effort);
    // Without the padding with which readers take it.
    Parts parts = takeApart(encoded(encoder, frame));
    parts.payload.resize(parts.payload.size() - parts.header.padding_size);
    parts.header.padding_size = 0;
    const Bytes more = putTogetherSized(parts);
    ASSERT_LT(more.size(), free_blocks / 8);
    VoxelFrame back;
    FrameDecoder decoder;
    const MemoryUse memory_use;
    const CompressionStatus status = decoder.decode(more.data(), more.size(), back);
    EXPECT_EQ(status.code(), CompressionCode::LimitExceeded);
    EXPECT_NE(status.message().find("blocks of 1048577 voxels exceed the limit of"),
              std::string::npos)
        << status;
    EXPECT_LE(memory_use.peak(), (bytes_of_voxel + bytes_of_block) * free_blocks);
  }
}

TEST(FreeVoxels, AreAsManyAsTheLimitsSay)
{
  VoxelFrame back;
  for (const Effort effort : {Effort::Fast, Effort::Balanced}) {
    FrameEncoder most_free(StreamFormat::Version1, 1, effort);
    const Bytes most = encoded(most_free, regularFrame(free_blocks, block_cells));
    ASSERT_LT(most.size(), free_blocks / 8);
    FrameDecoder decoder;
    EXPECT_EQ(decoded(decoder, most, back), CompressionCode::Ok) << nameOf(effort);
  }
  // With their limit raised so few bytes are enough, too.
  FrameEncoder encoder(StreamFormat::Version1, 1);
  const std::size_t voxels = free_blocks / 8;
  const Bytes fewer = encoded(encoder, regularFrame(voxels, block_cells));
  DecoderLimits limits;
  for (const std::size_t free_voxels : {voxels / 2, limits.max_voxels}) {
    limits.free_voxels = free_voxels;
    FrameDecoder trusting(limits);
    EXPECT_EQ(decoded(trusting, fewer, back),
              free_voxels < voxels ? CompressionCode::LimitExceeded
                                   : CompressionCode::Ok);
  }
}

TEST(FreeVoxels, EncodersGiveFramesTheBytesThatDecodersDemand)
{
  const VoxelFrame small = regularFrame(1000, block_cells);
  const VoxelFrame large = regularFrame(free_blocks + 9, block_cells);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Fast);
  FrameDecoder decoder;
  VoxelFrame back;
  for (const VoxelFrame* frame : {&large, &large, &small, &small, &large}) {
    ASSERT_EQ(decoded(decoder, encoded(encoder, *frame), back), CompressionCode::Ok);
    expectSameFrame(back, *frame);
  }
  const CodedFrameStatistics& statistics = encoder.statistics();
  EXPECT_TRUE(statistics.is_i_frame); // as a P-frame has too few
  EXPECT_EQ(statistics.bytes - statistics.header_bytes,
            free_blocks / blocks_of_byte + 2);
  EXPECT_EQ(decoder.statistics().occupancy_bytes, statistics.occupancy_bytes);
}

TEST(FreeVoxels, FewestBytesAreWhatTheLimitsDemand)
{
  const std::size_t free_voxels = DecoderLimits().free_voxels;
  EXPECT_EQ(fewestBytes({free_voxels, free_blocks, free_points, free_values}), 0u);
  const std::vector<FrameCounts> all = {{free_voxels + 1, 0, 0, 0},
                                        {0, free_blocks + 1, 0, 0},
                                        {0, 0, free_points + 1, 0},
                                        {0, 0, 0, free_values + 1},
                                        {most_blocks, 0, 3 * free_points, 0}};
  for (const FrameCounts& counts : all) {
    const auto are_within = [&](std::uint64_t bytes) {
      const FrameLimits limits = frameLimits(DecoderLimits(), bytes);
      return counts.voxels <= limits.max_voxels && counts.blocks <= limits.max_blocks &&
             counts.points <= limits.max_points &&
             counts.field_values <= limits.max_field_values;
    };
    EXPECT_TRUE(are_within(fewestBytes(counts)));
    EXPECT_FALSE(are_within(fewestBytes(counts) - 1));
  }
}

TEST(FreeVoxels, VoxelsAndBlocksHaveAnEndWithoutLimits)
{
  const FrameLimits limits = frameLimits(DecoderLimits::none(), 0);
  EXPECT_EQ(limits.max_voxels, DecoderLimits::most_voxels);
  EXPECT_EQ(limits.max_blocks, std::size_t{1} << 26);
}

TEST(FreeVoxels, BytesSinceTheIFrameAllowMore)
{
  // A P-frame without a change has hardly a byte, and all that the I-frame has.
  DecoderLimits limits;
  limits.free_voxels = 1000;
  std::mt19937_64 random(3);
  for (const Effort effort : all_efforts) {
    FrameEncoder encoder(StreamFormat::Version1, 10, effort);
    const VoxelFrame frame = randomFrame(random, 8, 5000);
    FrameDecoder decoder(limits);
    VoxelFrame back;
    for (int i = 0; i < 3; ++i) {
      const Bytes bytes = encoded(encoder, frame);
      EXPECT_TRUE(i == 0 || bytes.size() < 5000 / 64) << bytes.size();
      EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    }
    const VoxelFrame cube = regularFrame(50000, 1);
    encoder.requestIFrame();
    const Bytes bytes = encoded(encoder, cube);
    const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), back);
    EXPECT_EQ(status.code(), CompressionCode::LimitExceeded) << status;
  }
}

} // namespace
