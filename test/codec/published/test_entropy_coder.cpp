// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/byte_source.h"
#include "codec/published/entropy_coder.h"

// PCL's implementation header relies on its declarations standing before it.
// clang-format off
#include <pcl/compression/entropy_range_coder.h>
// clang-format on

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::published;
using Bytes = std::vector<std::uint8_t>;
using Failure = ByteSource::Failure;

/** \brief Symbols below `alphabet`; the higher the skew the rarer the high ones. */
Bytes
randomRow(std::uint64_t seed, std::size_t count, unsigned int alphabet, double skew)
{
  std::mt19937_64 random(seed);
  Bytes row(count);
  for (std::uint8_t& symbol : row) {
    const double uniform = static_cast<double>(random() >> 11) * 0x1p-53;
    symbol = static_cast<std::uint8_t>(std::pow(uniform, skew) * alphabet);
  }
  return row;
}

std::vector<Bytes>
rows()
{
  std::vector<Bytes> rows{{}, {0}, {255}, {7, 7}, {7, 8}, {0, 255}};
  Bytes all(256);
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = static_cast<std::uint8_t>(i);
  rows.push_back(all);
  for (int i = 0; i < 9; ++i)
    rows.back().insert(rows.back().end(), all.begin(), all.end());
  rows.push_back(all);
  rows.emplace_back(65281, std::uint8_t{255}); // the smallest table of those scaled
  for (const std::size_t count : {2u,
                                  254u,
                                  255u,
                                  256u,
                                  257u,
                                  4096u,
                                  32767u,
                                  32768u,
                                  65279u,
                                  65280u,
                                  65281u,
                                  65536u,
                                  70001u,
                                  200000u}) {
    rows.emplace_back(count, std::uint8_t{42});
    Bytes skewed(count, 3);
    skewed[count / 2] = 200;
    rows.push_back(skewed);
    for (const double skew : {1.0, 3.0, 20.0})
      for (const unsigned int alphabet : {2u, 24u, 256u})
        rows.push_back(randomRow(count + alphabet, count, alphabet, skew));
  }
  return rows;
}

std::string
codedByPcl(const Bytes& row)
{
  const std::vector<char> symbols(row.begin(), row.end());
  std::ostringstream stream(std::ios::binary);
  pcl::StaticRangeCoder coder;
  coder.encodeCharVectorToStream(symbols, stream);
  return stream.str();
}

bool
decodesRange(const Bytes& bytes, std::size_t count, Bytes& symbols, Failure& failure)
{
  MemoryBuffer buffer(bytes.data(), bytes.size());
  ByteSource source(buffer, bytes.size() + 1);
  const bool good = decodeStaticRange(source, count, symbols);
  failure = source.failure();
  EXPECT_TRUE(!good || source.consumed() == bytes.size());
  return good;
}

TEST(StaticRangeCoder, BytesAreThoseOfPcl)
{
  for (const Bytes& row : rows()) {
    Bytes bytes;
    encodeStaticRange(row, bytes);
    const std::string expected = codedByPcl(row);
    ASSERT_EQ(std::string(bytes.begin(), bytes.end()), expected) << row.size();
    Bytes symbols{1, 2, 3}; // which do not stay
    Failure failure;
    ASSERT_TRUE(decodesRange(bytes, row.size(), symbols, failure)) << row.size();
    ASSERT_EQ(symbols, row);
  }
}

void
setEntry(std::size_t index, std::uint32_t value, Bytes& bytes)
{
  for (std::size_t i = 0; i < 4; ++i)
    bytes[4 * index + i] = static_cast<std::uint8_t>(value >> 8 * i);
}

TEST(StaticRangeCoder, CorruptTablesAreRefused)
{
  const Bytes row = randomRow(6, 50, 256, 2.0);
  Bytes good;
  encodeStaticRange(row, good);
  Bytes symbols;
  Failure failure;
  ASSERT_TRUE(decodesRange(good, row.size(), symbols, failure));

  std::vector<Bytes> tables(6, good);
  for (std::size_t i = 0; i <= 256; ++i)
    setEntry(i, 0, tables[0]);          // a total of zero
  setEntry(100, 0, tables[1]);          // not ascending
  setEntry(256, 1u << 16, tables[2]);   // the total too large for the range
  setEntry(256, 0xffffffff, tables[3]); // by far
  setEntry(0, 1, tables[4]);            // does not begin at 0
  for (std::size_t i = 0; i <= 256; ++i)
    setEntry(i, static_cast<std::uint32_t>(2 * i), tables[5]); // of other symbols
  for (const Bytes& bytes : tables) {
    EXPECT_FALSE(decodesRange(bytes, row.size(), symbols, failure));
    EXPECT_TRUE(failure == Failure::None || bytes == tables.back());
  }
}

TEST(StaticRangeCoder, CountsThatContradictTheTableAreRefusedEarly)
{
  constexpr std::size_t table_size = 257 * 4;
  const auto consumed = [](const Bytes& bytes, std::size_t count) {
    MemoryBuffer buffer(bytes.data(), bytes.size());
    ByteSource source(buffer, bytes.size() + 1);
    Bytes symbols;
    EXPECT_FALSE(decodeStaticRange(source, count, symbols));
    EXPECT_EQ(source.failure(), Failure::None);
    EXPECT_TRUE(symbols.empty());
    return source.consumed();
  };
  for (const Bytes& row : {Bytes{},
                           Bytes{3},
                           Bytes{3, 3},
                           Bytes(30, 9),
                           randomRow(8, 300, 3, 1.0),
                           randomRow(9, 30000, 200, 2.0)}) {
    Bytes bytes;
    encodeStaticRange(row, bytes);
    const std::size_t seen = std::set<std::uint8_t>(row.begin(), row.end()).size();
    const std::size_t total = row.size() + 256 - seen;
    std::vector<std::size_t> counts{
        total + 1, 2 * total, 65281, std::numeric_limits<std::size_t>::max()};
    std::size_t certain = 0; // occurrences of symbols that occur twice or more
    for (const std::uint8_t symbol : std::set<std::uint8_t>(row.begin(), row.end())) {
      const auto count = std::count(row.begin(), row.end(), symbol);
      certain += count > 1 ? static_cast<std::size_t>(count) : 0;
    }
    if (certain > 0) {
      counts.push_back(certain - 1);
      counts.push_back(0);
    }
    for (const std::size_t count : counts)
      EXPECT_EQ(consumed(bytes, count), table_size) << row.size() << ", " << count;
  }
  // A scaled table bounds the count, too.
  Bytes bytes;
  encodeStaticRange(Bytes(65281, 255), bytes);
  EXPECT_EQ(consumed(bytes, 65280), table_size);
}

} // namespace
