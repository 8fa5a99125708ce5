/** \file
 * \brief Memory of many streams, and of frames of few bytes and many voxels or blocks.
 */
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/memory_budget.h>

#include "support/payload_frames.h"
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
  constexpr std::size_t voxels = 100000;
  constexpr std::size_t streams = 60;
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
    EXPECT_NE(status.message().find("dropped to keep the memory limit of 96 MB"),
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
  EXPECT_EQ(message_of(regularFrame(voxels, 1), (bytes_of_voxel + 10) * voxels), "");
  EXPECT_EQ(message_of(regularFrame(voxels, 1), bytes_of_voxel * voxels - 1),
            "the frame takes 2 MB of memory or more, and the memory limit is 2 MB");
  EXPECT_EQ(message_of(regularFrame(voxels, block_cells),
                       (bytes_of_voxel + bytes_of_block) * voxels),
            "");
  EXPECT_EQ(message_of(regularFrame(voxels, block_cells),
                       (bytes_of_voxel + bytes_of_block) * voxels - bytes_of_block),
            "the frame takes 11 MB of memory or more, and the memory limit is 11 MB");
}

TEST(MemoryBudget, IsHalfOfTheMachinesMemoryByDefault)
{
  EXPECT_EQ(MemoryBudget().limit(), MemoryBudget::machineBytes() / 2);
  EXPECT_GT(MemoryBudget::machineBytes(), std::size_t{1} << 28);
}

TEST(FreeVoxels, FramesOfFewBytesHaveFewBlocks)
{
  constexpr std::size_t free_blocks = std::size_t{1} << 20;
  for (const Effort effort : {Effort::Fast, Effort::Balanced}) {
    SCOPED_TRACE(nameOf(effort));
    FrameEncoder encoder(StreamFormat::Version1, 1, effort);
    const Bytes most = encoded(encoder, regularFrame(free_blocks, block_cells));
    const Bytes more = encoded(encoder, regularFrame(free_blocks + 1, block_cells));
    ASSERT_LT(more.size(), free_blocks / 8);
    VoxelFrame back;
    FrameDecoder decoder;
    EXPECT_EQ(decoded(decoder, most, back), CompressionCode::Ok);
    const MemoryUse memory_use;
    const CompressionStatus status = decoder.decode(more.data(), more.size(), back);
    EXPECT_EQ(status.code(), CompressionCode::LimitExceeded);
    EXPECT_NE(status.message().find("blocks of 1048577 voxels exceed the limit of"),
              std::string::npos)
        << status;
    EXPECT_LE(memory_use.peak(), (bytes_of_voxel + bytes_of_block) * free_blocks);
    DecoderLimits limits;
    limits.free_voxels = limits.max_voxels;
    FrameDecoder trusting(limits);
    EXPECT_EQ(decoded(trusting, more, back), CompressionCode::Ok);
    EXPECT_EQ(back.size(), free_blocks + 1);
  }
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
