#include "codec/context/entropy_coder.h"
#include "codec/context/models.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

TEST(BinaryRangeCoder, ManyShortRowsComeBack)
{
  std::mt19937_64 random(1);
  for (int round = 0; round < 50000; ++round) {
    const Kind kind = kinds[random() % 7];
    const Decisions decisions = randomDecisions(random(), random() % 24, kind);
    const Bytes bytes = encodedRow(decisions);
    Decisions back = decisions;
    ASSERT_TRUE(decodeExact(bytes, back));
    ASSERT_EQ(bitsOf(back), bitsOf(decisions));
  }
}

TEST(BinaryRangeCoder, ARowBeginsBehindTheBytesThatAreThere)
{
  // A carry must not reach the bytes before the row, nor may its zeros be taken away.
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Decisions decisions = randomDecisions(seed, seed % 40, kinds[seed % 7]);
    const Bytes alone = encodedRow(decisions);
    for (const std::uint8_t before : Bytes{0x00, 0xff}) {
      Bytes bytes{before, before};
      BinaryRangeEncoder encoder(bytes);
      for (const Decision& decision : decisions)
        encoder.code(decision.bit, decision.probability);
      encoder.finish();
      Bytes expected{before, before};
      expected.insert(expected.end(), alone.begin(), alone.end());
      ASSERT_EQ(bytes, expected);
    }
  }
}

double
entropyBits(const Decisions& decisions)
{
  double bits = 0.0;
  for (const Decision& decision : decisions) {
    const double one = decision.probability / 65536.0;
    bits -= std::log2(decision.bit ? one : 1.0 - one);
  }
  return bits;
}

TEST(BinaryRangeCoder, SizeIsTheEntropy)
{
  for (const Kind kind : kinds) {
    const Decisions decisions = randomDecisions(2, 200000, kind);
    const double entropy = entropyBits(decisions);
    const double bits = 8.0 * static_cast<double>(encodedRow(decisions).size());
    // A bit costs an interval's rounding besides, which is seen at the surest ones.
    EXPECT_LE(bits, 1.002 * entropy + 2e-4 * static_cast<double>(decisions.size()) + 16)
        << static_cast<int>(kind);
  }
  const Decisions even = randomDecisions(3, 8000, Kind::Even);
  EXPECT_GE(encodedRow(even).size(), 999u);
  EXPECT_LE(encodedRow(even).size(), 1001u);
}

TEST(BinaryRangeCoder, CertainBitsTakeNoBytes)
{
  // 0 is in the interval of ones only, and the bytes end in zeros that are not written.
  EXPECT_TRUE(encodedRow(Decisions(1000, {true, 0x8000})).empty());
  EXPECT_TRUE(encodedRow({}).empty());
  EXPECT_EQ(encodedRow({{false, 0x8000}}), Bytes{0x80});
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

TEST(BinaryRangeCoder, ZerosAreReadBehindTheEnd)
{
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Decisions decisions = randomDecisions(seed, 400, kinds[seed % 7]);
    const Bytes whole = encodedRow(decisions);
    for (std::size_t size = 0; size <= whole.size(); ++size) {
      const Bytes truncated(whole.begin(),
                            whole.begin() + static_cast<std::ptrdiff_t>(size));
      Bytes with_zeros = truncated;
      with_zeros.resize(whole.size() + 600, 0);
      Decisions back = decisions;
      Decisions expected = decisions;
      decodeExact(truncated, back);
      decodeExact(with_zeros, expected);
      ASSERT_EQ(bitsOf(back), bitsOf(expected));
    }
  }
}

TEST(BinaryRangeCoder, RandomBytesNeverReadOutOfBounds)
{
  std::mt19937_64 random(5);
  for (int round = 0; round < 20000; ++round) {
    Bytes bytes(random() % 40);
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    Decisions decisions =
        randomDecisions(random(), random() % 600, kinds[random() % 7]);
    decodeExact(bytes, decisions);
    // What was decoded is a row like any other.
    Decisions back = decisions;
    const Bytes again = encodedRow(decisions);
    decodeExact(again, back);
    ASSERT_EQ(bitsOf(back), bitsOf(decisions));
  }
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

TEST(BinaryRangeCoder, EveryFlipOfAByteChangesBitsOrNothing)
{
  // No byte is idle but in the last four, where the shortest of several numbers stands.
  const Decisions decisions = randomDecisions(7, 3000, Kind::Uniform);
  const Bytes whole = encodedRow(decisions);
  ASSERT_GT(whole.size(), 100u);
  for (std::size_t i = 0; i + 4 < whole.size(); ++i) {
    Bytes flipped = whole;
    flipped[i] = static_cast<std::uint8_t>(flipped[i] ^ 1u << i % 8);
    Decisions back = decisions;
    decodeExact(flipped, back);
    ASSERT_NE(bitsOf(back), bitsOf(decisions)) << i;
  }
}

// ---------------------------------------------------------------- adaptive bits

TEST(AdaptiveBit, BeginsEvenAndLearnsFastFirst)
{
  AdaptiveBit bit;
  EXPECT_EQ(bit.probability(), 0x8000u);
  bit.learn(true, learningShifts(5));
  EXPECT_EQ(bit.probability(), 0x8000u + (0x10000 - 48 - 0x8000) / 2);
  const std::uint32_t step = bit.probability() - 0x8000;
  const std::uint32_t before = bit.probability();
  bit.learn(true, learningShifts(5));
  EXPECT_GT(bit.probability(), before);
  EXPECT_LT(bit.probability() - before, step);
}

TEST(AdaptiveBit, StaysWithinItsLimitsAndRecovers)
{
  for (std::uint8_t shift = 4; shift <= 7; ++shift)
    for (const bool usual : {false, true}) {
      AdaptiveBit bit;
      for (int i = 0; i < 5000; ++i) {
        bit.learn(usual, learningShifts(shift));
        ASSERT_GE(bit.probability(), 48u);
        ASSERT_LE(bit.probability(), 0x10000u - 48);
      }
      EXPECT_TRUE(usual ? bit.probability() > 65000 : bit.probability() < 536)
          << bit.probability();
      for (int i = 0; i < 600; ++i)
        bit.learn(!usual, learningShifts(shift));
      EXPECT_TRUE(usual ? bit.probability() < 1500 : bit.probability() > 64036)
          << bit.probability();
    }
}

TEST(AdaptiveBit, LearnsTheShareOfOnes)
{
  for (std::uint8_t shift = 4; shift <= 7; ++shift)
    for (const double share : {0.05, 0.3, 0.5, 0.9}) {
      std::mt19937_64 random(shift);
      AdaptiveBit bit;
      double mean = 0.0;
      constexpr int rounds = 20000;
      for (int i = 0; i < rounds; ++i) {
        bit.learn(static_cast<double>(random() >> 11) * 0x1p-53 < share,
                  learningShifts(shift));
        mean += bit.probability() / 65536.0 / rounds;
      }
      EXPECT_NEAR(mean, share, 0.01) << shift;
    }
}

TEST(AdaptiveBit, HigherShiftsAdaptSlower)
{
  AdaptiveBit slow;
  AdaptiveBit fast;
  for (int i = 0; i < 200; ++i) {
    slow.learn(i % 2 == 0, learningShifts(7));
    fast.learn(i % 2 == 0, learningShifts(4));
  }
  const std::uint32_t slow_before = slow.probability();
  const std::uint32_t fast_before = fast.probability();
  slow.learn(true, learningShifts(7));
  fast.learn(true, learningShifts(4));
  EXPECT_LT(slow.probability() - slow_before, (fast.probability() - fast_before) / 4);
}

} // namespace
