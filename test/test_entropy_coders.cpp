#include "compression/bit_io.h"
#include "compression/byte_source.h"
#include "compression/memory_buffer.h"
#include "compression/static_range_coder.h"
#include "compression/static_rans.h"

// PCL's implementation header relies on its declarations standing before it.
// clang-format off
#include <pcl/compression/entropy_range_coder.h>
#include <pcl/io/impl/entropy_range_coder.hpp>
// clang-format on

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
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

/** \brief Rows that a coder might stumble over. */
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

// ---------------------------------------------------------------- rANS symbol rows

TEST(StaticRans, RowsComeBackAndTheCursorStopsBehindThem)
{
  for (const Bytes& row : rows()) {
    Bytes bytes{9};
    encodeSymbols(row, bytes);
    const std::size_t row_end = bytes.size();
    bytes.push_back(77);
    const std::uint8_t* cursor = bytes.data() + 1;
    Bytes decoded;
    ASSERT_TRUE(
        decodeSymbols(cursor, bytes.data() + bytes.size(), row.size(), decoded));
    EXPECT_EQ(decoded, row);
    EXPECT_EQ(cursor - bytes.data(), static_cast<std::ptrdiff_t>(row_end));
    EXPECT_EQ(bytes[0], 9);
  }
}

/** \brief Bits of a table of gamma codes, one a symbol up to the last that occurs. */
double
tableBits(const Bytes& row)
{
  std::array<double, 256> share{};
  for (const std::uint8_t symbol : row)
    share[symbol] += 1.0 / static_cast<double>(row.size());
  const double total = row.size() < 32768 ? 4096.0 : 16384.0;
  double bits = 8.0;
  for (unsigned int s = 0; s <= *std::max_element(row.begin(), row.end()); ++s)
    bits += share[s] > 0.0 ? 2.0 * std::floor(std::log2(share[s] * total + 2.0)) + 1.0
                           : 1.0;
  return bits;
}

TEST(StaticRans, SizeIsThatOfAnOrderZeroCoder)
{
  for (const Bytes& row : rows()) {
    Bytes bytes;
    encodeSymbols(row, bytes);
    if (row.empty()) {
      EXPECT_TRUE(bytes.empty());
      continue;
    }
    const double bits = 8.0 * static_cast<double>(bytes.size());
    // One byte for the kind of row, two states of four bytes, and half a percent.
    EXPECT_LE(bits, 1.005 * orderZeroBits(row) + tableBits(row) + 8.0 * (1 + 8 + 1));
    EXPECT_LE(bytes.size(), row.size() + 1);
    EXPECT_GE(bits, orderZeroBits(row));
  }
}

TEST(StaticRans, SmallRowsTakeTheBytesOfTheFormat)
{
  Bytes bytes;
  encodeSymbols(Bytes(100000, 17), bytes);
  EXPECT_EQ(bytes, (Bytes{1, 17}));
  bytes.clear();
  encodeSymbols({1, 2, 3}, bytes);
  EXPECT_EQ(bytes, (Bytes{0, 1, 2, 3}));
}

/** \brief A rANS row read as the format has it, step by step. */
Bytes
decodedByHand(const Bytes& bytes, std::size_t count)
{
  BitReader bits(bytes.data() + 2, bytes.data() + bytes.size());
  std::vector<std::uint32_t> ends; // of the symbols' shares
  for (unsigned int symbol = 0; symbol <= bytes[1]; ++symbol)
    ends.push_back((ends.empty() ? 0 : ends.back()) + bits.gamma() - 1);
  const std::uint32_t total = count < 32768 ? 4096 : 16384;
  EXPECT_EQ(ends.back(), total);
  const std::uint8_t* cursor = bits.position();
  const auto word = [&cursor] {
    cursor += 2;
    return static_cast<std::uint32_t>(cursor[-2] | cursor[-1] << 8);
  };
  std::vector<std::uint32_t> states(count < 256 ? 1 : 2);
  for (std::uint32_t& state : states) {
    state = word();
    state |= word() << 16;
  }
  Bytes symbols;
  while (symbols.size() < count) {
    std::uint32_t& state = states[symbols.size() % states.size()];
    const std::uint32_t slot = state % total;
    const auto end = std::upper_bound(ends.begin(), ends.end(), slot);
    const std::uint32_t begin = end == ends.begin() ? 0 : *(end - 1);
    symbols.push_back(static_cast<std::uint8_t>(end - ends.begin()));
    state = (*end - begin) * (state / total) + slot - begin;
    if (state < 65536)
      state = state << 16 | word();
  }
  EXPECT_EQ(cursor, bytes.data() + bytes.size());
  return symbols;
}

TEST(StaticRans, RowsAreWhatTheFormatSays)
{
  for (const std::size_t count : {100u, 255u, 256u, 32767u, 32768u, 32769u}) {
    const Bytes row = randomRow(count, count, 20, 3.0);
    Bytes bytes;
    encodeSymbols(row, bytes);
    ASSERT_EQ(bytes[0], 2);
    EXPECT_EQ(decodedByHand(bytes, count), row);
  }
}

TEST(StaticRans, OrderZeroBitsAreShannons)
{
  EXPECT_DOUBLE_EQ(orderZeroBits({}), 0.0);
  EXPECT_DOUBLE_EQ(orderZeroBits(Bytes(50, 1)), 0.0);
  EXPECT_DOUBLE_EQ(orderZeroBits({1, 2, 1, 2}), 4.0);
  EXPECT_DOUBLE_EQ(orderZeroBits({1, 1, 1, 2}), 4.0 * 2.0 - 3.0 * std::log2(3.0));
}

/** \brief Decodes from memory of exactly that size, so that a sanitizer sees every read
 * behind it, and checks what a failure and a success must keep to. */
bool
decodesExact(const Bytes& bytes, std::size_t count, Bytes& symbols)
{
  const std::unique_ptr<std::uint8_t[]> copy(new std::uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), copy.get());
  const std::uint8_t* cursor = copy.get();
  const std::uint8_t* end = cursor + bytes.size();
  const bool good = decodeSymbols(cursor, end, count, symbols);
  EXPECT_LE(cursor, end);
  EXPECT_TRUE(!good || symbols.size() == count);
  return good;
}

TEST(StaticRans, TruncatedRowsAreRefused)
{
  for (const Bytes& row : {Bytes{5},
                           Bytes(40, 6),
                           randomRow(1, 40, 256, 1.0),
                           randomRow(2, 255, 9, 3.0),
                           randomRow(3, 256, 9, 3.0),
                           randomRow(4, 600, 256, 2.0)}) {
    Bytes bytes;
    encodeSymbols(row, bytes);
    while (!bytes.empty()) {
      bytes.pop_back();
      Bytes symbols;
      EXPECT_FALSE(decodesExact(bytes, row.size(), symbols)) << bytes.size();
    }
  }
}

TEST(StaticRans, FlippedBitsNeverReadOutOfBounds)
{
  for (const Bytes& row : {Bytes(40, 6),
                           randomRow(1, 40, 256, 1.0),
                           randomRow(2, 255, 9, 3.0),
                           randomRow(3, 256, 9, 3.0),
                           randomRow(4, 600, 256, 9.0)}) {
    Bytes bytes;
    encodeSymbols(row, bytes);
    std::size_t refused = 0;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      Bytes flipped = bytes;
      flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ 1u << bit % 8);
      Bytes symbols;
      refused += decodesExact(flipped, row.size(), symbols) ? 0 : 1;
    }
    // Raw and constant rows hold nothing that could contradict itself. Of a rANS row
    // the bits that fill up its table are free, and symbols of equal frequency may
    // trade places; that is why frames have a checksum.
    EXPECT_GE(refused, bytes[0] == 2 ? 8 * bytes.size() * 97 / 100 : 0);
  }
}

TEST(StaticRans, RandomBytesNeverReadOutOfBounds)
{
  std::mt19937_64 random(5);
  std::size_t refused = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(random() % 64);
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random() & random());
    if (!bytes.empty() && i % 2 == 0)
      bytes[0] = 2;
    Bytes symbols;
    refused += decodesExact(bytes, 1 + random() % 1000, symbols) ? 0 : 1;
  }
  EXPECT_GT(refused, 10000u);
}

// ---------------------------------------------------------------- PCL's range coder

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
    Bytes symbols;
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

TEST(StaticRangeCoder, FlipsTruncationsAndWrongCountsAreRefused)
{
  for (const Bytes& row :
       {Bytes{}, Bytes{3}, Bytes(30, 9), randomRow(7, 60, 256, 2.0)}) {
    Bytes bytes;
    encodeStaticRange(row, bytes);
    Bytes symbols;
    Failure failure;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      Bytes flipped = bytes;
      flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ 1u << bit % 8);
      EXPECT_FALSE(decodesRange(flipped, row.size(), symbols, failure)) << bit;
    }
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Bytes truncated(bytes.begin(),
                            bytes.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(decodesRange(truncated, row.size(), symbols, failure)) << size;
      EXPECT_EQ(failure, Failure::EndOfInput);
    }
    EXPECT_FALSE(decodesRange(bytes, row.size() + 1, symbols, failure));
    if (!row.empty()) {
      EXPECT_FALSE(decodesRange(bytes, row.size() - 1, symbols, failure));
    }
  }
}

} // namespace
