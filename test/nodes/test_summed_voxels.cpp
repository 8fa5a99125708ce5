// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "nodes/summed_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace {

using pcl_ext::nodes::ChangedSum;
using pcl_ext::nodes::ChangedSums;
using pcl_ext::nodes::SummedColour;
using pcl_ext::nodes::SummedVoxels;
using pcl_ext::nodes::VoxelUpdate;
using pcl_ext::nodes::VoxelUpdates;

using SumsByKey = std::map<std::uint64_t, std::pair<std::int64_t, std::uint32_t>>;

/** \brief Sums by one, two and eight threads, and in a map. */
class SummedByThreads : public ::testing::Test {
protected:
  void
  append(std::uint64_t key, std::int64_t intensity, int summands, VoxelUpdates& updates)
  {
    VoxelUpdate update{};
    update.intensity = intensity;
    update.summands = static_cast<std::int8_t>(summands);
    updates.append(key, update);
    auto& sum = expected_[key];
    sum.first += intensity;
    sum.second += static_cast<std::uint32_t>(summands);
    if (sum.second == 0)
      expected_.erase(key);
  }

  void
  add(const std::vector<VoxelUpdates>& of_streams)
  {
    std::vector<const VoxelUpdates*> pointers;
    for (const VoxelUpdates& updates : of_streams)
      pointers.push_back(&updates);
    constexpr bool lists_changes = true;
    for (SummedVoxels& sums : sums_) {
      sums.add(pointers, lists_changes);
      ASSERT_EQ(sums.size(), expected_.size());
      auto expected = expected_.begin();
      sums.forEach([&](std::uint64_t key, std::int64_t sum, const SummedColour&) {
        EXPECT_EQ(key, expected->first);
        EXPECT_EQ(sum, expected->second.first);
        ++expected;
      });
      std::vector<ChangedSum> changes;
      for (const ChangedSums& list : sums.changes())
        changes.insert(changes.end(), list.sums.begin(), list.sums.end());
      expectChanges(changes);
      ASSERT_FALSE(HasFailure());
    }
    before_ = expected_;
  }

  void
  expectChanges(const std::vector<ChangedSum>& changes) const
  {
    SumsByKey sums = before_;
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const ChangedSum& change = changes[i];
      EXPECT_TRUE(i == 0 || changes[i - 1].key < change.key);
      const auto sum = sums.find(change.key);
      ASSERT_EQ(sum != sums.end(), change.was_there);
      EXPECT_EQ(change.before, change.was_there ? sum->second.first : 0);
      EXPECT_TRUE(change.was_there != change.is_there || change.before != change.after);
      if (!change.is_there)
        sums.erase(sum);
      else
        sums[change.key].first = change.after;
    }
    EXPECT_TRUE(std::equal(sums.begin(),
                           sums.end(),
                           expected_.begin(),
                           expected_.end(),
                           [](const auto& one, const auto& other) {
                             return one.first == other.first &&
                                    one.second.first == other.second.first;
                           }));
  }

  SumsByKey before_;
  SumsByKey expected_;
  std::vector<SummedVoxels> sums_ = {SummedVoxels(1), SummedVoxels(2), SummedVoxels(8)};
};

TEST_F(SummedByThreads, AreThoseOfAMap)
{
  std::mt19937_64 random(1);
  for (std::size_t round = 0; round < 20; ++round) {
    std::vector<VoxelUpdates> of_streams(1 + random() % 4);
    const std::uint64_t most = std::uint64_t{1} << (10 + random() % 20);
    for (VoxelUpdates& updates : of_streams)
      for (std::size_t i = 0; i < random() % 6000; ++i)
        append(random() % most, static_cast<std::int64_t>(random() % 100), 1, updates);
    // Some go again, with all that they added.
    for (std::size_t i = 0; i < random() % 3000 && !expected_.empty(); ++i) {
      const auto found = expected_.lower_bound(random() % most);
      if (found != expected_.end() && found->second.second == 1)
        append(found->first, -found->second.first, -1, of_streams.back());
    }
    ASSERT_NO_FATAL_FAILURE(add(of_streams)) << round;
  }
}

TEST_F(SummedByThreads, AlsoWhereTheLastBlockHasMostRuns)
{
  constexpr std::uint64_t last_block = 50 * VoxelUpdates::block_cells;
  std::vector<VoxelUpdates> scattered(1);
  for (std::uint64_t key = 0; key < last_block; key += 37)
    append(key, 3, 1, scattered[0]);
  ASSERT_NO_FATAL_FAILURE(add(scattered));
  std::vector<VoxelUpdates> of_streams(5000);
  for (std::size_t i = 0; i < of_streams.size(); ++i)
    append(last_block + i % 100, 1, 1, of_streams[i]);
  ASSERT_NO_FATAL_FAILURE(add(of_streams));
  ASSERT_NO_FATAL_FAILURE(add(std::vector<VoxelUpdates>(3))); // nothing changes
  // Blocks in turns, as where a stream is between those of the merged grid.
  std::vector<VoxelUpdates> in_turns(1);
  for (std::uint64_t i = 0; i < 6000; ++i)
    append((i % 2) * last_block + i % 4000, 2, 1, in_turns[0]);
  ASSERT_NO_FATAL_FAILURE(add(in_turns));
}

TEST_F(SummedByThreads, TellWhetherARangeHasAny)
{
  std::vector<VoxelUpdates> updates(1);
  append(100, 1, 1, updates[0]);
  append(9000, 1, 1, updates[0]);
  ASSERT_NO_FATAL_FAILURE(add(updates));
  for (const SummedVoxels& sums : sums_) {
    EXPECT_TRUE(sums.hasAnyBetween(100, 101));
    EXPECT_FALSE(sums.hasAnyBetween(101, 9000));
    EXPECT_FALSE(sums.hasAnyBetween(9001, 20000));
    EXPECT_TRUE(sums.hasAnyBetween(0, 20000));
  }
}

} // namespace
