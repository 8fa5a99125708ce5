// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/decoder_limits.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_changes.h>

#include "support/changing_frames.h"
#include "support/forged_frames.h"
#include "support/scan_frames.h"
#include "support/supplement_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::test::Exemption;
using pcl_ext::test::FailingAllocation;
using pcl_ext::test::MemoryUse;

using Value = std::tuple<int, int, int, int>; // symbol and colour, -1: none
using Voxels = std::map<std::uint64_t, Value>;

Voxels
voxelsOf(const VoxelFrame& frame)
{
  Voxels voxels;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    Value value = {-1, -1, -1, -1};
    if (frame.hasIntensities())
      std::get<0>(value) = frame.intensities[i];
    if (frame.colour_bits > 0)
      value = {std::get<0>(value),
               frame.colours[i].r,
               frame.colours[i].g,
               frame.colours[i].b};
    voxels[frame.keys[i]] = value;
  }
  EXPECT_EQ(voxels.size(), frame.size());
  return voxels;
}

bool
areComparable(const VoxelFrame& before, const VoxelFrame& after)
{
  return before.grid == after.grid && before.intensity_scale == after.intensity_scale &&
         before.colour_bits == after.colour_bits &&
         before.depth_model == after.depth_model;
}

void
expectSameKind(const VoxelFrame& part, const VoxelFrame& frame)
{
  EXPECT_TRUE(areComparable(part, frame));
  EXPECT_TRUE(isConsistent(part));
  EXPECT_FALSE(part.has_point_counts);
  EXPECT_FALSE(part.points.areThere());
  EXPECT_TRUE(part.fields.empty());
}

/** \brief Who applies changes to the voxels that it has. */
class Applied {
public:
  /** \param[in] whole the frame as another decoder has it */
  void
  apply(const VoxelChanges& changes, const VoxelFrame& whole)
  {
    expectSameKind(changes.came, whole);
    if (changes.is_from_nothing) {
      EXPECT_EQ(changes.gone.size(), 0u);
      expectSameKind(changes.gone, whole);
      voxels_.clear();
    }
    else
      expectSameKind(changes.gone, kind_);
    EXPECT_EQ(changes.areOfOneGrid(),
              changes.gone.grid == changes.came.grid &&
                  changes.gone.intensity_scale == changes.came.intensity_scale &&
                  changes.gone.colour_bits == changes.came.colour_bits);
    const Voxels gone = voxelsOf(changes.gone);
    for (const auto& [key, value] : gone) {
      const auto found = voxels_.find(key);
      ASSERT_TRUE(found != voxels_.end() && found->second == value);
      voxels_.erase(found);
    }
    const bool are_comparable = areComparable(changes.gone, changes.came);
    EXPECT_TRUE(are_comparable || voxels_.empty());
    for (const auto& [key, value] : voxelsOf(changes.came)) {
      const auto was = gone.find(key);
      EXPECT_FALSE(are_comparable && was != gone.end() && was->second == value);
      EXPECT_TRUE(voxels_.emplace(key, value).second);
    }
    EXPECT_TRUE(voxels_ == voxelsOf(whole));
    kind_ = whole;
  }

  void
  replace(const VoxelFrame& whole)
  {
    voxels_ = voxelsOf(whole);
    kind_ = whole;
  }

  void
  expectLatest(FrameDecoder& decoder) const
  {
    VoxelFrame latest = emptyFrame(1, 0);
    latest.keys = {5}; // is replaced
    ASSERT_TRUE(decoder.latestVoxels(latest));
    expectSameKind(latest, kind_);
    EXPECT_TRUE(voxelsOf(latest) == voxels_);
  }

private:
  VoxelFrame kind_;
  Voxels voxels_;
};

class BothDecoders {
public:
  explicit BothDecoders(const DecoderLimits& limits = DecoderLimits())
  : changing_(limits), whole_(limits)
  {}

  /** \param[in] tells_changes whether the first decoder tells changes of this frame */
  CompressionCode
  decode(const Bytes& bytes, bool tells_changes = true)
  {
    VoxelFrame whole;
    const CompressionCode code = decoded(whole_, bytes, whole);
    if (tells_changes)
      decodeChanges(bytes, code, whole);
    else {
      VoxelFrame same;
      EXPECT_EQ(decoded(changing_, bytes, same), code);
      if (code == CompressionCode::Ok) {
        expectSameFrame(same, whole);
        applied_.replace(whole);
        has_frame_ = true;
      }
    }
    return code;
  }

  bool
  hasFrame() const
  {
    return has_frame_;
  }

  const CodedFrameStatistics&
  statistics() const
  {
    return changing_.statistics();
  }

  void
  setDecodesVoxels(bool decodes_voxels)
  {
    changing_.setDecodesVoxels(decodes_voxels);
  }

private:
  void
  decodeChanges(const Bytes& bytes, CompressionCode code, const VoxelFrame& whole)
  {
    changes_.gone.keys = {7, 8};
    changes_.gone.intensities = {7, 8};
    const CompressionStatus status =
        ++calls_ % 2 == 0
            ? changing_.decode(bytes.data(), bytes.size(), changes_)
            : changing_.decode(bytes.data(), bytes.size(), changes_, memory_);
    ASSERT_EQ(status.code(), code);
    if (code == CompressionCode::Ok) {
      EXPECT_EQ(changes_.is_from_nothing, !has_frame_);
      applied_.apply(changes_, whole);
      has_frame_ = true;
      EXPECT_EQ(changing_.statistics().voxels, whole_.statistics().voxels);
      EXPECT_EQ(changing_.statistics().header_bytes, whole_.statistics().header_bytes);
      EXPECT_EQ(changing_.statistics().is_of_changes,
                whole_.statistics().is_of_changes);
    }
    else {
      EXPECT_TRUE(voxelsOf(changes_.gone).empty() && voxelsOf(changes_.came).empty());
      EXPECT_FALSE(changes_.is_from_nothing);
    }
    if (has_frame_)
      applied_.expectLatest(changing_);
  }

  FrameDecoder changing_;
  FrameDecoder whole_;
  DecodingMemory memory_;
  VoxelChanges changes_;
  Applied applied_;
  bool has_frame_ = false;
  std::size_t calls_ = 0;
};

struct Content {
  std::string name;
  unsigned int bits = 8;
  bool has_depth_model = false;
  unsigned int colour_bits = 0;
  bool has_point_counts = false;
  bool has_fields = false;
};

const std::vector<Content> all_contents = {
    {"Counts"},
    {"Depths", 16, true},
    {"OneBit", 1},
    {"NoIntensities", 0},
    {"Colours", 8, false, 5},
    {"ColoursOnly", 0, false, 8},
    {"PointCounts", 8, false, 0, true},
    {"Others", 8, false, 0, true, true},
};

/** \brief Frames of a stream: few changes from most frames to the next, many from some,
 * and other grids now and then. */
class Scene {
public:
  explicit Scene(const Content& content)
  : content_(content), frames_(content.bits, content.has_depth_model)
  {}

  VoxelFrame
  next()
  {
    const std::uint64_t kind = below(random_, 12);
    VoxelFrame frame = frames_.next(kind == 0 ? 3000 : kind < 4 ? 0 : 40);
    if (below(random_, 15) == 0)
      shift_ = 1 - shift_;
    frame.grid.first_index[1] += shift_;
    if (content_.colour_bits > 0) {
      std::mt19937_64 colours(9);
      addColours(colours, content_.colour_bits, frame);
      for (int i = 0; i < 30; ++i)
        frame.colours[below(random_, frame.size())] = {};
    }
    if (content_.has_point_counts)
      addPointCounts(random_, frame);
    if (content_.has_fields)
      addFields(random_, frame);
    if (below(random_, 14) == 0)
      clearVoxels(frame);
    return frame;
  }

private:
  Content content_;
  ChangingFrames frames_;
  std::mt19937_64 random_{12};
  std::int32_t shift_ = 0;
};

class VoxelChangesOf : public testing::TestWithParam<Content> {};

INSTANTIATE_TEST_SUITE_P(Contents,
                         VoxelChangesOf,
                         testing::ValuesIn(all_contents),
                         [](const auto& content) { return content.param.name; });

TEST_P(VoxelChangesOf, AllFramesAddUpAndThoseThatAreLostOrDamagedDoNoHarm)
{
  std::mt19937_64 random(32);
  for (const Effort effort : {Effort::Fast, Effort::Small}) {
    SCOPED_TRACE(nameOf(effort));
    Scene scene(GetParam());
    FrameEncoder encoder(StreamFormat::Version1, 5, effort);
    BothDecoders decoders;
    std::map<CompressionCode, int> codes;
    std::size_t of_changes = 0;
    for (unsigned int i = 0; i < 125; ++i) {
      SCOPED_TRACE(i);
      Bytes bytes = encoded(encoder, scene.next());
      // First a run without losses.
      const std::uint64_t kind = i < 25 ? 7 : below(random, 8);
      if (kind == 0)
        continue;
      if (kind == 1)
        bytes = flipped(bytes, below(random, 8 * bytes.size()));
      if (kind == 2)
        bytes = prefixOf(bytes, below(random, bytes.size()));
      const bool tells_changes = !decoders.hasFrame() || below(random, 4) != 0;
      const CompressionCode code = decoders.decode(bytes, tells_changes);
      ++codes[code];
      of_changes +=
          code == CompressionCode::Ok && decoders.statistics().is_of_changes ? 1 : 0;
      if (kind == 3) // once more
        ++codes[decoders.decode(bytes)];
      if (HasFailure())
        return;
    }
    EXPECT_GT(codes[CompressionCode::Ok], 10);
    EXPECT_GT(codes[CompressionCode::Corrupt], 2);
    EXPECT_GT(codes[CompressionCode::MissingReference], 10);
    const bool may_be_of_changes =
        GetParam().colour_bits == 0 && !GetParam().has_point_counts;
    EXPECT_TRUE(may_be_of_changes ? of_changes > 5 : of_changes == 0) << of_changes;
  }
}

TEST(VoxelChanges, OfThePublishedLayoutAndBothInTurnsAddUp)
{
  ChangingFrames frames(8);
  FrameEncoder published(StreamFormat::Published, 10, Effort::Balanced);
  FrameEncoder version1(StreamFormat::Version1, 10, Effort::Fast);
  BothDecoders decoders;
  std::map<CompressionCode, int> codes;
  for (unsigned int i = 0; i < 90; ++i) {
    SCOPED_TRACE(i);
    // Long enough in a row that the decoder forgets the other one, too.
    const bool is_published = i < 12 || (i < 40 && i % 3 == 0) || i > 70;
    const Bytes bytes = encoded(is_published ? published : version1, frames.next(20));
    ++codes[decoders.decode(bytes)];
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(codes[CompressionCode::Ok], 70);
  EXPECT_EQ(codes[CompressionCode::Ok] + codes[CompressionCode::MissingReference], 90);
}

TEST(VoxelChanges, OfScansAreThoseOfTheirVoxels)
{
  for (const bool decodes_voxels : {false, true}) {
    FrameEncoder encoder(StreamFormat::Version1, 4, Effort::Balanced);
    BothDecoders decoders;
    decoders.setDecodesVoxels(decodes_voxels);
    ChangingFrames frames(8);
    for (unsigned int i = 0; i < 12; ++i) {
      SCOPED_TRACE(i);
      scan::ScanFrame scan = makeCamera();
      addPoints(scan, i);
      const bool has_points = i != 6 && i != 7;
      const Bytes bytes =
          has_points ? encoded(encoder, scan) : encoded(encoder, frames.next(20));
      ASSERT_EQ(decoders.decode(bytes), CompressionCode::Ok);
      EXPECT_EQ(decoders.statistics().has_points, has_points);
      ASSERT_FALSE(HasFailure());
    }
  }
}

TEST(VoxelChanges, OfAScanTellWhatWasLeftOutAsWholeFramesDo)
{
  FrameEncoder encoder(StreamFormat::Version1, 4, Effort::Balanced);
  scan::ScanFrame scan = makeCamera();
  scan.grid.depth = 10;
  scan.grid.first_index.fill(-512);
  scan.rays.pose.origin.fill(std::int64_t{1} << (9 + 16));
  addPoints(scan, 1);
  const Bytes bytes = encoded(encoder, scan);
  VoxelFrame frame;
  FrameDecoder whole;
  const CompressionStatus expected = whole.decode(bytes.data(), bytes.size(), frame);
  ASSERT_TRUE(expected.ok());
  ASSERT_NE(expected.message().find("outside its grid"), std::string::npos) << expected;
  FrameDecoder decoder;
  VoxelChanges changes;
  const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), changes);
  EXPECT_EQ(status.message(), expected.message());
}

TEST(VoxelChanges, AfterWholeFramesAreFromNothingOrFromTheLastOne)
{
  for (const Content& content : all_contents) {
    SCOPED_TRACE(content.name);
    Scene scene(content);
    FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Fast);
    FrameDecoder decoder;
    VoxelFrame whole;
    Applied applied;
    for (unsigned int i = 0; i < 3; ++i)
      ASSERT_EQ(decoded(decoder, encoded(encoder, scene.next()), whole),
                CompressionCode::Ok);
    applied.replace(whole);
    VoxelFrame latest;
    const bool is_known = decoder.latestVoxels(latest);
    EXPECT_TRUE(voxelsOf(latest) == (is_known ? voxelsOf(whole) : Voxels()));
    const VoxelFrame next = scene.next();
    const Bytes bytes = encoded(encoder, next);
    VoxelChanges changes;
    ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), changes).ok());
    EXPECT_EQ(changes.is_from_nothing, !is_known);
    applied.apply(changes, next);
    applied.expectLatest(decoder);
  }
}

TEST(VoxelChanges, OfANewDecoderAreNone)
{
  FrameDecoder decoder;
  VoxelFrame latest = emptyFrame(3);
  latest.keys = {1};
  latest.intensities = {1};
  EXPECT_FALSE(decoder.latestVoxels(latest));
  EXPECT_EQ(latest.size(), 0u);
}

TEST(VoxelChanges, OfForgedFramesAreThoseOfWholeFramesOrNone)
{
  for (const unsigned int bits : {8u, 0u}) {
    ChangingFrames frames(bits);
    FrameEncoder encoder(StreamFormat::Version1, 100, Effort::Balanced);
    std::vector<Bytes> stream;
    for (unsigned int i = 0; i < 4; ++i)
      stream.push_back(encoded(encoder, frames.next(40)));
    const std::uint32_t reference = takeApart(stream[1]).checksum;
    const Parts parts = takeApart(stream[2]);
    ASSERT_TRUE(parts.header.is_of_changes);
    std::size_t taken = 0;
    std::size_t refused = 0;
    for (std::size_t bit = 0; bit < 8 * parts.payload.size(); bit += 5) {
      SCOPED_TRACE(bit);
      Parts forged = parts;
      forged.payload = flipped(parts.payload, bit);
      // Half of them have another number of voxels, too.
      for (const unsigned int fewer : {0u, 1u}) {
        forged.header.voxel_count = parts.header.voxel_count - fewer;
        BothDecoders decoders;
        decoders.decode(stream[0]);
        decoders.decode(stream[1]);
        const CompressionCode code = decoders.decode(putTogether(forged, reference));
        (code == CompressionCode::Ok ? taken : refused) += 1;
        if (code != CompressionCode::Ok) {
          EXPECT_EQ(decoders.decode(stream[2]), CompressionCode::Ok);
          EXPECT_EQ(decoders.decode(stream[3]), CompressionCode::Ok);
        }
        ASSERT_FALSE(HasFailure());
      }
    }
    EXPECT_GT(refused, 100u);
    EXPECT_GT(taken, 0u);
  }
}

TEST(VoxelChanges, AreFromNothingAfterMemoryWasDropped)
{
  for (const Effort effort : all_efforts)
    for (const bool has_colours : {false, true}) {
      SCOPED_TRACE(nameOf(effort));
      std::mt19937_64 random(5);
      ChangingFrames frames(8);
      FrameEncoder encoder(StreamFormat::Version1, 100, effort);
      const auto next = [&] {
        VoxelFrame frame = frames.next(40);
        if (has_colours)
          addColours(random, 5, frame);
        return frame;
      };
      DecoderLimits limits;
      limits.budget = std::make_shared<MemoryBudget>(std::size_t{1} << 24);
      FrameDecoder decoder(limits);
      std::vector<FrameDecoder> others;
      VoxelChanges changes;
      VoxelFrame latest;
      for (unsigned int i = 0; i < 3; ++i) {
        const Bytes bytes = encoded(encoder, next());
        ASSERT_TRUE(decoder.decode(bytes.data(), bytes.size(), changes).ok());
        EXPECT_EQ(changes.is_from_nothing, i == 0);
      }
      ASSERT_TRUE(decoder.latestVoxels(latest));
      FrameEncoder other(StreamFormat::Version1, 1, effort);
      const Bytes of_others = encoded(other, frames.next(0));
      while (limits.budget->drops() == 0) {
        others.emplace_back(limits);
        VoxelFrame back;
        ASSERT_EQ(decoded(others.back(), of_others, back), CompressionCode::Ok);
      }
      EXPECT_FALSE(decoder.latestVoxels(latest));
      EXPECT_EQ(latest.size(), 0u);
      const Bytes p_frame = encoded(encoder, next());
      EXPECT_EQ(decoder.decode(p_frame.data(), p_frame.size(), changes).code(),
                CompressionCode::MissingReference);
      EXPECT_FALSE(changes.is_from_nothing);
      encoder.requestIFrame();
      const VoxelFrame frame = next();
      const Bytes i_frame = encoded(encoder, frame);
      ASSERT_TRUE(decoder.decode(i_frame.data(), i_frame.size(), changes).ok());
      EXPECT_TRUE(changes.is_from_nothing);
      Applied().apply(changes, frame);
    }
}
TEST(VoxelChanges, AreRightOrFromNothingWhereverMemoryFails)
{
  for (const Content& content : {all_contents[0], all_contents[4]}) {
    SCOPED_TRACE(content.name);
    ChangingFrames frames(content.bits);
    std::mt19937_64 random(2);
    FrameEncoder encoder(StreamFormat::Version1, 4, Effort::Fast);
    std::vector<VoxelFrame> sent;
    std::vector<Bytes> stream;
    for (unsigned int i = 0; i < 9; ++i) {
      sent.push_back(frames.next(30));
      if (content.colour_bits > 0)
        addColours(random, content.colour_bits, sent.back());
      stream.push_back(encoded(encoder, sent.back()));
    }
    std::size_t failures = 0;
    for (std::size_t failing = 0; failing < 6; ++failing)
      for (std::size_t number = 1;; ++number) {
        SCOPED_TRACE(std::to_string(failing) + ", " + std::to_string(number));
        FrameDecoder decoder;
        Applied applied;
        bool has_failed = false;
        for (std::size_t i = 0; i < stream.size(); ++i) {
          VoxelChanges changes;
          const FailingAllocation failure(i == failing ? number : 0);
          const CompressionStatus status =
              decoder.decode(stream[i].data(), stream[i].size(), changes);
          const Exemption exemption;
          has_failed |= i == failing && failure.hasFailed();
          if (status.ok())
            applied.apply(changes, sent[i]);
          else
            EXPECT_TRUE(status.code() == CompressionCode::OutOfMemory ||
                        status.code() == CompressionCode::MissingReference);
          EXPECT_TRUE(status.ok() || (i >= failing && i < (failing / 4 + 1) * 4));
        }
        ASSERT_FALSE(HasFailure());
        if (!has_failed)
          break;
        ++failures;
      }
    EXPECT_GT(failures, 20u);
  }
}
} // namespace
