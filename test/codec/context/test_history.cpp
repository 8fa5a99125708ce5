#include "codec/context/history.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::context;
using namespace pcl_ext::io::test;

/** \brief floor(number / 2^shift), without a shift of what is negative. */
int
floorShift(int number, int shift)
{
  return static_cast<int>(std::floor(number / std::exp2(shift)));
}

/** \brief The history as the specification has it: a map from voxels to what is known of
 * them, and one from blocks to their activity. */
class SimpleHistory {
public:
  struct Record {
    int probability;
    int recent;
    int age;
    int mean;
    int deviation;
    int depth_offset;
    int roughness;
  };

  std::map<std::uint64_t, Record> records;
  std::map<std::uint64_t, int> activity;
  std::map<std::uint64_t, std::uint64_t> last; // cells of the last frame, by block
  int fraction_bits = 4;

  void
  clear(unsigned int symbol_bits)
  {
    records.clear();
    activity.clear();
    last.clear();
    fraction_bits = std::min(4, 16 - static_cast<int>(symbol_bits));
  }

  void
  update(const VoxelFrame& frame, const DepthObservations* depths, bool is_i_frame)
  {
    std::map<std::uint64_t, std::size_t> voxels;
    for (std::size_t i = 0; i < frame.size(); ++i)
      voxels[frame.keys[i]] = i;
    std::map<std::uint64_t, int> new_voxels; // by block
    for (const auto& [key, voxel] : voxels)
      new_voxels[key / block_cells] += records.count(key) == 0 && !is_i_frame ? 1 : 0;
    for (const auto& block : new_voxels)
      activity.emplace(block.first, is_i_frame ? 0 : 2);
    for (auto& [block, value] : activity) {
      const auto added = new_voxels.find(block);
      const int count = added == new_voxels.end() ? 0 : std::min(added->second, 7);
      value = std::min((3 * value + 2 * count + 2) / 4, 7);
    }

    last.clear();
    std::map<std::uint64_t, Record> next;
    for (auto [key, record] : records) {
      const auto found = voxels.find(key);
      age(record, found != voxels.end());
      if (found != voxels.end())
        learn(record, frame.intensities[found->second], depths, found->second);
      if (record.probability >= 1000)
        next[key] = record;
    }
    for (const auto& [key, voxel] : voxels) {
      last[key / block_cells] |= std::uint64_t{1} << key % block_cells;
      if (records.count(key) == 0)
        next[key] = first(frame.intensities[voxel], depths, voxel, is_i_frame);
    }
    records = next;
    for (auto block = activity.begin(); block != activity.end();) {
      const auto lowest = records.lower_bound(block->first * block_cells);
      const bool is_tracked =
          lowest != records.end() && lowest->first / block_cells == block->first;
      block = is_tracked ? std::next(block) : activity.erase(block);
    }
  }

private:
  Record
  first(int number, const DepthObservations* depths, std::size_t voxel, bool is_i_frame)
  {
    const int value = number * (1 << fraction_bits);
    return {is_i_frame ? 52000 : 26000,
            1,
            0,
            value,
            std::max(1 << fraction_bits, value / 4),
            depths != nullptr ? depths->offsets[voxel] : 0,
            depths != nullptr ? 16 * depths->residuals[voxel] : 0};
  }

  static void
  age(Record& record, bool is_occupied)
  {
    const int divisor = record.age < 2    ? 2
                        : record.age < 5  ? 4
                        : record.age < 10 ? 8
                                          : 16;
    record.probability += is_occupied ? (65535 - record.probability) / divisor
                                      : -(record.probability / divisor);
    record.recent = (2 * record.recent + (is_occupied ? 1 : 0)) % 256;
    record.age = std::min(record.age + 1, 31);
  }

  void
  learn(Record& record, int number, const DepthObservations* depths, std::size_t voxel)
  {
    const int value = number * (1 << fraction_bits);
    const int distance = std::abs(value - record.mean);
    record.deviation += floorShift(distance - record.deviation, 2);
    record.mean += floorShift(value - record.mean, 2);
    if (depths == nullptr)
      return;
    record.depth_offset += floorShift(depths->offsets[voxel] - record.depth_offset, 2);
    record.roughness += floorShift(16 * depths->residuals[voxel] - record.roughness, 2);
  }
};

void
expectSame(const History& history, const SimpleHistory& simple)
{
  ASSERT_EQ(history.recordCount(), simple.records.size());
  ASSERT_EQ(history.blocks().size(), simple.activity.size());
  EXPECT_EQ(static_cast<int>(history.fractionBits()), simple.fraction_bits);
  auto expected = simple.records.begin();
  auto activity = simple.activity.begin();
  std::size_t record = 0;
  for (const HistoryBlock& block : history.blocks()) {
    ASSERT_EQ(block.key, activity->first);
    ASSERT_EQ(block.activity, activity->second);
    ASSERT_EQ(block.first_record, record);
    ASSERT_NE(block.tracked, 0u);
    const auto last = simple.last.find(block.key);
    ASSERT_EQ(block.last, last == simple.last.end() ? 0 : last->second);
    ++activity;
    for (std::uint64_t cells = block.tracked; cells != 0; cells &= cells - 1) {
      const SimpleHistory::Record& other = expected->second;
      ASSERT_EQ(block.key << block_key_bits | pcl_ext::lowestBit(cells),
                expected->first);
      ASSERT_EQ(history.records()[record].probability, other.probability);
      ASSERT_EQ(history.records()[record].recent, other.recent);
      ASSERT_EQ(history.records()[record].age, other.age);
      ASSERT_EQ(history.records()[record].mean, other.mean);
      ASSERT_EQ(history.records()[record].deviation, other.deviation);
      ASSERT_EQ(history.depthRecord(record).offset, other.depth_offset);
      ASSERT_EQ(history.depthRecord(record).roughness, other.roughness);
      ++expected;
      ++record;
    }
  }
}

DepthObservations
randomDepths(std::mt19937_64& random, std::size_t count)
{
  DepthObservations depths;
  for (std::size_t i = 0; i < count; ++i) {
    depths.offsets.push_back(
        static_cast<std::int16_t>(static_cast<int>(below(random, 16385)) - 8192));
    depths.residuals.push_back(static_cast<std::uint8_t>(below(random, 16)));
  }
  return depths;
}

/** \brief Both histories, fed with the same frames. */
struct Histories {
  History history;
  SimpleHistory simple;
  BlockList blocks;

  void
  clear(unsigned int symbol_bits)
  {
    history.clear(symbol_bits);
    simple.clear(symbol_bits);
  }

  void
  update(const VoxelFrame& frame, const DepthObservations* depths, bool is_i_frame)
  {
    blocks.assign(frame.keys);
    history.update(blocks, frame.intensities, depths, is_i_frame);
    simple.update(frame, depths, is_i_frame);
  }
};

TEST(History, MatchesTheSpecification)
{
  std::mt19937_64 random(1);
  for (const unsigned int bits : {1u, 8u, 12u, 13u, 14u, 15u, 16u})
    for (const bool has_depths : {false, true}) {
      Histories both;
      VoxelFrame frame = randomFrame(random, 3 + bits % 3, 150, bits);
      for (int i = 0; i < 40; ++i) {
        SCOPED_TRACE(i);
        const bool is_i_frame = i % 25 == 0;
        if (is_i_frame)
          both.clear(bits);
        const DepthObservations depths = randomDepths(random, frame.size());
        both.update(frame, has_depths ? &depths : nullptr, is_i_frame);
        ASSERT_NO_FATAL_FAILURE(expectSame(both.history, both.simple));
        walk(random, i % 7 == 0 ? 100 : 15, frame);
        if (i % 11 == 10)
          clearVoxels(frame);
      }
    }
}

TEST(History, MatchesTheSpecificationForTheHighestSymbols)
{
  // Fixed point must not leave 16 bits.
  for (const unsigned int bits : {8u, 12u, 13u, 16u}) {
    Histories both;
    both.clear(bits);
    VoxelFrame frame = emptyFrame(2, bits);
    frame.keys = {0, 5, 63};
    for (int i = 0; i < 60; ++i) {
      const auto highest =
          static_cast<std::uint16_t>(frame.intensity_scale.maxSymbol());
      frame.intensities = {
          highest, static_cast<std::uint16_t>(i % 2 == 0 ? 0 : highest), 0};
      both.update(frame, nullptr, i == 0);
      ASSERT_NO_FATAL_FAILURE(expectSame(both.history, both.simple));
    }
  }
}

TEST(History, ActivitiesHaveAnEnd)
{
  Histories both;
  both.clear(8);
  VoxelFrame frame = emptyFrame(2);
  for (std::uint64_t i = 0; i < 8; ++i) {
    for (std::uint64_t cell = 0; cell < 8; ++cell)
      frame.keys.push_back(8 * i + cell);
    frame.intensities.assign(frame.keys.size(), 3);
    both.update(frame, nullptr, i == 0);
    ASSERT_NO_FATAL_FAILURE(expectSame(both.history, both.simple));
  }
  EXPECT_EQ(both.history.blocks()[0].activity, 7);
}

TEST(History, BlocksAtTheEndOfTheLargestGrid)
{
  Histories both;
  both.clear(8);
  VoxelFrame frame = emptyFrame(21);
  const std::uint64_t last = (std::uint64_t{1} << 63) - 1;
  for (int i = 0; i < 10; ++i) {
    frame.keys = {0, last - 64, last};
    if (i % 3 == 1)
      frame.keys = {last};
    frame.intensities.assign(frame.keys.size(), 3);
    both.update(frame, nullptr, i == 0);
    ASSERT_NO_FATAL_FAILURE(expectSame(both.history, both.simple));
  }
}

/** \brief Frames without a voxel until the history has forgotten it. */
int
framesUntilForgotten(History& history)
{
  int frames = 0;
  for (; history.recordCount() > 0 && frames < 1000; ++frames)
    history.update(BlockList(), {}, nullptr, false);
  EXPECT_TRUE(history.blocks().empty());
  return frames;
}

TEST(History, ForgetsVoxelsThatStayAway)
{
  BlockList blocks;
  blocks.assign({17});
  const auto framesAfter = [&](int occupied, bool is_i_frame) {
    History history;
    history.clear(8);
    for (int i = 0; i < occupied; ++i)
      history.update(blocks, {5}, nullptr, is_i_frame && i == 0);
    return framesUntilForgotten(history);
  };
  const int noise = framesAfter(1, false);
  EXPECT_GE(noise, 4);
  EXPECT_LE(noise, 16); // what flashes up once must not fill the history
  EXPECT_GE(framesAfter(1, true), noise);
  EXPECT_GE(framesAfter(20, true), 3 * noise);
  EXPECT_LE(framesAfter(1000, true), 80);
}

TEST(History, KeepsVoxelsAtTheThreshold)
{
  // Frames with and without a voxel, at random, until its probability is 1000 or 999.
  std::mt19937_64 random(7);
  VoxelFrame with = emptyFrame(2);
  with.keys = {7};
  with.intensities = {5};
  const VoxelFrame without = emptyFrame(2);
  std::map<int, int> seen;
  for (int stream = 0; stream < 20000; ++stream) {
    Histories both;
    both.clear(8);
    both.update(with, nullptr, false);
    for (int i = 0; i < 60 && !both.simple.records.empty(); ++i) {
      const int before = both.simple.records.begin()->second.probability;
      const int age = both.simple.records.begin()->second.age;
      const bool is_occupied = below(random, 8) == 0;
      both.update(is_occupied ? with : without, nullptr, false);
      ASSERT_EQ(both.history.recordCount(), both.simple.records.size());
      if (!is_occupied && age >= 10)
        ++seen[before - before / 16];
    }
  }
  EXPECT_GT(seen[1000], 0);
  EXPECT_GT(seen[999], 0);
}

TEST(History, IsBoundedForRandomFrames)
{
  std::mt19937_64 random(3);
  History history;
  history.clear(8);
  BlockList blocks;
  std::size_t most = 0;
  for (int i = 0; i < 100; ++i) {
    const VoxelFrame frame = randomFrame(random, 12, 500);
    blocks.assign(frame.keys);
    history.update(blocks, frame.intensities, nullptr, i == 0);
    most = std::max(most, history.recordCount());
  }
  EXPECT_LE(most, 17 * 500u); // none lives longer that came once
}

TEST(History, ClearForgetsAll)
{
  std::mt19937_64 random(4);
  Histories both;
  both.clear(8);
  both.update(randomFrame(random, 4, 300), nullptr, true);
  both.clear(14);
  EXPECT_EQ(both.history.recordCount(), 0u);
  EXPECT_TRUE(both.history.blocks().empty());
  both.update(randomFrame(random, 4, 300, 14), nullptr, true);
  ASSERT_NO_FATAL_FAILURE(expectSame(both.history, both.simple));
}

} // namespace
