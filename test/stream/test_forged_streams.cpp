// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/byte_writer.h"
#include "codec/published/entropy_coder.h"
#include "support/forged_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

constexpr std::uint64_t highest_number = std::numeric_limits<std::uint64_t>::max();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

void
expectRefused(const Bytes& bytes,
              std::size_t max_allocation,
              const DecoderLimits& limits)
{
  FrameDecoder decoder(limits);
  VoxelFrame back;
  const MemoryUse memory_use;
  const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), back);
  EXPECT_LE(memory_use.largest(), max_allocation);
  EXPECT_TRUE(status.code() == CompressionCode::Corrupt ||
              status.code() == CompressionCode::LimitExceeded ||
              status.code() == CompressionCode::Truncated)
      << status.message();
  EXPECT_TRUE(back.keys.empty());
  EXPECT_TRUE(back.intensities.empty());
}

constexpr std::size_t small_allocation = std::size_t{1} << 18;

TEST(ForgedStreams, InvalidHeaderFields)
{
  std::mt19937_64 random(1);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Parts good = takeApart(encoded(encoder, randomFrame(random, 4, 30)));
  const float nan_float = std::numeric_limits<float>::quiet_NaN();
  const float infinite_float = std::numeric_limits<float>::infinity();
  using HeaderChange = std::function<void(Version1Header&)>;
  std::vector<HeaderChange> changes;
  for (const std::uint64_t number : {highest_number,
                                     highest_number / 2 + 1,
                                     std::uint64_t{1} << 40,
                                     std::uint64_t{1} << 24,
                                     std::uint64_t{1000},
                                     std::uint64_t{0}}) {
    changes.push_back([=](Version1Header& h) { h.voxel_count = number; });
    changes.push_back([=](Version1Header& h) { h.payload_size = number; });
    changes.push_back([=](Version1Header& h) {
      h.voxel_count = number;
      h.payload_size = number;
    });
  }
  for (const int step : {-1, 1}) {
    const auto off_by_one = static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
    changes.push_back([=](Version1Header& h) { h.voxel_count += off_by_one; });
    changes.push_back([=](Version1Header& h) { h.payload_size += off_by_one; });
    changes.push_back(
        [=](Version1Header& h) { h.grid.depth += static_cast<unsigned>(step); });
  }
  for (const unsigned int number : {0u, 1u, 3u, 5u, 21u, 22u, 64u, 255u})
    changes.push_back([=](Version1Header& h) { h.grid.depth = number; });
  for (const double number : {0.0, -1.0, nan_value, infinite, -infinite, -0.0})
    changes.push_back([=](Version1Header& h) { h.grid.resolution = number; });
  for (const std::int32_t number :
       {INT32_MIN, INT32_MAX, -(1 << 20) - 1, (1 << 20) - 15, 1 << 20})
    changes.push_back([=](Version1Header& h) { h.grid.first_index[1] = number; });
  for (const unsigned int number : {0u, 7u, 17u, 255u})
    changes.push_back([=](Version1Header& h) { h.intensity_scale.bits = number; });
  for (const float number : {0.0f, -1.0f, nan_float, infinite_float})
    changes.push_back([=](Version1Header& h) { h.intensity_scale.step = number; });
  for (const float number : {nan_float, infinite_float, -infinite_float})
    changes.push_back([=](Version1Header& h) { h.intensity_scale.offset = number; });
  // Companded scales with no more numbers than levels, and with too many levels.
  for (const auto& [bits, range] : std::vector<std::pair<unsigned int, std::uint32_t>>{
           {4, 1}, {16, 65535}, {17, 65535}, {0, 65535}, {127, 65535}})
    changes.push_back([bits = bits, range = range](Version1Header& h) {
      h.intensity_scale.bits = bits;
      h.intensity_scale.companded_range = range;
    });
  changes.push_back([](Version1Header& h) { // written as 0
    h.intensity_scale.companded_range = 65536;
  });
  changes.push_back([](Version1Header& h) { h.has_depth_model = true; });
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE(i);
    Parts parts = good;
    changes[i](parts.header);
    expectRefused(putTogether(parts), small_allocation, DecoderLimits());
  }
  VoxelFrame back;
  FrameDecoder decoder;
  EXPECT_EQ(decoded(decoder, putTogether(good), back), CompressionCode::Ok);
}

TEST(ForgedStreams, CompandedScalesAreOneNumberWiderThanTheirLevels)
{
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  Parts parts = takeApart(encoded(encoder, emptyFrame(4)));
  for (unsigned int bits = 1; bits <= 15; ++bits) {
    parts.header.intensity_scale.bits = bits;
    VoxelFrame back;
    FrameDecoder decoder;
    parts.header.intensity_scale.companded_range = 1u << bits;
    EXPECT_EQ(decoded(decoder, putTogether(parts), back), CompressionCode::Ok);
    EXPECT_TRUE(isConsistent(back));
    parts.header.intensity_scale.companded_range = (1u << bits) - 1;
    expectRefused(putTogether(parts), small_allocation, DecoderLimits());
  }
}

TEST(ForgedStreams, PFramesThatContradictTheirReference)
{
  std::mt19937_64 random(4);
  const VoxelFrame frame = randomFrame(random, 4, 30);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Bytes i_frame = encoded(encoder, frame);
  const Bytes p_frame = encoded(encoder, frame);
  const std::uint32_t reference = takeApart(i_frame).checksum;
  const Parts good = takeApart(p_frame);
  ASSERT_FALSE(good.header.is_i_frame);
  const auto code = [&](const Parts& parts) {
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
    const CompressionCode result =
        decoded(decoder, putTogetherSized(parts, reference), back);
    // The stream goes on after the last good frame.
    EXPECT_EQ(decoded(decoder, p_frame, back),
              result == CompressionCode::Ok ? CompressionCode::OldFrame
                                            : CompressionCode::Ok);
    return result;
  };
  EXPECT_EQ(code(good), CompressionCode::Ok);
  Parts parts = good;
  parts.header.effort = Effort::Fast; // the I-frame's is Balanced
  EXPECT_EQ(code(parts), CompressionCode::Corrupt);
  parts = good;
  parts.header.has_depth_model = true; // the I-frame has none
  DepthModel model;
  model.full_symbol = 1000;
  Bytes payload;
  writeDepthModel(model, payload);
  append(parts.payload, payload);
  parts.payload = payload;
  EXPECT_EQ(code(parts), CompressionCode::Corrupt);
  parts = good;
  parts.header.stamp = std::numeric_limits<std::int64_t>::min();
  EXPECT_EQ(code(parts), CompressionCode::Corrupt);
  parts = good;
  parts.header.frame_number = 3;
  EXPECT_EQ(code(parts), CompressionCode::MissingReference);
  for (const std::uint32_t number : {0u, 1u, 0xffffffffu}) {
    parts = good;
    parts.header.frame_number = number;
    EXPECT_EQ(code(parts), CompressionCode::OldFrame) << number;
  }
  for (const int change : {-1, 1}) {
    parts = good;
    parts.header.voxel_count += static_cast<std::uint64_t>(std::int64_t{change});
    EXPECT_EQ(code(parts), CompressionCode::Corrupt);
  }
}

template <typename NumberT>
Bytes
overwritten(Bytes bytes, std::size_t at, NumberT number)
{
  std::memcpy(bytes.data() + at, &number, sizeof(number));
  return bytes;
}

TEST(ForgedStreams, InvalidPublishedFields)
{
  std::mt19937_64 random(4);
  FrameEncoder encoder(StreamFormat::Published, 10);
  const Bytes good = encoded(encoder, randomFrame(random, 4, 30));
  const std::size_t nodes_at = encoder.statistics().header_bytes;
  const std::size_t intensities_at = nodes_at + encoder.statistics().occupancy_bytes;
  DecoderLimits limits;
  limits.max_voxels = 20000;
  for (const std::size_t at : {std::size_t{11}, nodes_at, intensities_at}) {
    std::uint64_t truth;
    std::memcpy(&truth, good.data() + at, 8);
    for (const std::uint64_t number : {highest_number,
                                       highest_number / 2 + 1,
                                       std::uint64_t{1} << 32,
                                       std::uint64_t{20001},
                                       std::uint64_t{20000},
                                       std::uint64_t{0},
                                       truth - 1,
                                       truth + 1})
      expectRefused(overwritten(good, at, number),
                    21 * limits.max_voxels + small_allocation,
                    limits);
  }
  for (std::size_t at = 19; at < 75; at += 8)
    for (const double number : {nan_value,
                                infinite,
                                -infinite,
                                1e300,
                                -1e300,
                                12345.0,
                                at == 19 ? 0.0 : 0.01})
      expectRefused(overwritten(good, at, number), small_allocation, limits);
  for (const double number : {-0.04, -0.0, 0.08, 0.02, 1e-300, 0.04001})
    expectRefused(overwritten(good, 19, number), small_allocation, limits);
  for (const int number : {2, 3, 128, 255})
    expectRefused(overwritten(good, 10, static_cast<std::uint8_t>(number)),
                  small_allocation,
                  limits);
}

TEST(ForgedStreams, InvalidPublishedTrees)
{
  FrameEncoder encoder(StreamFormat::Published, 10);
  const Bytes empty = encoded(encoder, emptyFrame(2));
  const auto code = [&](const Bytes& nodes, std::uint64_t voxels) {
    Bytes bytes = overwritten(empty, 11, voxels);
    bytes.resize(encoder.statistics().header_bytes);
    ByteWriter writer(bytes);
    for (const Bytes& row : {nodes, Bytes(static_cast<std::size_t>(voxels), 7)}) {
      writer.u64(row.size());
      published::encodeStaticRange(row, bytes);
    }
    FrameDecoder decoder;
    VoxelFrame back;
    return decoded(decoder, bytes, back);
  };
  EXPECT_EQ(code({0}, 0), CompressionCode::Ok); // the empty frame
  EXPECT_EQ(code({0x03, 0x01, 0x80}, 2), CompressionCode::Ok);
  EXPECT_EQ(code({0x03, 0x01, 0x00}, 1), CompressionCode::Ok); // a branch of none
  EXPECT_EQ(code({0x03, 0x00, 0x00}, 0), CompressionCode::Ok);
  EXPECT_EQ(code({}, 0), CompressionCode::Corrupt);
  EXPECT_EQ(code({0, 0}, 0), CompressionCode::Corrupt);
  EXPECT_EQ(code({0}, 1), CompressionCode::Corrupt);
  EXPECT_EQ(code({0x03, 0x01, 0x00}, 2), CompressionCode::Corrupt);
  EXPECT_EQ(code({0x03, 0x01}, 1), CompressionCode::Corrupt);       // a missing one
  EXPECT_EQ(code({0x01, 0x01, 0x01}, 1), CompressionCode::Corrupt); // one too many
  EXPECT_EQ(code({0x03, 0x01, 0x80}, 3), CompressionCode::Corrupt);
  EXPECT_EQ(code({0x03, 0x01, 0x80}, 1), CompressionCode::Corrupt);
  EXPECT_EQ(code({0x03, 0x01, 0x81}, 1), CompressionCode::Corrupt);
}

} // namespace
