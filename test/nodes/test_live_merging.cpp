// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::VoxelColour;

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

} // namespace
