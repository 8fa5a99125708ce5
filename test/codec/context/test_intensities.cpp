#include "codec/context/entropy_coder.h"
#include "codec/context/intensities.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using namespace pcl_ext::io::test;

using Numbers = std::vector<std::uint16_t>;

constexpr unsigned int grid_depth = 5;

/** \brief Ascending keys of about a quarter of the grid's voxels, in clusters. */
std::vector<std::uint64_t>
randomKeys(std::mt19937_64& random)
{
  std::set<std::uint64_t> keys;
  while (keys.size() < 8000) {
    const std::uint64_t first = below(random, 1 << 15);
    for (std::uint64_t key = first; key < first + 12 && key < 1 << 15; ++key)
      keys.insert(key);
  }
  return {keys.begin(), keys.end()};
}

BlockList
blocksOf(const std::vector<std::uint64_t>& keys)
{
  BlockList blocks;
  blocks.assign(keys);
  return blocks;
}

/** \brief Numbers of one frame after another, of the same voxels, by both directions. */
template <bool IsSmall>
class Stream {
public:
  Stream(unsigned int bits, const std::vector<std::uint64_t>& keys)
  : bits_(bits), blocks_(blocksOf(keys))
  {
    history_.clear(bits);
  }

  Bytes
  encode(Numbers numbers)
  {
    Bytes bytes;
    DecisionCoding<BinaryRangeEncoder, IsSmall> coding{BinaryRangeEncoder(bytes)};
    pass(coding, encoder_models_, numbers);
    coding.coder().finish();
    return bytes;
  }

  Numbers
  decode(const Bytes& bytes)
  {
    Numbers numbers(blocks_.voxelCount(), 7);
    DecisionCoding<BinaryRangeDecoder, IsSmall> coding{
        BinaryRangeDecoder(bytes.data(), bytes.data() + bytes.size())};
    pass(coding, decoder_models_, numbers);
    return numbers;
  }

  void
  learn(const Numbers& numbers)
  {
    history_.update(blocks_, numbers, nullptr, is_first_);
    is_first_ = false;
  }

private:
  template <typename CodingOfDirectionT>
  void
  pass(CodingOfDirectionT& coding, IntensityContexts& models, Numbers& numbers)
  {
    const FrameParameters parameters{history_, grid_depth, bits_, nullptr};
    IntensityPass(coding, models, directory_, parameters).run(blocks_, numbers);
  }

  unsigned int bits_;
  BlockList blocks_;
  BlockDirectory directory_;
  History history_;
  IntensityContexts encoder_models_{IsSmall};
  IntensityContexts decoder_models_{IsSmall};
  bool is_first_ = true;
};

/** \brief A number of a voxel of a frame. */
using Draw = std::function<std::uint32_t(std::mt19937_64&, std::size_t voxel)>;

/** \brief Bits a number, of the last of some frames; all are decoded again. */
template <bool IsSmall>
double
bitsOf(unsigned int bits, const Draw& draw, std::size_t frames)
{
  std::mt19937_64 random(7);
  const std::vector<std::uint64_t> keys = randomKeys(random);
  Stream<IsSmall> stream(bits, keys);
  std::size_t size = 0;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    Numbers numbers(keys.size());
    for (std::size_t voxel = 0; voxel < numbers.size(); ++voxel)
      numbers[voxel] = static_cast<std::uint16_t>(draw(random, voxel));
    const Bytes bytes = stream.encode(numbers);
    EXPECT_EQ(stream.decode(bytes), numbers) << bits << " bits, frame " << frame;
    stream.learn(numbers);
    size = bytes.size();
  }
  return 8.0 * static_cast<double>(size) / static_cast<double>(keys.size());
}

double
bitsOfEither(unsigned int bits, const Draw& draw, std::size_t frames = 3)
{
  return std::max(bitsOf<false>(bits, draw, frames), bitsOf<true>(bits, draw, frames));
}

TEST(ContextIntensities, RandomNumbersTakeTheirBits)
{
  for (const unsigned int bits : {1u, 2u, 5u, 8u, 9u, 12u, 16u}) {
    const auto draw = [&](std::mt19937_64& random, std::size_t) {
      return static_cast<std::uint32_t>(below(random, std::uint64_t{1} << bits));
    };
    EXPECT_LT(bitsOfEither(bits, draw), 1.06 * bits + 0.1) << bits;
  }
}

TEST(ContextIntensities, ConstantNumbersTakeNext)
{
  for (const unsigned int bits : {1u, 8u, 16u})
    for (const std::uint32_t number : {0u, 1u, (1u << bits) - 1})
      EXPECT_LT(bitsOfEither(bits, [=](auto&, std::size_t) { return number; }), 0.2)
          << bits << " bits, " << number;
}

TEST(ContextIntensities, NumbersOfAStaticSceneTakeTheBitsOfTheirNoise)
{
  // 16 values, about a mean of the voxel: 4 bits, and what the means have learnt wrongly.
  const auto draw = [](std::mt19937_64& random, std::size_t voxel) {
    return static_cast<std::uint32_t>(voxel * 2654435761u % 60000 + below(random, 16));
  };
  EXPECT_LT(bitsOfEither(16, draw, 30), 6);
}

TEST(ContextIntensities, OutliersAreCodedAfterConstantNumbers)
{
  for (const unsigned int bits : {8u, 16u}) {
    const auto draw = [&](std::mt19937_64& random, std::size_t) {
      return below(random, 100) == 0 ? (1u << bits) - 1 : 2u;
    };
    EXPECT_LT(bitsOfEither(bits, draw), 0.01 * 4 * bits + 0.2) << bits;
  }
}

TEST(ContextIntensities, AnyBytesAreNumbersOfTheSymbolsBits)
{
  std::mt19937_64 random(3);
  const std::vector<std::uint64_t> keys = randomKeys(random);
  for (const unsigned int bits : {1u, 4u, 8u, 16u})
    for (int repetition = 0; repetition < 4; ++repetition) {
      Bytes bytes(20000);
      for (std::uint8_t& byte : bytes)
        byte = repetition == 0   ? 0
               : repetition == 1 ? 255
                                 : static_cast<std::uint8_t>(random());
      Stream<false> balanced(bits, keys);
      Stream<true> small(bits, keys);
      for (int frame = 0; frame < 3; ++frame) {
        for (const Numbers& numbers : {balanced.decode(bytes), small.decode(bytes)})
          for (const std::uint16_t number : numbers)
            ASSERT_LT(number, 1u << bits);
        balanced.learn(balanced.decode(bytes));
        small.learn(small.decode(bytes));
      }
    }
}

/** \brief Index of the voxel at a position, in keys; none: -1. */
class VoxelMap {
public:
  explicit VoxelMap(const std::vector<std::uint64_t>& keys)
  {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const VoxelPosition at = voxelPosition(keys[i]);
      voxels_[{at.x, at.y, at.z}] = i;
    }
  }

  /** \brief The neighbour of a voxel, one down or up on an axis; null if there is none. */
  const std::size_t*
  neighbour(std::uint64_t key, std::size_t axis, int step) const
  {
    const VoxelPosition at = voxelPosition(key);
    std::array<std::int64_t, 3> position = {at.x, at.y, at.z};
    position[axis] += step;
    const auto found = voxels_.find(position);
    return found == voxels_.end() ? nullptr : &found->second;
  }

private:
  std::map<std::array<std::int64_t, 3>, std::size_t> voxels_;
};

TEST(ContextIntensities, NeighboursAreThoseOfTheGrid)
{
  std::mt19937_64 random(5);
  const std::vector<std::uint64_t> keys = randomKeys(random);
  const VoxelMap voxels(keys);
  Numbers numbers(keys.size());
  for (std::uint16_t& number : numbers)
    number = static_cast<std::uint16_t>(random());
  const BlockList blocks = blocksOf(keys);
  BlockDirectory directory;
  IntensityNeighbours neighbours(blocks, grid_depth - 2, directory);
  neighbours.begin();
  for (std::size_t block = 0, voxel = 0; block < blocks.size(); ++block) {
    neighbours.moveTo(block);
    for (unsigned int cell = 0; cell < 64; ++cell) {
      if ((blocks.masks[block] >> cell & 1) == 0)
        continue;
      std::uint32_t shape = 0;
      std::uint32_t sum = 0;
      std::uint32_t count = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        shape *= 3;
        shape += voxels.neighbour(keys[voxel], axis, 1) != nullptr ? 1 : 0;
        if (const std::size_t* lower = voxels.neighbour(keys[voxel], axis, -1)) {
          ++shape;
          ++count;
          sum += numbers[*lower];
        }
      }
      EXPECT_EQ(neighbours.shapeOf(cell), shape);
      EXPECT_EQ(neighbours.averageOf(cell, numbers, 99),
                count == 0 ? 99 : 16 * sum / count);
      ++voxel;
    }
  }
}

} // namespace
