// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/forged_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

class CountingBuffer : public std::stringbuf {
public:
  explicit CountingBuffer(const Bytes& bytes)
  : std::stringbuf(std::string(bytes.begin(), bytes.end()), std::ios_base::in)
  {}

  std::size_t
  bytesRead() const
  {
    return bytes_read_;
  }

protected:
  std::streamsize
  xsgetn(char* bytes, std::streamsize size) override
  {
    const std::streamsize got = std::stringbuf::xsgetn(bytes, size);
    bytes_read_ += static_cast<std::size_t>(got);
    return got;
  }

private:
  std::size_t bytes_read_ = 0;
};

enum class Claim { AllThatFollows, HalfOfIt, Little };

/** \brief Frame headers, one after the other, whose payload would be what follows. */
Bytes
manyHeaders(std::size_t size, bool are_i_frames, Claim claim)
{
  Bytes stream;
  Parts beginning;
  beginning.header.grid = emptyFrame(8).grid;
  beginning.header.is_i_frame = are_i_frames;
  beginning.header.voxel_count = 1000;
  while (stream.size() < size) {
    ++beginning.header.frame_number;
    const std::size_t left = size - stream.size();
    beginning.header.payload_size = claim == Claim::AllThatFollows ? left
                                    : claim == Claim::HalfOfIt     ? left / 2
                                                                   : left % 1000;
    append(putTogether(beginning), stream);
  }
  return stream;
}

TEST(HostileStreams, SearchingIsLinearInTheBytes)
{
  constexpr std::size_t size = std::size_t{1} << 19;
  DecoderLimits limits;
  limits.max_frame_bytes = std::size_t{1} << 20;
  std::mt19937_64 random(1);
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  const VoxelFrame frame = randomFrame(random, 4, 40);
  for (const bool are_i_frames : {true, false})
    for (const Claim claim : {Claim::AllThatFollows, Claim::HalfOfIt, Claim::Little}) {
      Bytes stream = manyHeaders(size, are_i_frames, claim);
      append(encoded(encoder, frame), stream);
      append(encoded(encoder, frame), stream);
      CountingBuffer buffer(stream);
      FrameDecoder decoder(limits);
      VoxelFrame back;
      std::size_t good_frames = 0;
      CompressionCode code = CompressionCode::Ok;
      for (std::size_t calls = 0; code != CompressionCode::EndOfStream; ++calls) {
        ASSERT_LE(calls, stream.size());
        code = decoder.decode(buffer, back).code();
        if (code == CompressionCode::Ok) {
          ++good_frames;
          expectSameVoxels(back, frame);
        }
      }
      // Each byte once, and sixteen times again, besides those that may be read at
      // first.
      EXPECT_LE(buffer.bytesRead(), 17 * stream.size() + limits.max_frame_bytes);
      EXPECT_GE(good_frames, 1u);
    }
}

constexpr std::size_t huge = std::size_t{1} << 16; // voxels

/** \brief A frame of voxels a block apart, which take the most memory and, in this
 * order, few bytes. */
VoxelFrame
distantVoxels(std::size_t count)
{
  VoxelFrame frame = emptyFrame(9);
  for (std::uint64_t i = 0; i < count; ++i)
    frame.keys.push_back(i << 6);
  frame.intensities.assign(count, 1);
  return frame;
}

struct Case {
  StreamFormat format;
  Effort effort;
};

constexpr Case cases[] = {{StreamFormat::Version1, Effort::Fast},
                          {StreamFormat::Version1, Effort::Balanced},
                          {StreamFormat::Version1, Effort::Small},
                          {StreamFormat::Published, Effort::Fast}};

/** \brief Frames of a small stream whose numbers begin with 2. */
std::vector<Bytes>
smallStream(const Case& kind, std::size_t count)
{
  std::mt19937_64 random(2);
  FrameEncoder encoder(kind.format, 100, kind.effort);
  const VoxelFrame frame = randomFrame(random, 5, 100);
  encoded(encoder, frame);
  encoder.requestIFrame();
  return encodedWalk(encoder, random, frame, count, 3).bytes;
}

/** \brief Memory that a decoder holds behind frames, the one that they are decoded into
 * included. */
std::size_t
heldBehind(FrameDecoder& decoder, VoxelFrame& frame, const std::vector<Bytes>& stream)
{
  const MemoryUse memory_use;
  for (const Bytes& bytes : stream)
    EXPECT_TRUE(decoder.decode(bytes.data(), bytes.size(), frame).ok());
  return memory_use.live();
}

TEST(HostileStreams, DecodersReleaseTheMemoryOfAHugeFrame)
{
  constexpr std::size_t frames = 9;
  for (const Case& kind : cases)
    for (const bool is_damaged : {false, true}) {
      FrameEncoder encoder(kind.format, 1, kind.effort);
      Bytes bytes = encoded(encoder, distantVoxels(huge));
      if (is_damaged && kind.format == StreamFormat::Version1) {
        Parts parts = takeApart(bytes);
        parts.payload.push_back(1); // after voxels that are all there
        bytes = putTogetherSized(parts);
      }
      const std::vector<Bytes> stream = smallStream(kind, frames);
      FrameDecoder usual;
      VoxelFrame usual_frame;
      const std::size_t usually_held = heldBehind(usual, usual_frame, stream);

      const MemoryUse memory_use;
      auto decoder = std::make_unique<FrameDecoder>();
      {
        VoxelFrame frame;
        decoder->decode(bytes.data(), bytes.size(), frame);
        EXPECT_GE(memory_use.peak(), 2 * huge); // else nothing is tested
        heldBehind(*decoder, frame, stream);
        EXPECT_LE(memory_use.live(), 2 * usually_held + (1u << 16));
      }
      decoder.reset();
      EXPECT_EQ(memory_use.live(), 0u);
    }
}

TEST(HostileStreams, OtherStreamsReleaseTheSharedMemoryOfAHugeFrame)
{
  const Case kind = cases[0];
  FrameEncoder encoder(kind.format, 1, kind.effort);
  const Bytes bytes = encoded(encoder, distantVoxels(huge));
  const std::vector<Bytes> stream = smallStream(kind, 9);
  DecodingMemory memory;
  FrameDecoder other;
  VoxelFrame frame;
  const MemoryUse memory_use;
  {
    FrameDecoder decoder;
    VoxelFrame huge_frame;
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), huge_frame, memory).ok());
    EXPECT_GE(memory_use.live(), 100 * huge);
  }
  for (const Bytes& small : stream)
    ASSERT_TRUE(other.decode(small.data(), small.size(), frame, memory).ok());
  EXPECT_LE(memory_use.live(), std::size_t{1} << 20);
}

TEST(HostileStreams, EncodersReleaseTheMemoryOfAHugeFrame)
{
  const VoxelFrame huge_frame = distantVoxels(huge);
  std::mt19937_64 random(2);
  const VoxelFrame small_frame = randomFrame(random, 5, 100);
  for (const Case& kind : cases) {
    const MemoryUse memory_use;
    FrameEncoder encoder(kind.format, 100, kind.effort);
    Bytes bytes;
    ASSERT_TRUE(encoder.encode(huge_frame, std::nullopt, bytes).ok());
    for (int i = 0; i < 9; ++i) {
      ASSERT_TRUE(encoder.encode(small_frame, std::nullopt, bytes).ok());
    }
    bytes = Bytes();
    EXPECT_LE(memory_use.live(), std::size_t{1} << 22);
  }
}

TEST(HostileStreams, AnotherFormatReleasesTheMemoryOfTheFirst)
{
  for (const Case& first : cases)
    for (const Case& second : cases) {
      if (first.format == second.format)
        continue;
      FrameEncoder encoder(first.format, 1, first.effort);
      const Bytes bytes = encoded(encoder, distantVoxels(huge));
      const std::vector<Bytes> stream = smallStream(second, 10);
      const MemoryUse memory_use;
      FrameDecoder decoder;
      VoxelFrame frame;
      ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), frame).ok());
      heldBehind(decoder, frame, stream);
      EXPECT_LE(memory_use.live(), std::size_t{1} << 22);
    }
}

TEST(HostileStreams, FramesWithAForgedVoxelCountKeepNoMemory)
{
  for (const bool is_i_frame : {false, true}) {
    FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Fast);
    const Bytes bytes = encoded(encoder, distantVoxels(huge));
    Parts claim;
    claim.header.is_i_frame = is_i_frame;
    claim.header.grid = emptyFrame(8).grid;
    claim.header.frame_number = 1000000; // of no frame that comes
    claim.header.voxel_count = std::size_t{1} << 20;
    claim.payload = {0, 0, 0, 0};
    const Bytes forged = putTogetherSized(claim);
    const MemoryUse memory_use;
    FrameDecoder decoder;
    VoxelFrame frame;
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), frame).ok());
    const std::vector<Bytes> stream = smallStream(cases[0], 30);
    for (std::size_t i = 0; i < stream.size(); ++i) {
      if (i % 7 == 0) {
        EXPECT_FALSE(decoder.decode(forged.data(), forged.size(), frame).ok());
      }
      EXPECT_TRUE(decoder.decode(stream[i].data(), stream[i].size(), frame).ok());
    }
    EXPECT_LE(memory_use.live(), std::size_t{1} << 22);
  }
}

TEST(HostileStreams, UnverifiableHeadersHideNoFrame)
{
  std::mt19937_64 random(4);
  FrameEncoder encoder(StreamFormat::Version1, 1, Effort::Balanced);
  const VoxelFrame frame = randomFrame(random, 4, 40);
  Parts claim;
  claim.header.is_i_frame = false;
  claim.header.frame_number = 1000;
  claim.header.voxel_count = 5;
  Bytes stream;
  constexpr std::size_t frames = 400;
  for (std::size_t i = 0; i < frames; ++i) {
    append(putTogether(claim), stream);
    append(encoded(encoder, frame), stream);
    // From here on claims end in the middle of a frame, or after all of them.
    const std::size_t distance = stream.size() / (i + 1);
    claim.header.payload_size = 200 * distance + distance / 2;
  }
  DecoderLimits limits;
  limits.max_frame_bytes = 40000;
  std::stringbuf buffer = bufferOf(stream);
  FrameDecoder decoder(limits);
  VoxelFrame back;
  std::size_t good_frames = 0;
  CompressionCode code = CompressionCode::Ok;
  while (code != CompressionCode::EndOfStream) {
    code = decoder.decode(buffer, back).code();
    good_frames += code == CompressionCode::Ok ? 1 : 0;
  }
  EXPECT_EQ(good_frames, frames);
}

TEST(HostileStreams, DefaultLimitsTakeAFrameOfAMegapixel)
{
  constexpr std::size_t megapixel = std::size_t{1} << 20;
  std::mt19937_64 random(3);
  for (const StreamFormat format : all_formats) {
    // The most bytes: voxels and intensities anywhere.
    VoxelFrame frame = emptyFrame(20, format == StreamFormat::Published ? 8 : 16);
    for (std::uint64_t i = 0; i < megapixel; ++i) {
      frame.keys.push_back((i << 40) + below(random, std::uint64_t{1} << 40));
      frame.intensities.push_back(static_cast<std::uint16_t>(
          below(random, std::uint64_t{1} << frame.intensity_scale.bits)));
    }
    FrameEncoder encoder(format, 1, Effort::Fast);
    const Bytes bytes = encoded(encoder, frame);
    FrameDecoder decoder;
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok) << bytes.size();
    EXPECT_EQ(back.keys, frame.keys);
    EXPECT_EQ(back.intensities, frame.intensities);
    if (format == StreamFormat::Published)
      continue;
    Parts more = takeApart(bytes);
    more.header.voxel_count = DecoderLimits().max_voxels + 1;
    EXPECT_EQ(decoded(decoder, putTogether(more), back),
              CompressionCode::LimitExceeded);
  }
}

} // namespace
