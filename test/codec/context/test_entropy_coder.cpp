// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/context/entropy_coder.h"
#include "codec/context/models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using Bytes = std::vector<std::uint8_t>;

struct Decision {
  bool bit;
  std::uint32_t probability; // of a 1, in 2^-16
};
using Decisions = std::vector<Decision>;

/** \brief How probabilities are drawn, and whether bits follow them. */
enum class Kind { Even, Uniform, Rare, Extreme, Contrary, SurelyOne, SurelyZero };
constexpr Kind kinds[] = {Kind::Even,
                          Kind::Uniform,
                          Kind::Rare,
                          Kind::Extreme,
                          Kind::Contrary,
                          Kind::SurelyOne,
                          Kind::SurelyZero};

std::uint32_t
drawProbability(std::mt19937_64& random, Kind kind)
{
  const auto draw = static_cast<std::uint32_t>(random() & 0xffff);
  const std::uint32_t uniform = std::max(draw, 1u);
  switch (kind) {
  case Kind::Even:
    return 0x8000;
  case Kind::Rare:
    return 1 + uniform % 300;
  case Kind::Extreme:
  case Kind::Contrary:
    return (draw & 1) != 0 ? 1 : 0xffff;
  case Kind::SurelyOne:
    return 0xffff;
  case Kind::SurelyZero:
    return 1;
  default:
    return uniform;
  }
}

Decisions
randomDecisions(std::uint64_t seed, std::size_t count, Kind kind)
{
  std::mt19937_64 random(seed);
  Decisions decisions(count);
  for (Decision& decision : decisions) {
    decision.probability = drawProbability(random, kind);
    decision.bit = (random() & 0xffff) < decision.probability;
    if (kind == Kind::Contrary)
      decision.bit = !decision.bit;
  }
  return decisions;
}

Bytes
encodedRow(const Decisions& decisions)
{
  Bytes bytes;
  BinaryRangeEncoder encoder(bytes);
  for (const Decision& decision : decisions)
    EXPECT_EQ(encoder.code(decision.bit, decision.probability), decision.bit);
  encoder.finish();
  return bytes;
}

/** \brief Decodes from memory of exactly that size, so that a sanitizer sees every read
 * after it.
 * \param[in,out] decisions probabilities; their bits are what was decoded
 * \return true if no byte was left over
 */
bool
decodeExact(const Bytes& bytes, Decisions& decisions)
{
  const std::unique_ptr<std::uint8_t[]> copy(new std::uint8_t[bytes.size()]);
  std::copy(bytes.begin(), bytes.end(), copy.get());
  BinaryRangeDecoder decoder(copy.get(), copy.get() + bytes.size());
  for (Decision& decision : decisions)
    decision.bit = decoder.code(false, decision.probability);
  return decoder.isAtEnd();
}

std::string
bitsOf(const Decisions& decisions)
{
  std::string bits;
  for (const Decision& decision : decisions)
    bits += decision.bit ? '1' : '0';
  return bits;
}

TEST(BinaryRangeCoder, BitsComeBackAndAllBytesAreRead)
{
  for (const Kind kind : kinds)
    for (const std::size_t count : {0u, 1u, 2u, 7u, 8u, 31u, 32u, 33u, 1000u, 50000u}) {
      const Decisions decisions = randomDecisions(count, count, kind);
      const Bytes bytes = encodedRow(decisions);
      Decisions back = decisions;
      ASSERT_TRUE(decodeExact(bytes, back));
      ASSERT_EQ(bitsOf(back), bitsOf(decisions))
          << "kind " << static_cast<int>(kind) << ", " << count << " bits";
    }
}

TEST(BinaryRangeCoder, BothSidesCountTheBytesThatAreSettled)
{
  for (const Kind kind : kinds) {
    const Decisions decisions = randomDecisions(4, 3000, kind);
    std::vector<std::size_t> settled;
    Bytes bytes{1, 2, 3};
    BinaryRangeEncoder encoder(bytes);
    for (const Decision& decision : decisions) {
      encoder.code(decision.bit, decision.probability);
      settled.push_back(encoder.settledBytes());
    }
    encoder.finish();
    BinaryRangeDecoder decoder(bytes.data() + 3, bytes.data() + bytes.size());
    for (std::size_t i = 0; i < decisions.size(); ++i) {
      decoder.code(false, decisions[i].probability);
      ASSERT_EQ(decoder.settledBytes(), settled[i]);
    }
  }
}

TEST(BinaryRangeCoder, CarriesRunThroughWrittenBytes)
{
  // The bits that decode from 7f ff ff .. lie about 80 00 00 .., which is the shorter
  // number: the encoder has written the ff when it decides for that one.
  std::size_t carries = 0;
  for (std::size_t length = 1; length <= 40; ++length)
    for (const std::uint8_t first : Bytes{0x00, 0x12, 0x7f, 0xfe})
      for (const Kind kind : {Kind::Even, Kind::Uniform, Kind::Rare}) {
        Bytes number(length, 0xff);
        number.insert(number.begin(), first);
        Decisions decisions = randomDecisions(length, 8 * length, kind);
        decodeExact(number, decisions);
        Bytes bytes;
        BinaryRangeEncoder encoder(bytes);
        std::size_t last_row_of_ff = 0;
        for (const Decision& decision : decisions) {
          encoder.code(decision.bit, decision.probability);
          if (bytes.size() > 2 && bytes[0] == first &&
              std::all_of(bytes.begin() + 1, bytes.end(), [](std::uint8_t byte) {
                return byte == 0xff;
              }))
            last_row_of_ff = bytes.size();
        }
        encoder.finish();
        carries += last_row_of_ff > 2 && bytes[0] == first + 1 ? 1 : 0;
        Decisions back = decisions;
        ASSERT_TRUE(decodeExact(bytes, back));
        ASSERT_EQ(bitsOf(back), bitsOf(decisions));
      }
  EXPECT_GE(carries, 20u);
}

TEST(BinaryRangeCoder, BytesBehindARowAreDetected)
{
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const Decisions decisions = randomDecisions(seed, seed, kinds[seed % 7]);
    Bytes bytes = encodedRow(decisions);
    // The decoder looks four bytes ahead, of which the row's zeros are part.
    bytes.insert(bytes.end(), 40, 0x5a);
    Decisions back = decisions;
    ASSERT_FALSE(decodeExact(bytes, back));
  }
}

} // namespace
