#include "counted_memory.h"
#include "voxel_frames.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr StreamFormat formats[] = {StreamFormat::Version1, StreamFormat::Published};

TEST(DecoderLimits, AreReachedExactly)
{
  std::mt19937_64 random(5);
  for (const StreamFormat format : formats) {
    FrameEncoder encoder(format, 10);
    const Bytes i_frame = encoded(encoder, randomFrame(random, 4, 60));
    VoxelFrame frame = randomFrame(random, 4, 61);
    const Bytes p_frame = encoded(encoder, frame);
    const auto code = [&](const DecoderLimits& limits, const Bytes& bytes) {
      FrameDecoder decoder(limits);
      VoxelFrame back;
      decoded(decoder, i_frame, back);
      return decoded(decoder, bytes, back);
    };
    DecoderLimits limits;
    limits.max_voxels = 61;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::Ok);
    EXPECT_EQ(code(limits, p_frame), CompressionCode::Ok);
    limits.max_voxels = 60;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::Ok);
    EXPECT_EQ(code(limits, p_frame), CompressionCode::LimitExceeded);
    limits.max_voxels = 59;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::LimitExceeded);

    limits = DecoderLimits();
    limits.max_frame_bytes = i_frame.size();
    EXPECT_EQ(code(limits, i_frame), CompressionCode::Ok);
    limits.max_frame_bytes = i_frame.size() - 1;
    EXPECT_EQ(code(limits, i_frame), CompressionCode::LimitExceeded);
    for (std::size_t bytes = 1; bytes < 12; ++bytes) {
      limits.max_frame_bytes = bytes;
      EXPECT_NE(code(limits, i_frame), CompressionCode::Ok);
    }
  }
}

TEST(DecoderLimits, AFrameBehindMuchGarbageIsFoundWhereverItBegins)
{
  std::mt19937_64 random(6);
  for (const StreamFormat format : formats) {
    FrameEncoder encoder(format, 1);
    const VoxelFrame frame = randomFrame(random, 3, 10);
    const Bytes bytes = encoded(encoder, frame);
    DecoderLimits limits;
    limits.max_frame_bytes = bytes.size() + 10;
    for (std::size_t before = 0; before < 3 * limits.max_frame_bytes; ++before) {
      Bytes stream(before, 0);
      append(bytes, stream);
      std::stringbuf buffer(std::string(stream.begin(), stream.end()));
      FrameDecoder decoder(limits);
      VoxelFrame back;
      CompressionCode code = CompressionCode::NoFrame;
      for (int calls = 0; calls < 5 && code == CompressionCode::NoFrame; ++calls)
        code = decoder.decode(buffer, back).code();
      ASSERT_EQ(code, CompressionCode::Ok) << before << " bytes of garbage";
      expectSameVoxels(back, frame);
    }
  }
}

/** \brief As DecoderLimits::max_voxels has it. At 21 levels random voxels share hardly
 * a branch. */
constexpr std::size_t
promisedBytesPerVoxel(unsigned int depth)
{
  return depth < 21 ? 100 : 350;
}

TEST(DecoderLimits, MemoryStaysWithinThePromise)
{
  std::mt19937_64 random(7);
  DecoderLimits limits;
  limits.max_voxels = std::size_t{1} << 15;
  for (const StreamFormat format : formats)
    for (const unsigned int depth : {5u, 8u, 21u}) {
      FrameEncoder encoder(format, 2);
      VoxelFrame frame = randomFrame(random, depth, 0);
      if (depth == 5) // all of the grid
        for (std::uint64_t key = 0; key < limits.max_voxels; ++key) {
          frame.keys.push_back(key);
          frame.intensities.push_back(static_cast<std::uint16_t>(key % 256));
        }
      else
        frame = randomFrame(random, depth, limits.max_voxels);
      const Bytes i_frame = encoded(encoder, frame);
      const Bytes p_frame = encoded(encoder, frame);
      FrameDecoder decoder(limits);
      VoxelFrame back;
      memory_count.reset();
      const std::size_t before = memory_count.live;
      ASSERT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
      ASSERT_EQ(decoded(decoder, p_frame, back), CompressionCode::Ok);
      const std::size_t taken = memory_count.peak - before;
      EXPECT_LE(taken,
                promisedBytesPerVoxel(depth) * limits.max_voxels + i_frame.size() +
                    p_frame.size())
          << "depth " << depth << ": " << taken / limits.max_voxels << " bytes a voxel";
    }
}

} // namespace
