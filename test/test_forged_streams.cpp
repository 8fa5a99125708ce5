#include "compression/bit_io.h"
#include "compression/byte_source.h"
#include "compression/byte_writer.h"
#include "compression/memory_buffer.h"
#include "compression/static_range_coder.h"
#include "compression/static_rans.h"
#include "compression/version1_header.h"
#include "counted_memory.h"
#include "voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr std::uint64_t huge = std::numeric_limits<std::uint64_t>::max();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/** \brief A version 1 frame taken apart, to be put together with a lie in it and a
 * checksum that is right. */
struct Parts {
  Version1Header header;
  Bytes payload;
};

Parts
takeApart(const Bytes& frame)
{
  MemoryBuffer buffer(frame.data() + version1_magic_size,
                      frame.size() - version1_magic_size);
  ByteSource source(buffer, frame.size());
  Parts parts;
  std::uint32_t checksum = 0;
  Bytes header_bytes;
  EXPECT_TRUE(
      readVersion1Header(source, DecoderLimits(), parts.header, checksum, header_bytes)
          .ok());
  const auto payload_size = static_cast<std::ptrdiff_t>(parts.header.occupancy_size +
                                                        parts.header.intensity_size);
  parts.payload.assign(frame.end() - payload_size, frame.end());
  return parts;
}

Bytes
putTogether(const Parts& parts)
{
  Bytes bytes;
  writeVersion1Frame(parts.header, parts.payload, 0, bytes);
  return bytes;
}

/** \brief The bytes of an occupancy section: prediction, nodes and a row of them. */
Bytes
occupancy(std::uint8_t prediction, std::uint64_t nodes, const Bytes& row)
{
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.u8(prediction);
  writer.varint(nodes);
  writer.raw(row.data(), row.size());
  return bytes;
}

/** \brief Expects a refusal, without an allocation beyond a bound. */
void
expectRefused(const Bytes& bytes,
              std::size_t max_allocation,
              const DecoderLimits& limits)
{
  FrameDecoder decoder(limits);
  VoxelFrame back;
  memory_count.reset();
  const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), back);
  EXPECT_LE(memory_count.largest, max_allocation);
  EXPECT_TRUE(status.code() == CompressionCode::Corrupt ||
              status.code() == CompressionCode::LimitExceeded ||
              status.code() == CompressionCode::Truncated)
      << status.message();
  EXPECT_TRUE(back.keys.empty());
  EXPECT_TRUE(back.intensities.empty());
}

constexpr std::size_t small_allocation = std::size_t{1} << 17;

TEST(ForgedStreams, HeadersThatLie)
{
  std::mt19937_64 random(1);
  FrameEncoder encoder(StreamFormat::Version1, 10);
  const Parts good = takeApart(encoded(encoder, randomFrame(random, 4, 30)));
  const float nan_float = std::numeric_limits<float>::quiet_NaN();
  const float infinite_float = std::numeric_limits<float>::infinity();
  using Lie = std::function<void(Version1Header&)>;
  std::vector<Lie> lies;
  for (const std::uint64_t number : {huge,
                                     huge / 2 + 1,
                                     std::uint64_t{1} << 40,
                                     std::uint64_t{1} << 24,
                                     std::uint64_t{1000},
                                     std::uint64_t{0}}) {
    lies.push_back([=](Version1Header& h) { h.voxel_count = number; });
    lies.push_back([=](Version1Header& h) { h.occupancy_size = number; });
    lies.push_back([=](Version1Header& h) { h.intensity_size = number; });
    lies.push_back([=](Version1Header& h) {
      h.occupancy_size = number;
      h.intensity_size = huge - number + 1; // the sum is 0, or too large
    });
  }
  for (const int step : {-1, 1}) {
    const auto off_by_one = static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
    lies.push_back([=](Version1Header& h) { h.voxel_count += off_by_one; });
    lies.push_back([=](Version1Header& h) { h.occupancy_size += off_by_one; });
    lies.push_back([=](Version1Header& h) { h.intensity_size += off_by_one; });
    lies.push_back([=](Version1Header& h) {
      h.occupancy_size += off_by_one;
      h.intensity_size -= off_by_one;
    });
    lies.push_back(
        [=](Version1Header& h) { h.grid.depth += static_cast<unsigned>(step); });
  }
  for (const unsigned int number : {0u, 1u, 3u, 5u, 21u, 22u, 64u, 255u})
    lies.push_back([=](Version1Header& h) { h.grid.depth = number; });
  for (const double number : {0.0, -1.0, nan_value, infinity, -infinity, -0.0})
    lies.push_back([=](Version1Header& h) { h.grid.resolution = number; });
  for (const std::int32_t number :
       {INT32_MIN, INT32_MAX, -(1 << 20) - 1, (1 << 20) - 15, 1 << 20})
    lies.push_back([=](Version1Header& h) { h.grid.first_index[1] = number; });
  for (const unsigned int number : {0u, 7u, 17u, 255u})
    lies.push_back([=](Version1Header& h) { h.intensity_scale->bits = number; });
  for (const float number : {0.0f, -1.0f, nan_float, infinite_float})
    lies.push_back([=](Version1Header& h) { h.intensity_scale->step = number; });
  for (const float number : {nan_float, infinite_float, -infinite_float})
    lies.push_back([=](Version1Header& h) { h.intensity_scale->offset = number; });
  lies.push_back([](Version1Header& h) { h.intensity_scale.reset(); });
  lies.push_back([](Version1Header& h) { h.frame_id = std::string(1025, 'x'); });
  for (std::size_t i = 0; i < lies.size(); ++i) {
    SCOPED_TRACE(i);
    Parts parts = good;
    lies[i](parts.header);
    expectRefused(putTogether(parts), small_allocation, DecoderLimits());
  }
  VoxelFrame back;
  FrameDecoder decoder;
  EXPECT_EQ(decoded(decoder, putTogether(good), back), CompressionCode::Ok);
  Parts self = good;
  self.header.is_i_frame = false; // a P-frame that depends on itself
  expectRefused(putTogether(self), small_allocation, DecoderLimits());
}

/** \brief A rANS row that gives all of the range to the symbol 1, so that a few bytes
 * decode to any number of it. */
Bytes
greedyRow(std::uint64_t count)
{
  Bytes bytes{2, 1}; // rANS, symbols 0 and 1
  BitWriter bits(bytes);
  bits.gamma(1);
  bits.gamma((count < 32768 ? 1u << 12 : 1u << 14) + 1);
  bits.flush();
  for (int i = 0; i < (count < 256 ? 1 : 2); ++i)
    ByteWriter(bytes).u32(1u << 16);
  return bytes;
}

TEST(ForgedStreams, GreedyRowsAreRows)
{
  for (const std::size_t count : {100u, 1000u, 100000u}) {
    const Bytes row = greedyRow(count);
    const std::uint8_t* cursor = row.data();
    Bytes symbols;
    EXPECT_TRUE(decodeSymbols(cursor, row.data() + row.size(), count, symbols));
    EXPECT_EQ(symbols, Bytes(count, 1));
  }
}

TEST(ForgedStreams, PayloadsThatGrow)
{
  std::mt19937_64 random(2);
  FrameEncoder encoder(StreamFormat::Version1, 10);
  const Parts good = takeApart(encoded(encoder, randomFrame(random, 4, 30)));
  DecoderLimits limits;
  limits.max_voxels = 20000;
  const Bytes ones{1, 0x01};
  const Bytes all{1, 0xff};
  for (const unsigned int depth : {4u, 21u})
    for (const std::uint64_t voxels : {std::uint64_t{30}, std::uint64_t{20000}})
      for (const Bytes& section :
           {occupancy(0, huge, ones),
            occupancy(0, voxels * depth + 1, ones),
            occupancy(0, voxels * depth, ones),
            occupancy(0, voxels * depth, all),
            occupancy(0, voxels * depth, greedyRow(voxels * depth)),
            occupancy(0, 1 + 8 + 64 + 512, all),
            occupancy(1, depth, ones), // an I-frame, predicted
            occupancy(2, depth, ones), // no such prediction
            occupancy(0, 0, {}),
            Bytes{0},
            Bytes{0, 0xff, 0xff}}) {
        Parts parts = good;
        parts.header.grid.depth = depth;
        parts.header.grid.first_index.fill(-(1 << (depth - 1)));
        parts.header.voxel_count = voxels;
        parts.payload = section;
        parts.header.occupancy_size = section.size();
        parts.header.intensity_size = ones.size();
        append(ones, parts.payload);
        expectRefused(putTogether(parts), 64 * limits.max_voxels, limits);
      }
}

TEST(ForgedStreams, PayloadsThatAreNotCanonical)
{
  struct Lie {
    std::uint64_t voxels;
    unsigned int bits;
    Bytes occupancy;
    Bytes intensities;
    bool is_good;
  };
  const Bytes one = occupancy(0, 4, {1, 0x01}); // one voxel, four levels
  for (const Lie& lie : std::vector<Lie>{
           {1, 8, one, {1, 9}, true},
           {2, 8, occupancy(0, 4, {0, 0x01, 0x01, 0x01, 0x03}), {1, 9}, true},
           {2,
            8,
            occupancy(0, 5, {0, 0x03, 0x00, 0x01, 0x01, 0x03}),
            {1, 9},
            false},                              // a barren node
           {1, 8, one, {1, 9, 0}, false},        // a byte too many
           {1, 4, one, {1, 0x10}, false},        // beyond 4 bits
           {1, 12, one, {1, 9, 1, 9}, true},     // high row, low row
           {1, 12, one, {1, 0, 1, 0x10}, false}, // beyond the 4 low bits
           {1, 12, one, {1, 9}, false}}) {
    Parts parts;
    parts.header.grid.resolution = 0.1;
    parts.header.grid.depth = 4;
    parts.header.intensity_scale.emplace();
    parts.header.intensity_scale->bits = lie.bits;
    parts.header.voxel_count = lie.voxels;
    parts.header.occupancy_size = lie.occupancy.size();
    parts.header.intensity_size = lie.intensities.size();
    parts.payload = lie.occupancy;
    append(lie.intensities, parts.payload);
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder, putTogether(parts), back),
              lie.is_good ? CompressionCode::Ok : CompressionCode::Corrupt);
  }
}

TEST(ForgedStreams, MutatedFramesWithGoodChecksumsAreFramesOrRefused)
{
  std::mt19937_64 random(3);
  std::size_t accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    static Parts good;
    if (round % 200 == 0) {
      FrameEncoder encoder(StreamFormat::Version1, 10);
      const unsigned int bits = round % 400 == 0 ? 8 : 12;
      good =
          takeApart(encoded(encoder, randomFrame(random, 4, below(random, 300), bits)));
    }
    Parts parts = good;
    for (std::uint64_t i = 1 + below(random, 4); i > 0 && !parts.payload.empty(); --i) {
      const std::size_t at = below(random, parts.payload.size());
      parts.payload[below(random, 2) == 0 ? at : at % 12 % parts.payload.size()] =
          static_cast<std::uint8_t>(random());
    }
    if (below(random, 4) == 0)
      parts.header.voxel_count = below(random, 400);
    const Bytes bytes = putTogether(parts);
    FrameDecoder decoder;
    VoxelFrame back;
    memory_count.reset();
    const CompressionCode code = decoded(decoder, bytes, back);
    EXPECT_LT(memory_count.largest, std::size_t{1} << 20);
    if (code == CompressionCode::Ok) {
      ++accepted;
      ASSERT_TRUE(isConsistent(back));
      ASSERT_EQ(back.size(), parts.header.voxel_count);
    }
    else
      ASSERT_TRUE(code == CompressionCode::Corrupt ||
                  code == CompressionCode::LimitExceeded);
  }
  EXPECT_GT(accepted, 0u);
  EXPECT_LT(accepted, 20000u);
}

template <typename NumberT>
Bytes
overwritten(Bytes bytes, std::size_t at, NumberT number)
{
  std::memcpy(bytes.data() + at, &number, sizeof(number));
  return bytes;
}

TEST(ForgedStreams, PublishedFieldsThatLie)
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
    for (const std::uint64_t number : {huge,
                                       huge / 2 + 1,
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
                                infinity,
                                -infinity,
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

TEST(ForgedStreams, PublishedTreesThatAreNone)
{
  FrameEncoder encoder(StreamFormat::Published, 10);
  const Bytes empty = encoded(encoder, emptyFrame(2));
  const auto code = [&](const Bytes& nodes, std::uint64_t voxels) {
    Bytes bytes = overwritten(empty, 11, voxels);
    bytes.resize(encoder.statistics().header_bytes);
    ByteWriter writer(bytes);
    for (const Bytes& row : {nodes, Bytes(static_cast<std::size_t>(voxels), 7)}) {
      writer.u64(row.size());
      encodeStaticRange(row, bytes);
    }
    FrameDecoder decoder;
    VoxelFrame back;
    return decoded(decoder, bytes, back);
  };
  EXPECT_EQ(code({0}, 0), CompressionCode::Ok); // the empty frame
  EXPECT_EQ(code({0x03, 0x01, 0x80}, 2), CompressionCode::Ok);
  EXPECT_EQ(code({}, 0), CompressionCode::Corrupt);
  EXPECT_EQ(code({0, 0}, 0), CompressionCode::Corrupt);
  EXPECT_EQ(code({0}, 1), CompressionCode::Corrupt);
  EXPECT_EQ(code({0x03, 0x01, 0x00}, 1), CompressionCode::Corrupt); // a barren node
  EXPECT_EQ(code({0x03, 0x01}, 1), CompressionCode::Corrupt);       // a missing one
  EXPECT_EQ(code({0x01, 0x01, 0x01}, 1), CompressionCode::Corrupt); // one too many
  EXPECT_EQ(code({0x03, 0x01, 0x80}, 3), CompressionCode::Corrupt);
}

} // namespace
