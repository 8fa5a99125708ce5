// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "nodes/summed_voxels.h"
#include "support/node_tests.h"

#include <cmath>

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::VoxelColour;
using pcl_ext::nodes::ChangedSum;
using pcl_ext::nodes::ChangedSums;
using pcl_ext::nodes::SummedColour;
using pcl_ext::nodes::SummedVoxels;
using pcl_ext::nodes::VoxelUpdate;
using pcl_ext::nodes::VoxelUpdates;

constexpr double resolution = 0.04;
constexpr float half_step = 0.5f;

struct Sum {
  double intensity = 0.0;
  std::array<unsigned int, 3> channels{};
  unsigned int colours = 0;
};

using Sums = std::map<std::array<std::int64_t, 3>, Sum>;

class ChangingStream {
public:
  ChangingStream(std::uint64_t seed, double edge, unsigned int colour_bits)
  : random_(seed)
  {
    frame_ = pcl_ext::io::test::emptyFrame(6);
    frame_.grid.resolution = edge;
    frame_.intensity_scale.step = half_step;
    frame_.colour_bits = colour_bits;
    for (std::int32_t& index : frame_.grid.first_index)
      index = static_cast<std::int32_t>(below(random_, 40)) - 20;
  }

  const VoxelFrame&
  next()
  {
    for (int i = 0; !voxels_.empty() && i < 25; ++i)
      voxels_.erase(voxels_.lower_bound(below(random_, voxels_.rbegin()->first + 1)));
    for (int i = voxels_.empty() ? 300 : 25; i > 0; --i)
      voxels_[below(random_, 1u << 15)] =
          static_cast<std::uint16_t>(below(random_, 256));
    std::int32_t& first = frame_.grid.first_index[0];
    switch (below(random_, 12)) {
    case 0:
      voxels_.clear(); // a frame without voxels
      break;
    case 1:
      frame_.grid.first_index[below(random_, 3)] += 7; // all voxels are elsewhere
      break;
    case 2:
      first += first > 2000 ? -3000 : 3000; // the merged grid grows, or shrinks
      break;
    default:
      break;
    }
    ++changes_;
    pcl_ext::io::test::clearVoxels(frame_);
    for (const auto& [key, intensity] : voxels_) {
      frame_.keys.push_back(key);
      frame_.intensities.push_back(intensity);
      // Of some voxels another one each time.
      const std::uint64_t bits = (key + (key % 5 == 0 ? changes_ : 0)) * 2654435761u;
      const auto channel = [&](unsigned int shift) {
        return static_cast<std::uint8_t>((bits >> shift) % (1u << frame_.colour_bits));
      };
      if (frame_.colour_bits > 0)
        frame_.colours.push_back({channel(3), channel(7), channel(11)});
    }
    return frame_;
  }

  void
  addTo(Sums& sums) const
  {
    for (std::size_t i = 0; i < frame_.size(); ++i) {
      const auto position = pcl_ext::io::voxelPosition(frame_.keys[i]);
      const auto index = [&](std::size_t axis, std::uint32_t place) {
        return static_cast<std::int64_t>(
            std::floor(frame_.grid.centre(axis, place) / resolution + 1e-6));
      };
      Sum& sum =
          sums[{index(0, position.x), index(1, position.y), index(2, position.z)}];
      sum.intensity += frame_.intensities[i] * static_cast<double>(half_step);
      if (frame_.colour_bits == 0)
        continue;
      ++sum.colours;
      const VoxelColour colour = frame_.fullColour(i);
      sum.channels[0] += colour.r;
      sum.channels[1] += colour.g;
      sum.channels[2] += colour.b;
    }
  }

private:
  std::mt19937_64 random_;
  VoxelFrame frame_;
  std::map<std::uint64_t, std::uint16_t> voxels_;
  std::uint64_t changes_ = 0;
};

void
expectSums(const VoxelFrame& merged, const Sums& expected)
{
  ASSERT_TRUE(isConsistent(merged));
  ASSERT_EQ(merged.size(), expected.size());
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const auto found = expected.find(pcl_ext::io::test::latticeIndex(merged, i));
    ASSERT_NE(found, expected.end());
    const Sum& sum = found->second;
    ASSERT_EQ(static_cast<double>(merged.intensity_scale.value(merged.intensities[i])),
              sum.intensity);
    const auto mean = [&](std::size_t channel) {
      const double colours = std::max(sum.colours, 1u);
      return static_cast<std::uint8_t>(
          std::floor(static_cast<double>(sum.channels[channel]) / colours + 0.5));
    };
    const VoxelColour black;
    ASSERT_EQ(merged.colour_bits > 0 ? merged.colours[i] : black,
              (VoxelColour{mean(0), mean(1), mean(2)}));
  }
}

/** \brief The same streams in nodes of one thread and of several. */
class LiveMerging : public ::testing::TestWithParam<std::uint64_t> {
protected:
  void
  addStream(const std::string& name)
  {
    const std::uint64_t seed = 1000 * GetParam() + ++added_;
    const double edge = added_ % 4 == 0 ? 2.0 * resolution : resolution;
    streams_.erase(name);
    const std::array<unsigned int, 8> colour_bits = {8, 0, 0, 5, 0, 0, 1, 0};
    streams_.emplace(name, ChangingStream(seed, edge, colour_bits[added_ % 8]));
    received_.erase(name);
    for (CentralNode* node : {&one_thread_, &several_threads_}) {
      node->removeStream(name);
      node->addStream(name);
    }
  }

  void
  removeStream(const std::string& name)
  {
    received_.erase(name);
    one_thread_.removeStream(name);
    several_threads_.removeStream(name);
  }

  void
  sendNext(const std::string& name)
  {
    const Bytes bytes = coded(streams_.at(name).next());
    for (CentralNode* node : {&one_thread_, &several_threads_})
      sendAndWait(*node, name, bytes);
    received_[name] = clock_.clock()();
  }

  void
  expectMerged()
  {
    Sums expected;
    for (const auto& [name, time] : received_)
      if (clock_.clock()() - time <= std::chrono::seconds(2))
        streams_.at(name).addTo(expected);
    VoxelFrame merged;
    ASSERT_TRUE(one_thread_.merge(merged).ok());
    expectSums(merged, expected);
    VoxelFrame by_several;
    ASSERT_TRUE(several_threads_.merge(by_several).ok());
    expectSameFrame(by_several, merged);
  }

  static CentralNodeSettings
  settings(FakeClock& clock, unsigned int threads)
  {
    CentralNodeSettings settings = centralSettings();
    settings.clock = clock.clock();
    settings.threads = threads;
    return settings;
  }

  FakeClock clock_;
  CentralNode one_thread_{settings(clock_, 1)};
  CentralNode several_threads_{settings(clock_, 8)};
  std::map<std::string, ChangingStream> streams_;
  std::map<std::string, Time> received_;
  std::uint64_t added_ = 0;
};

TEST_P(LiveMerging, HasWhatTheStreamsHaveNow)
{
  std::mt19937_64 random(GetParam());
  constexpr std::size_t most = 40; // so many that threads share them
  std::chrono::milliseconds now{1000};
  for (std::size_t i = 0; i < most; ++i)
    addStream(std::to_string(i));
  for (std::size_t round = 0; round < 20; ++round) {
    now += std::chrono::milliseconds(round % 10 == 9 ? 1900 : 150);
    clock_.set(now);
    for (std::size_t i = 0; i < most; ++i)
      if (received_.count(std::to_string(i)) == (below(random, 3) == 0 ? 0u : 1u) ||
          round == 0)
        sendNext(std::to_string(i));
    const std::string name = std::to_string(below(random, most));
    if (below(random, 4) == 0)
      addStream(name); // another one of this name
    ASSERT_NO_FATAL_FAILURE(expectMerged()) << round;
  }
  for (std::size_t i = 0; i < most; ++i)
    removeStream(std::to_string(i));
  expectMerged();
}

TEST_P(LiveMerging, HasColoursOnlyWhileAStreamHasThem)
{
  CentralNode node(settings(clock_, 1));
  node.addStream("a");
  for (const unsigned int colour_bits : {8u, 0u}) {
    ChangingStream stream(GetParam(), resolution, colour_bits);
    sendAndWait(node, "a", coded(stream.next()));
    VoxelFrame merged;
    ASSERT_TRUE(node.merge(merged).ok());
    EXPECT_TRUE(isConsistent(merged));
    EXPECT_EQ(merged.colour_bits, colour_bits);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, LiveMerging, ::testing::Values(1, 2));

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
