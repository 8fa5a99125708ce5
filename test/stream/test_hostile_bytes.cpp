// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Hostile bytes in the place of a frame, for all coders and all that frames
 * have: cut off, changed, random, with forged counts, with and without a valid
 * checksum. What is accepted is a whole frame, what is refused leaves the stream as it
 * was, and neither takes more memory than it may.
 */
#include "support/changing_frames.h"
#include "support/forged_frames.h"
#include "support/scan_frames.h"
#include "support/supplement_frames.h"
#include "support/test_memory.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

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
using namespace pcl_ext::io::test;
using pcl_ext::test::MemoryUse;

enum class HostileContent {
  Room,
  RoomOfOneBit,
  RoomOf16Bits,
  RoomWithDepths,
  RoomOf16BitsWithDepths,
  ColouredRoom,
  FieldsOfVoxels,
  ScanOfCamera,
  ScanOfLidar,
  FineVoxels,
  FewVoxels,
  FramesOfChanges
};

struct HostileKind {
  std::string name;
  StreamFormat format;
  Effort effort;
  HostileContent content;
  bool is_i_frame;
};

bool
isOfScans(HostileContent content)
{
  return content == HostileContent::ScanOfCamera ||
         content == HostileContent::ScanOfLidar;
}

bool
isOfChanges(HostileContent content)
{
  return content == HostileContent::FramesOfChanges;
}

/** \brief Whether an effort has another coder for a content than the one before it: scans
 * and changes are coded the same whatever the effort; balanced and small are one coder
 * with other models, for which these contents do. */
bool
isCodedDifferently(HostileContent content, Effort effort)
{
  using Content = HostileContent;
  if (effort == Effort::Fast)
    return true;
  if (effort == Effort::Balanced)
    return !isOfScans(content) && !isOfChanges(content);
  return content == Content::Room || content == Content::RoomOf16BitsWithDepths ||
         content == Content::ColouredRoom || content == Content::FewVoxels;
}

std::vector<HostileKind>
hostileKinds(StreamFormat format)
{
  using Content = HostileContent;
  if (format == StreamFormat::Published)
    return {{"PublishedI", format, Effort::Fast, Content::FewVoxels, true},
            {"PublishedP", format, Effort::Fast, Content::FewVoxels, false}};
  const std::pair<Content, const char*> contents[] = {
      {Content::Room, "Room"},
      {Content::RoomOfOneBit, "RoomOfOneBit"},
      {Content::RoomOf16Bits, "RoomOf16Bits"},
      {Content::RoomWithDepths, "RoomWithDepths"},
      {Content::RoomOf16BitsWithDepths, "RoomOf16BitsWithDepths"},
      {Content::ColouredRoom, "ColouredRoom"},
      {Content::FieldsOfVoxels, "FieldsOfVoxels"},
      {Content::ScanOfCamera, "ScanOfCamera"},
      {Content::ScanOfLidar, "ScanOfLidar"},
      {Content::FineVoxels, "FineVoxels"},
      {Content::FewVoxels, "FewVoxels"},
      {Content::FramesOfChanges, "FramesOfChanges"}};
  std::vector<HostileKind> kinds;
  for (const Effort effort : all_efforts)
    for (const auto& [content, name] : contents)
      for (const bool is_i_frame : {false, true})
        if (isCodedDifferently(content, effort))
          kinds.push_back({nameOf(effort) + name + (is_i_frame ? "I" : "P"),
                           format,
                           effort,
                           content,
                           is_i_frame});
  return kinds;
}

std::vector<VoxelFrame>
hostileFrames(HostileContent content)
{
  using Content = HostileContent;
  const bool has_depths =
      content == Content::RoomWithDepths || content == Content::RoomOf16BitsWithDepths;
  const bool is_wide =
      content == Content::RoomOf16Bits || content == Content::RoomOf16BitsWithDepths;
  RoomStream::Settings settings = roomSettings(6,
                                               9,
                                               has_depths,
                                               content == Content::RoomOfOneBit ? 1
                                               : is_wide                        ? 16
                                                                                : 8);
  settings.noise = 4;
  RoomStream room(settings);
  std::mt19937_64 random(5);
  VoxelFrame few = randomFrame(random, 4, 40);
  ChangingFrames changing(8);
  std::vector<VoxelFrame> frames;
  for (int i = 0; i < 4; ++i) {
    if (isOfChanges(content)) {
      frames.push_back(changing.next(40));
      continue;
    }
    if (content == Content::FewVoxels) {
      frames.push_back(few);
      walk(random, 10, few);
      continue;
    }
    frames.push_back(content == Content::FineVoxels ? fineFrame(random, 8)
                                                    : room.next());
    if (content == Content::ColouredRoom)
      addColours(random, 5, frames.back());
    if (content == Content::ColouredRoom || content == Content::FineVoxels)
      addPointCounts(random, frames.back());
    if (content == Content::FieldsOfVoxels)
      addFields(random, frames.back());
  }
  return frames;
}

std::vector<scan::ScanFrame>
hostileScans(HostileContent content)
{
  std::vector<scan::ScanFrame> scans;
  for (unsigned int i = 0; i < 4; ++i) {
    const bool is_camera = content == HostileContent::ScanOfCamera;
    scans.push_back(is_camera ? makeCamera() : makeLidar());
    if (!is_camera)
      fireOddRowsFirst(scans.back());
    addPoints(scans.back(), i, !is_camera, is_camera ? 40 : 5);
    addFields(scans.back(), i);
  }
  return scans;
}

/** \brief Same voxels, at the same places except for a micrometre. */
bool
looksLike(const VoxelFrame& frame, const VoxelFrame& expected)
{
  if (frame.keys != expected.keys || frame.intensities != expected.intensities ||
      frame.grid.depth != expected.grid.depth)
    return false;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::uint32_t position : {0u, (1u << expected.grid.depth) - 1})
      if (!(std::abs(frame.grid.centre(axis, position) -
                     expected.grid.centre(axis, position)) < 1e-6))
        return false;
  return true;
}

/** \brief A stream of four frames, of which a receiver has decoded two. The third is
 * replaced by hostile bytes. */
class HostileBytes : public testing::TestWithParam<HostileKind> {
protected:
  static constexpr std::size_t replaced = 2;

  HostileBytes()
  {
    FrameEncoder encoder(GetParam().format, 100, GetParam().effort);
    const auto add = [&](const auto& frame) {
      if (bytes_.size() == replaced && GetParam().is_i_frame)
        encoder.requestIFrame();
      bytes_.push_back(encoded(encoder, frame));
    };
    if (!isOfScans(GetParam().content)) {
      frames_ = hostileFrames(GetParam().content);
      for (const VoxelFrame& frame : frames_)
        add(frame);
    }
    else
      for (const scan::ScanFrame& scan : hostileScans(GetParam().content)) {
        frames_.push_back(frameOf(scan));
        add(scan);
      }
    begin();
  }

  const Bytes&
  genuine() const
  {
    return bytes_[replaced];
  }

  /** \brief The genuine frame taken apart; of version 1 only. */
  Parts
  genuineParts() const
  {
    return takeApart(genuine());
  }

  Bytes
  withValidChecksum(const Parts& parts) const
  {
    return putTogether(
        parts, parts.header.is_i_frame ? 0 : takeApart(bytes_[replaced - 1]).checksum);
  }

  /** \brief The answer to hostile bytes. After a frame that was accepted the receiver
   * begins anew. */
  CompressionCode
  take(const Bytes& bytes)
  {
    // Of exactly that size, so that a sanitizer sees every read after it.
    const std::unique_ptr<std::uint8_t[]> copy(new std::uint8_t[bytes.size()]);
    std::copy(bytes.begin(), bytes.end(), copy.get());
    back_ = frames_[0];
    const MemoryUse memory_use;
    const CompressionStatus status = decoder_.decode(copy.get(), bytes.size(), back_);
    EXPECT_LE(memory_use.peak(), std::size_t{1} << 22);
    // A frame that is accepted may have points without a voxel.
    EXPECT_EQ(status.ok() && back_.points.outside_grid == 0, status.message().empty());
    if (status.ok()) {
      ++accepted_;
      EXPECT_TRUE(isConsistent(back_));
      begin();
    }
    else {
      ++refused_;
      EXPECT_TRUE(back_.keys.empty() && back_.intensities.empty() &&
                  back_.colours.empty() && back_.point_counts.empty() &&
                  back_.fieldValueCount() == 0);
    }
    return status.code();
  }

  /** \brief The answer to a frame with a valid checksum and the size that its payload
   * has. */
  CompressionCode
  takeForged(Parts parts)
  {
    parts.header.payload_size = parts.payload.size();
    return take(withValidChecksum(parts));
  }

  void
  expectUnharmed()
  {
    for (std::size_t i = replaced; i < frames_.size(); ++i) {
      ASSERT_EQ(decoded(decoder_, bytes_[i], back_), CompressionCode::Ok);
      expectSameVoxels(back_, frames_[i]);
    }
  }

  bool
  isFast() const
  {
    return GetParam().effort == Effort::Fast;
  }

  std::vector<VoxelFrame> frames_;
  std::vector<Bytes> bytes_;
  VoxelFrame back_;
  std::size_t accepted_ = 0;
  std::size_t refused_ = 0;

private:
  void
  begin()
  {
    decoder_ = FrameDecoder();
    VoxelFrame frame;
    for (std::size_t i = 0; i < replaced; ++i)
      ASSERT_EQ(decoded(decoder_, bytes_[i], frame), CompressionCode::Ok);
  }

  FrameDecoder decoder_;
};

TEST_P(HostileBytes, TruncatedFramesAreRefused)
{
  const std::size_t magic = GetParam().format == StreamFormat::Version1 ? 4 : 6;
  for (std::size_t size = 0; size < genuine().size(); ++size)
    ASSERT_EQ(take(prefixOf(genuine(), size)),
              size == 0      ? CompressionCode::EndOfStream
              : size < magic ? CompressionCode::NoFrame
                             : CompressionCode::Truncated)
        << size;
  expectUnharmed();
}

TEST_P(HostileBytes, FlippedFramesAreRefusedOrHarmless)
{
  const std::size_t bits = 8 * genuine().size();
  for (std::size_t bit = 0; bit < bits; bit += 1 + bits / 3000) {
    if (take(flipped(genuine(), bit)) != CompressionCode::Ok)
      continue;
    // It has no checksum: the number of an I-frame and the last bits of its box may
    // change.
    ASSERT_EQ(GetParam().format, StreamFormat::Published) << "bit " << bit;
    ASSERT_TRUE(GetParam().is_i_frame && bit / 8 >= 6 && bit / 8 < 75) << bit;
    ASSERT_TRUE(looksLike(back_, frames_[replaced])) << "bit " << bit;
  }
  expectUnharmed();
}

/** \brief With valid checksums, so that payloads are read. */
class HostilePayloads : public HostileBytes {};

TEST_P(HostilePayloads, TruncationsAreRefusedOrFrames)
{
  Parts parts = genuineParts();
  const std::size_t size = parts.payload.size();
  for (std::size_t end = size; end > 0;) {
    // Each of the last bytes, where the states of the entropy coders end.
    end -= end + 16 > size ? 1 : std::min(end, 1 + size / 500);
    parts.payload.resize(end);
    takeForged(parts);
  }
  // After the end the context coder reads zeros, which may be the intensities, four
  // fifths of the bytes of some; the number of voxels is hardly ever right.
  EXPECT_LT(6 * accepted_, 5 * (accepted_ + refused_));
  EXPECT_TRUE(!isFast() || accepted_ == 0);
  expectUnharmed();
}

TEST_P(HostilePayloads, LongerOnesAreRefused)
{
  // A row of bits is shorter than what is read of it by its last zeros, four bytes at
  // most.
  Parts parts = genuineParts();
  parts.payload.resize(parts.payload.size() + 4, 0);
  for (std::size_t more = 1; more < 40; ++more) {
    parts.payload.push_back(static_cast<std::uint8_t>(more % 3));
    EXPECT_EQ(takeForged(parts), CompressionCode::Corrupt);
  }
  expectUnharmed();
}

TEST_P(HostilePayloads, FlipsAreRefusedOrFrames)
{
  std::mt19937_64 random(1);
  const Parts good = genuineParts();
  constexpr std::size_t rounds = 300;
  for (std::size_t round = 0; round < rounds; ++round) {
    Parts parts = good;
    for (std::uint64_t i = 1 + below(random, 3); i > 0; --i)
      parts.payload = flipped(parts.payload, below(random, 8 * parts.payload.size()));
    takeForged(parts);
  }
  // The last state of rANS shows most of what is wrong, but is no checksum. Within
  // coarse voxels any bits are positions, and the low bits of large steps beside a ray
  // any steps.
  if (isFast() && GetParam().content != HostileContent::FineVoxels &&
      !isOfScans(GetParam().content)) {
    EXPECT_GT(10 * refused_, 9 * rounds);
  }
  expectUnharmed();
}

TEST_P(HostilePayloads, RandomBytesAreRefusedOrFrames)
{
  std::mt19937_64 random(2);
  const Parts good = genuineParts();
  constexpr std::size_t rounds = 300;
  for (std::size_t round = 0; round < rounds; ++round) {
    Parts parts = good;
    parts.payload.resize(below(random, round % 10 == 0 ? 4000 : 150));
    const std::uint64_t kind = below(random, 4);
    for (std::uint8_t& byte : parts.payload)
      byte = static_cast<std::uint8_t>(kind == 0   ? 0
                                       : kind == 1 ? 0xff
                                       : kind == 2 ? random() & random() & random()
                                                   : random());
    const std::uint64_t counts[] = {
        1, 2, good.header.voxel_count, below(random, 5000) + 1, 1 << 16};
    parts.header.voxel_count = counts[below(random, 5)];
    takeForged(parts);
  }
  EXPECT_GT(3 * refused_, 2 * rounds);
  expectUnharmed();
}

TEST_P(HostilePayloads, OfOtherCountsAndKindsAreRefused)
{
  const Parts good = genuineParts();
  // Scans have no voxels.
  const auto counted = isOfScans(GetParam().content) ? &Version1Header::point_count
                                                     : &Version1Header::voxel_count;
  const std::uint64_t count = good.header.*counted;
  for (const std::uint64_t other :
       {std::uint64_t{0}, std::uint64_t{1}, count - 1, count + 1, 2 * count, ~count}) {
    Parts parts = good;
    parts.header.*counted = other;
    EXPECT_NE(takeForged(parts), CompressionCode::Ok) << other;
  }
  Parts parts = good;
  parts.payload.clear();
  EXPECT_NE(takeForged(parts), CompressionCode::Ok);
  // A frame of the other kind that fails must not have changed what is learnt.
  parts = good;
  parts.header.is_i_frame = !parts.header.is_i_frame;
  takeForged(parts);
  expectUnharmed();
}

TEST_P(HostilePayloads, ConstantBitsAreNoManyVoxels)
{
  // All decisions are 1, or 0: every voxel of the grid, or as few as there can be.
  for (const unsigned int depth : {1u, 4u, 21u})
    for (const std::uint64_t voxels : {2u, 64u, 4000u, 1u << 14})
      for (const Bytes& payload :
           {Bytes{}, Bytes{0}, Bytes(1, 0xff), Bytes(5000, 0xff), Bytes(5000, 0)}) {
        Parts parts = genuineParts();
        parts.header.grid = emptyFrame(depth).grid;
        parts.header.voxel_count = voxels;
        parts.payload = payload;
        EXPECT_NE(takeForged(parts), CompressionCode::Ok);
      }
  expectUnharmed();
}

INSTANTIATE_TEST_SUITE_P(Version1,
                         HostileBytes,
                         testing::ValuesIn(hostileKinds(StreamFormat::Version1)),
                         [](const auto& kind) { return kind.param.name; });
INSTANTIATE_TEST_SUITE_P(Published,
                         HostileBytes,
                         testing::ValuesIn(hostileKinds(StreamFormat::Published)),
                         [](const auto& kind) { return kind.param.name; });
INSTANTIATE_TEST_SUITE_P(Version1,
                         HostilePayloads,
                         testing::ValuesIn(hostileKinds(StreamFormat::Version1)),
                         [](const auto& kind) { return kind.param.name; });

} // namespace
