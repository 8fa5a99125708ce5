// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"
#include "bytes/checksum.h"
#include "stream/version1_header.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using Bytes = std::vector<std::uint8_t>;
using Failure = ByteSource::Failure;

Bytes
randomBytes(std::uint64_t seed, std::size_t count)
{
  std::mt19937_64 random(seed);
  Bytes bytes(count);
  for (std::uint8_t& byte : bytes)
    byte = static_cast<std::uint8_t>(random());
  return bytes;
}

TEST(ByteWriter, NumbersAreLittleEndian)
{
  Bytes bytes;
  ByteWriter writer(bytes);
  writer.u8(0xab);
  writer.u16(0x0102);
  writer.u32(0x03040506);
  writer.i32(-2);
  writer.u64(0x0708090a0b0c0d0e);
  writer.f32(1.0f);
  writer.f64(-2.0);
  writer.raw("xy", 2);
  const Bytes expected{0xab, 2,  1,  6,  5,  4, 3, 0xfe, 0xff, 0xff, 0xff,
                       14,   13, 12, 11, 10, 9, 8, 7,    0,    0,    0x80,
                       0x3f, 0,  0,  0,  0,  0, 0, 0,    0xc0, 'x',  'y'};
  EXPECT_EQ(bytes, expected);

  MemoryBuffer buffer(bytes.data(), bytes.size());
  ByteSource source(buffer, bytes.size());
  EXPECT_EQ(source.u8(), 0xab);
  EXPECT_EQ(source.u8(), 0x02);
  EXPECT_EQ(source.u8(), 0x01);
  EXPECT_EQ(source.u32(), 0x03040506u);
  EXPECT_EQ(source.i32(), -2);
  EXPECT_EQ(source.u64(), 0x0708090a0b0c0d0eu);
  EXPECT_EQ(source.f32(), 1.0f);
  EXPECT_EQ(source.f64(), -2.0);
  EXPECT_EQ(source.consumed(), bytes.size() - 2);
  EXPECT_EQ(source.failure(), Failure::None);
}

constexpr std::uint64_t no_varint = std::numeric_limits<std::uint64_t>::max();

std::uint64_t
readVarint(const Bytes& bytes, std::size_t consumed, Failure failure = Failure::None)
{
  MemoryBuffer buffer(bytes.data(), bytes.size());
  ByteSource source(buffer, 100);
  const std::uint64_t number = source.varint();
  EXPECT_EQ(source.consumed(), consumed);
  EXPECT_EQ(source.failure(), failure);
  return number;
}

TEST(ByteSource, Varints)
{
  std::vector<std::uint64_t> numbers{0, 1, 127, 128, 300, 16383, 16384, no_varint - 1};
  for (unsigned int bit = 0; bit < 64; ++bit)
    for (const std::uint64_t near : {0, 1})
      numbers.push_back((std::uint64_t{1} << bit) - near);
  for (const std::uint64_t number : numbers) {
    Bytes bytes;
    ByteWriter(bytes).varint(number);
    EXPECT_EQ(readVarint(bytes, bytes.size()), number);
    std::size_t size = 1;
    for (std::uint64_t rest = number >> 7; rest != 0; rest >>= 7)
      ++size;
    EXPECT_EQ(bytes.size(), size);
  }
  Bytes bytes;
  ByteWriter(bytes).varint(300);
  EXPECT_EQ(bytes, (Bytes{0xac, 0x02}));
}

TEST(ByteSource, InvalidVarints)
{
  EXPECT_EQ(readVarint({0x80, 0x00}, 2), no_varint); // a needless last byte
  EXPECT_EQ(readVarint({0xff, 0x80, 0x00}, 3), no_varint);
  Bytes bytes(9, 0xff);
  bytes.push_back(0x02); // a 65th bit
  EXPECT_EQ(readVarint(bytes, 10), no_varint);
  bytes.back() = 0x81; // an eleventh byte
  bytes.push_back(0x00);
  EXPECT_EQ(readVarint(bytes, 10), no_varint);
  readVarint({0x80}, 1, Failure::EndOfInput);
  readVarint({}, 0, Failure::EndOfInput);
}

TEST(ByteSource, SkipsUpToItsLimit)
{
  const Bytes bytes{1, 2, 3, 4, 5};
  for (const std::size_t size : {3, 4}) {
    MemoryBuffer buffer(bytes.data(), bytes.size());
    ByteSource source(buffer, 3);
    source.skip(size);
    EXPECT_EQ(source.failure(), size == 3 ? Failure::None : Failure::LimitExceeded);
    EXPECT_EQ(source.consumed(), size == 3 ? 3u : 0u);
    EXPECT_EQ(buffer.sgetc(), size == 3 ? 4 : 1);
  }
}

TEST(ByteSource, ErrorsStickAndNothingIsReadBehindALimit)
{
  const Bytes bytes{1, 2, 3, 4, 5};
  MemoryBuffer buffer(bytes.data(), bytes.size());
  ByteSource source(buffer, 3);
  Bytes record;
  source.recordTo(&record);
  EXPECT_EQ(source.u8(), 1);
  Bytes read;
  source.read(3, read);
  EXPECT_EQ(source.failure(), Failure::LimitExceeded);
  EXPECT_TRUE(read.empty());
  EXPECT_EQ(source.u8(), 0);
  EXPECT_EQ(source.u64(), 0u);
  EXPECT_EQ(source.consumed(), 1u);
  EXPECT_EQ(record, (Bytes{1}));
  EXPECT_EQ(buffer.sgetc(), 2);

  ByteSource rest(buffer, 10);
  rest.read(0, read);
  EXPECT_EQ(rest.failure(), Failure::None);
  rest.recordTo(&read); // what is read is not recorded twice
  rest.read(2, read);
  EXPECT_EQ(read, (Bytes{2, 3}));
  EXPECT_EQ(rest.u32(), 4u | 5u << 8); // zeros past the end
  EXPECT_EQ(rest.failure(), Failure::EndOfInput);
  EXPECT_EQ(rest.consumed(), 4u);
}

TEST(ByteSource, ReadsInStepsWhatArrives)
{
  const Bytes bytes = randomBytes(8, 200000);
  MemoryBuffer buffer(bytes.data(), bytes.size());
  ByteSource source(buffer, std::size_t{1} << 30);
  Bytes read;
  Bytes record;
  source.recordTo(&record);
  source.read(std::size_t{1} << 29, read);
  EXPECT_EQ(source.failure(), Failure::EndOfInput);
  EXPECT_EQ(read, bytes);
  EXPECT_EQ(record, bytes);
  EXPECT_LT(read.capacity(), std::size_t{1} << 20);
}

/** \brief CRC-32 (ISO-HDLC) a bit at a time, as its definition has it. */
std::uint32_t
bitwiseCrc(const std::vector<std::uint8_t>& bytes)
{
  std::uint32_t remainder = 0xffffffff;
  for (const std::uint8_t byte : bytes) {
    remainder ^= byte;
    for (int bit = 0; bit < 8; ++bit)
      remainder = remainder >> 1 ^ ((remainder & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~remainder;
}

TEST(ChainedChecksum, IsCrc32OverTheReferenceAndTheBytes)
{
  const std::string digits = "123456789";
  ASSERT_EQ(bitwiseCrc(Bytes(digits.begin(), digits.end())), 0xcbf43926u);
  // "1234" as the reference's checksum, the rest as bytes.
  const Bytes rest(digits.begin() + 4, digits.end());
  EXPECT_EQ(chainedChecksum(0x34333231, rest.data(), rest.size()), 0xcbf43926u);

  for (const std::size_t count : {0u, 1u, 3u, 1000u}) {
    const Bytes row = randomBytes(9, count);
    Bytes checked{0x78, 0x56, 0x34, 0x12};
    checked.insert(checked.end(), row.begin(), row.end());
    EXPECT_EQ(chainedChecksum(0x12345678, row.data(), row.size()), bitwiseCrc(checked));
  }
}

} // namespace
