// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Streams of which only the changes are decoded have the voxels, merged frames and
 * health of streams whose frames are listed as a whole; merged frames that are told by
 * their changes are the same frames, and the same bytes.
 */
#include "nodes/merged_frame_encoder.h"
#include "nodes/pending_changes.h"
#include "support/changing_frames.h"
#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::io::VoxelChanges;
using pcl_ext::io::test::ChangingFrames;
using pcl_ext::nodes::FrameListener;
using pcl_ext::nodes::MergedChanges;
using pcl_ext::nodes::MergedFrameEncoder;
using pcl_ext::nodes::PendingChanges;
using pcl_ext::nodes::ReceivedFrame;

constexpr unsigned int bits = 4;

/** \brief A sender with an I-frame now and then, and few changes in most other frames. */
class Sender {
public:
  explicit Sender(unsigned int bits_of_intensities = bits)
  : frames_(bits_of_intensities)
  {}

  Bytes
  next(std::mt19937_64& random, bool is_calm = false)
  {
    const std::uint64_t kind = is_calm ? 2 : below(random, 12);
    VoxelFrame frame = frames_.next(kind == 0 ? 1500 : 8);
    if (kind == 1)
      grid_shift_ += 2;
    frame.grid.first_index[1] += grid_shift_;
    const Bytes bytes = pcl_ext::io::test::encoded(encoder_, frame);
    changes_ += encoder_.statistics().is_of_changes ? 1 : 0;
    return bytes;
  }

  std::size_t
  changes() const
  {
    return changes_;
  }

private:
  ChangingFrames frames_;
  pcl_ext::io::FrameEncoder encoder_{
      pcl_ext::io::StreamFormat::Version1, 25, pcl_ext::io::Effort::Fast};
  std::int32_t grid_shift_ = 0;
  std::size_t changes_ = 0;
};

using Intensities = std::map<std::uint64_t, float>; // by Morton keys

void
addVoxels(const VoxelFrame& frame, Intensities& voxels)
{
  for (std::size_t i = 0; i < frame.size(); ++i)
    EXPECT_TRUE(
        voxels.emplace(frame.keys[i], frame.intensity_scale.value(frame.intensities[i]))
            .second);
}

/** \brief Merged voxels, and their stream, of which only changes are known. */
class Follower {
public:
  void
  follow(CentralNode& node, const VoxelFrame& expected)
  {
    ASSERT_TRUE(node.mergeChanges(changes_).ok());
    const VoxelChanges& changes = changes_.voxels;
    EXPECT_EQ(changes_.number, ++number_);
    EXPECT_EQ(changes.came.grid, expected.grid);
    if (changes.is_from_nothing)
      voxels_.clear();
    for (std::size_t i = 0; i < changes.gone.size(); ++i) {
      const auto voxel = voxels_.find(changes.gone.keys[i]);
      ASSERT_NE(voxel, voxels_.end());
      EXPECT_EQ(voxel->second,
                changes.gone.intensity_scale.value(changes.gone.intensities[i]));
      voxels_.erase(voxel);
    }
    addVoxels(changes.came, voxels_);
    Intensities expected_voxels;
    addVoxels(expected, expected_voxels);
    EXPECT_EQ(voxels_, expected_voxels);
    expectSameStream(node, expected);
  }

  std::size_t
  encodedByChanges() const
  {
    return encoded_by_changes_;
  }

private:
  void
  expectSameStream(CentralNode& node, const VoxelFrame& expected)
  {
    bool is_whole = changes_.voxels.is_from_nothing;
    VoxelFrame merged;
    const auto voxels = [&]() -> const VoxelFrame& {
      is_whole = true;
      node.mergedVoxels(merged);
      expectSameFrame(merged, expected);
      return merged;
    };
    Bytes bytes;
    Bytes expected_bytes;
    const pcl_ext::nodes::Time stamp = std::chrono::milliseconds(10 * number_);
    EXPECT_TRUE(by_changes_.encode(changes_, voxels, stamp, "map", bytes).ok());
    EXPECT_TRUE(whole_.encode(expected, stamp, "map", expected_bytes).ok());
    EXPECT_EQ(bytes, expected_bytes);
    encoded_by_changes_ += is_whole ? 0 : 1;
  }

  MergedChanges changes_;
  std::size_t number_ = 0;
  Intensities voxels_;
  static pcl_ext::io::StreamSettings
  settings()
  {
    pcl_ext::io::StreamSettings settings;
    settings.effort = pcl_ext::io::Effort::Fast;
    settings.i_frame_rate = 8;
    return settings;
  }

  MergedFrameEncoder by_changes_{settings()};
  MergedFrameEncoder whole_{settings()};
  std::size_t encoded_by_changes_ = 0;
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
    // Those of one are far higher, and need another scale.
    senders_.try_emplace(name, name == "4" ? 14 : bits);
    forBoth([&](CentralNode& node) {
      node.removeStream(name);
      EXPECT_TRUE(node.addStream(name).ok());
    });
  }

  void
  send(const std::string& name, bool is_calm)
  {
    const Bytes bytes = senders_.at(name).next(random_, is_calm);
    if (!is_calm && below(random_, 40) == 0)
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
    ASSERT_TRUE(whole_.merge(expected).ok());
    ASSERT_NO_FATAL_FAILURE(follower_.follow(by_changes_, expected));
    if (below(random_, 2) == 0) {
      by_changes_.mergedVoxels(merged);
      expectSameFrame(merged, expected);
    }
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
  Follower follower_;
};

TEST_P(MergingByChanges, IsTheSameAsOfWholeFrames)
{
  std::chrono::milliseconds now{1000};
  constexpr std::size_t streams = 5;
  for (std::size_t i = 0; i < streams; ++i)
    add(std::to_string(i));
  std::size_t changes = 0;
  std::size_t sent = 0;
  std::size_t before_calm_rounds = 0;
  constexpr std::size_t calm_rounds = 20;
  for (std::size_t round = 0; round < 60 + calm_rounds; ++round) {
    const bool is_calm = round >= 60;
    if (round == 60)
      before_calm_rounds = follower_.encodedByChanges();
    now += std::chrono::milliseconds(round % 10 == 9 && !is_calm ? 1900 : 150);
    clock_.set(now);
    const std::size_t frames = round == 30 ? PendingChanges::most_frames + 2 : 3;
    for (std::size_t i = 0; i < streams; ++i)
      for (std::size_t frame = below(random_, frames); frame > 0; --frame, ++sent)
        send(std::to_string(i), is_calm);
    const std::string name = std::to_string(below(random_, streams));
    if (!is_calm && below(random_, 3) == 0)
      changeSettings(name);
    if (!is_calm && below(random_, 10) == 0) {
      changes += senders_.at(name).changes();
      add(name);
    }
    ASSERT_NO_FATAL_FAILURE(expectSame()) << round;
    ASSERT_FALSE(HasFailure()) << round;
  }
  for (const auto& [name, sender] : senders_)
    changes += sender.changes();
  EXPECT_GT(changes, sent / 2);
  EXPECT_GT(follower_.encodedByChanges() - before_calm_rounds, calm_rounds / 2);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MergingByChanges, ::testing::Values(1, 2));

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
    MergedChanges changes;
    VoxelFrame merged;
    VoxelFrame expected;
    const auto merge = [&] {
      try {
        const bool is_merged = node.mergeChanges(changes).ok();
        node.mergedVoxels(merged);
        return is_merged;
      }
      catch (const std::bad_alloc&) {
        EXPECT_TRUE(merged.keys.empty());
        return false;
      }
    };
    for (std::size_t i = 0; i < 40; ++i) {
      Bytes bytes = sender.next(random);
      ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), expected).ok());
      const FailingAllocation failing(i == 6 ? number : 0);
      node.receive("a", std::move(bytes));
      node.waitUntilDecoded();
      const bool is_merged = merge();
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

TEST(MergingByChangesMemory, AFailureToEncodeAndAGapLoseNoVoxels)
{
  // Each allocation of encoding fails once; one merged frame is not encoded at all.
  pcl_ext::io::StreamSettings settings;
  settings.effort = pcl_ext::io::Effort::Fast;
  settings.i_frame_rate = 100;
  std::size_t number = 1;
  std::size_t by_changes = 0;
  for (bool has_failed = true; has_failed; ++number) {
    std::mt19937_64 random(6);
    Sender sender;
    CentralNode node(centralSettings());
    node.addStream("a");
    MergedFrameEncoder encoder(settings);
    pcl_ext::io::FrameDecoder decoder;
    MergedChanges changes;
    VoxelFrame merged;
    VoxelFrame decoded;
    const auto voxels = [&]() -> const VoxelFrame& {
      node.mergedVoxels(merged);
      return merged;
    };
    for (std::size_t i = 0; i < 12; ++i) {
      sendAndWait(node, "a", sender.next(random, true));
      ASSERT_TRUE(node.mergeChanges(changes).ok());
      if (i == 9)
        continue;
      Bytes bytes;
      bool is_encoded = false;
      {
        const FailingAllocation failing(i == 1 ? number : 0);
        is_encoded = encoder.encode(changes, voxels, Time(i), "", bytes).ok();
        has_failed = i == 1 ? failing.hasFailed() : has_failed;
      }
      if (i == 1 && !is_encoded)
        continue;
      ASSERT_TRUE(is_encoded);
      by_changes += encoder.statistics().is_of_changes ? 1 : 0;
      ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), decoded).ok());
      EXPECT_EQ(decoded.keys, voxels().keys);
      EXPECT_EQ(decoded.intensities, voxels().intensities);
    }
    ASSERT_FALSE(::testing::Test::HasFailure()) << number;
  }
  EXPECT_GT(number, 3u);
  EXPECT_GT(by_changes, 4 * number);
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
