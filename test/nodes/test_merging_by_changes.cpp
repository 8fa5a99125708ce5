// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Streams of which only the changes are decoded have the voxels, merged frames and
 * health of streams whose frames are listed as a whole.
 */
#include "nodes/pending_changes.h"
#include "support/changing_frames.h"
#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::VoxelChanges;
using pcl_ext::io::test::ChangingFrames;
using pcl_ext::nodes::FrameListener;
using pcl_ext::nodes::PendingChanges;
using pcl_ext::nodes::ReceivedFrame;

constexpr unsigned int bits = 4;

/** \brief A sender with an I-frame now and then, and few changes in most other frames. */
class Sender {
public:
  Bytes
  next(std::mt19937_64& random)
  {
    const std::uint64_t kind = below(random, 12);
    VoxelFrame frame = frames_.next(kind == 0 ? 1500 : 8);
    if (kind == 1)
      grid_shift_ += 2;
    frame.grid.first_index[1] += grid_shift_;
    const Bytes bytes = pcl_ext::io::test::encoded(encoder_, frame);
    changes_ += encoder_.statistics().is_of_changes ? 1 : 0;
    return bytes;
  }

  /** \brief Number of frames of changes. */
  std::size_t
  changes() const
  {
    return changes_;
  }

private:
  ChangingFrames frames_{bits};
  pcl_ext::io::FrameEncoder encoder_{
      pcl_ext::io::StreamFormat::Version1, 25, pcl_ext::io::Effort::Fast};
  std::int32_t grid_shift_ = 0;
  std::size_t changes_ = 0;
};

/** \brief The same streams in a node whose listener wants all voxels, and in one whose
 * listener wants some of those of one stream. */
class MergingByChanges : public ::testing::TestWithParam<std::uint64_t> {
protected:
  static CentralNodeSettings
  settings(FakeClock& clock)
  {
    CentralNodeSettings settings = centralSettings();
    settings.clock = clock.clock();
    settings.threads = 2;
    return settings;
  }

  template <typename CallT>
  void
  forBoth(const CallT& call)
  {
    call(whole_);
    call(by_changes_);
  }

  void
  add(const std::string& name)
  {
    senders_.erase(name);
    senders_.try_emplace(name);
    forBoth([&](CentralNode& node) {
      node.removeStream(name);
      EXPECT_TRUE(node.addStream(name).ok());
    });
  }

  void
  send(const std::string& name)
  {
    const Bytes bytes = senders_.at(name).next(random_);
    if (below(random_, 40) == 0)
      return; // lost
    forBoth([&](CentralNode& node) { sendAndWait(node, name, bytes); });
  }

  void
  changeSettings(const std::string& name)
  {
    const float least = below(random_, 2) == 0 ? CentralNode::lowest_intensity : 3.0f;
    std::optional<VoxelOutlierRemovalSettings> removal;
    if (below(random_, 2) == 0) {
      removal.emplace();
      removal->unit = PointsUnit();
    }
    const bool changes_removal = below(random_, 2) == 0;
    forBoth([&](CentralNode& node) {
      if (changes_removal)
        EXPECT_TRUE(node.setOutlierRemoval(name, removal).ok());
      else
        EXPECT_TRUE(node.setMinIntensity(name, least).ok());
    });
  }

  void
  expectSame()
  {
    VoxelFrame merged;
    VoxelFrame expected;
    ASSERT_TRUE(by_changes_.merge(merged).ok());
    ASSERT_TRUE(whole_.merge(expected).ok());
    expectSameFrame(merged, expected);
    for (const auto& [name, sender] : senders_)
      if (below(random_, 4) == 0) {
        whole_.latestVoxels(name, expected);
        by_changes_.latestVoxels(name, merged);
        expectSameFrame(merged, expected);
      }
    const auto health = by_changes_.health();
    const auto expected_health = whole_.health();
    for (std::size_t i = 0; i < health.size(); ++i) {
      EXPECT_EQ(health[i].kept_voxels, expected_health[i].kept_voxels);
      EXPECT_EQ(health[i].voxels, expected_health[i].voxels);
      EXPECT_EQ(health[i].frames_decoded, expected_health[i].frames_decoded);
      EXPECT_EQ(health[i].voxels_outside_grid, expected_health[i].voxels_outside_grid);
    }
  }

  std::mt19937_64 random_{GetParam()};
  FakeClock clock_;
  std::map<std::string, VoxelFrame> listed_; // guarded by nothing: one frame at a time
  CentralNode whole_{settings(clock_), [this](const ReceivedFrame& frame) {
                       listed_[frame.stream] = frame.voxels();
                     }};
  CentralNode by_changes_{settings(clock_), [this](const ReceivedFrame& frame) {
                            if (frame.stream == "1" && ++calls_ % 3 != 0)
                              expectSameFrame(frame.voxels(), listed_.at("1"));
                          }};
  std::size_t calls_ = 0;
  std::map<std::string, Sender> senders_;
};

TEST_P(MergingByChanges, IsTheSameAsOfWholeFrames)
{
  std::chrono::milliseconds now{1000};
  constexpr std::size_t streams = 5;
  for (std::size_t i = 0; i < streams; ++i)
    add(std::to_string(i));
  std::size_t changes = 0;
  std::size_t sent = 0;
  for (std::size_t round = 0; round < 60; ++round) {
    now += std::chrono::milliseconds(round % 10 == 9 ? 1900 : 150);
    clock_.set(now);
    const std::size_t frames = round == 30 ? PendingChanges::most_frames + 2 : 3;
    for (std::size_t i = 0; i < streams; ++i)
      for (std::size_t frame = below(random_, frames); frame > 0; --frame, ++sent)
        send(std::to_string(i));
    const std::string name = std::to_string(below(random_, streams));
    if (below(random_, 3) == 0)
      changeSettings(name);
    if (below(random_, 10) == 0) {
      changes += senders_.at(name).changes();
      add(name);
    }
    ASSERT_NO_FATAL_FAILURE(expectSame()) << round;
    ASSERT_FALSE(HasFailure()) << round;
  }
  for (const auto& [name, sender] : senders_)
    changes += sender.changes();
  EXPECT_GT(changes, sent / 2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MergingByChanges, ::testing::Values(1, 2, 3, 4));

TEST(MergingByChangesMemory, AFailureLosesNoVoxels)
{
  // Each allocation of decoding, listing and merging fails once.
  std::size_t number = 1;
  for (bool has_failed = true; has_failed; ++number) {
    std::mt19937_64 random(6);
    Sender sender;
    CentralNode node(centralSettings());
    node.addStream("a");
    pcl_ext::io::FrameDecoder decoder;
    VoxelFrame merged;
    VoxelFrame expected;
    for (std::size_t i = 0; i < 40; ++i) {
      Bytes bytes = sender.next(random);
      ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), expected).ok());
      const FailingAllocation failing(i == 6 ? number : 0);
      node.receive("a", std::move(bytes));
      node.waitUntilDecoded();
      const bool is_merged = node.merge(merged).ok();
      if (i == 6)
        has_failed = failing.hasFailed();
      else
        ASSERT_TRUE(is_merged);
    }
    // Since the I-frame at the latest.
    EXPECT_EQ(node.health().front().kept_voxels, expected.size()) << number;
    EXPECT_EQ(latestVoxels(node, "a").keys, expected.keys) << number;
    CentralNode anew(centralSettings());
    anew.addStream("a");
    sendAndWait(anew, "a", coded(expected));
    ASSERT_TRUE(anew.merge(expected).ok());
    EXPECT_TRUE(worldVoxels(merged) == worldVoxels(expected));
    ASSERT_FALSE(::testing::Test::HasFailure()) << number;
  }
  EXPECT_GT(number, 5u);
}

TEST(PendingChanges, OfManyFramesAreTheDifferenceOfTheFirstAndTheLast)
{
  std::mt19937_64 random(3);
  ChangingFrames frames(bits);
  std::vector<VoxelFrame> all{frames.next(0)};
  for (std::size_t i = 1; i < 40; ++i) {
    all.push_back(frames.next(static_cast<unsigned int>(below(random, 300))));
    all.back().grid.first_index[0] = i % 16 < 8 ? 0 : 4;
  }
  for (std::size_t first = 0; first < all.size(); first += 3) {
    PendingChanges pending;
    pending.begin(first);
    EXPECT_TRUE(pending.areEmpty());
    for (std::size_t last = first + 1; last < all.size(); ++last) {
      VoxelChanges changes;
      findChanges(all[last - 1], all[last], changes);
      if (last % 5 < 2)
        pending.add(all[last - 1], all[last]);
      else
        pending.add(changes);
      findChanges(all[first], all[last], changes);
      PendingChanges copy = pending;
      ASSERT_TRUE(copy.areSince(first));
      VoxelChanges joined;
      copy.take(last, joined);
      EXPECT_TRUE(copy.areSince(last));
      EXPECT_TRUE(copy.areEmpty());
      VoxelChanges without_same;
      findChanges(joined.gone, joined.came, without_same);
      expectSameFrame(without_same.gone, changes.gone);
      expectSameFrame(without_same.came, changes.came);
    }
  }
}

} // namespace
