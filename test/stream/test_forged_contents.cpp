// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/forged_frames.h"
#include "support/scan_frames.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr std::uint64_t huge = std::numeric_limits<std::uint64_t>::max();
using Change = std::function<void(Version1Header&)>;

/** \brief Expects that an I-frame is refused with each change of its header, and decoded
 * after that. */
void
expectRefusedWith(const std::vector<Change>& changes,
                  const Bytes& i_frame,
                  const VoxelFrame& frame)
{
  const Parts good = takeApart(i_frame);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE(i);
    Parts parts = good;
    changes[i](parts.header);
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_NE(decoded(decoder, putTogether(parts), back), CompressionCode::Ok);
    EXPECT_EQ(decoded(decoder, i_frame, back), CompressionCode::Ok);
    expectSameFrame(back, frame);
  }
}

TEST(ForgedContents, OfIFramesAreRefused)
{
  std::mt19937_64 random(6);
  VoxelFrame frame = fineFrame(random, 8);
  addColours(random, 5, frame);
  addPointCounts(random, frame);
  addFields(random, frame);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Bytes first = encoded(encoder, frame);
  ASSERT_GT(takeApart(first).header.content.refinement_levels, 0u);
  const std::vector<Change> changes = {
      [](Version1Header& h) { h.content.refinement_levels = 0; },
      [](Version1Header& h) { ++h.content.refinement_levels; },
      [](Version1Header& h) { h.content.refinement_levels = h.grid.depth; },
      [](Version1Header& h) { h.content.refinement_levels = 31; },
      [](Version1Header& h) { h.content.colour_bits = 0; },
      [](Version1Header& h) { h.content.colour_bits = 6; },
      [](Version1Header& h) { h.content.colour_bits = 9; },
      [](Version1Header& h) { h.content.has_point_counts = false; },
      [](Version1Header& h) { h.intensity_scale.bits = 0; },
      [](Version1Header& h) { h.coarse_voxel_count = 0; },
      [](Version1Header& h) { --h.coarse_voxel_count; },
      [](Version1Header& h) { h.coarse_voxel_count = h.voxel_count + 1; },
      [](Version1Header& h) { h.coarse_voxel_count = huge; },
      [](Version1Header& h) { --h.voxel_count; },
      [](Version1Header& h) { ++h.voxel_count; },
      [](Version1Header& h) { h.point_count = h.voxel_count - 1; },
      [](Version1Header& h) { --h.point_count; },
      [](Version1Header& h) { ++h.point_count; },
      [](Version1Header& h) { h.point_count = huge; },
      [](Version1Header& h) { h.supplement_size = 0; },
      [](Version1Header& h) { --h.supplement_size; },
      [](Version1Header& h) { h.supplement_size = h.payload_size + 1; },
      [](Version1Header& h) { h.supplement_size = huge; },
      [](Version1Header& h) {
        h.grid.origin = {1e300, 0.0, 0.0};
      },
      [](Version1Header& h) {
        h.grid.origin = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
      },
      [](Version1Header& h) { h.has_depth_model = true; },
      [](Version1Header& h) { h.fields.pop_back(); },
      [](Version1Header& h) { h.fields[0].type = FieldType{0}; },
      [](Version1Header& h) { h.fields[0].count = 2; },
      [](Version1Header& h) { h.fields[0].count = 0xffffffff; },
      [](Version1Header& h) {
        h.fields[1].step = std::numeric_limits<double>::infinity();
      },
      [](Version1Header& h) { h.viewpoint[2] = (1 << 22) + 1; },
      [](Version1Header& h) { h.content.has_fields = false; }};
  expectRefusedWith(changes, first, frame);
}

TEST(ForgedContents, PaddingIsOfZerosAtTheEndOfAnIFrame)
{
  std::mt19937_64 random(6);
  VoxelFrame frame = fineFrame(random, 8);
  addColours(random, 5, frame);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Parts i_frame = takeApart(encoded(encoder, frame));
  VoxelFrame next = fineFrame(random, 8);
  addColours(random, 5, next);
  const Parts p_frame = takeApart(encoded(encoder, next));
  ASSERT_FALSE(p_frame.header.is_i_frame);
  const auto padded = [](Parts parts, std::uint64_t size, std::uint8_t last = 0) {
    parts.payload.resize(parts.payload.size() + 3);
    parts.payload.back() = last;
    parts.header.padding_size = size;
    return parts;
  };
  FrameDecoder decoder;
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, putTogetherSized(padded(i_frame, 3)), back),
            CompressionCode::Ok);
  expectSameFrame(back, frame);
  const std::uint64_t all = i_frame.payload.size() + 3;
  for (const Parts& wrong : {padded(i_frame, 0),
                             padded(i_frame, 2),
                             padded(i_frame, 4),
                             padded(i_frame, all + 1),
                             padded(i_frame, huge),
                             padded(i_frame, 3, 1),
                             padded(p_frame, 3)})
    EXPECT_EQ(
        decoded(decoder,
                putTogetherSized(wrong, wrong.header.is_i_frame ? 0 : i_frame.checksum),
                back),
        CompressionCode::Corrupt)
        << wrong.header.padding_size;
}

TEST(ForgedContents, OfLayoutsAreRefused)
{
  using Layout = MessageLayout;
  std::mt19937_64 random(6);
  RoomStream room(roomSettings(6, 20));
  VoxelFrame frame = room.next();
  addPointCounts(random, frame);
  Layout layout;
  layout.fields.resize(2);
  layout.fields[0].name = "x";
  layout.fields[1].name = "pair";
  layout.fields[1].count = 2;
  layout.fields[1].offset = 8;
  layout.point_step = 16;
  frame.layout = std::make_shared<Layout>(layout);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Bytes first = encoded(encoder, frame);
  const auto with = [](const std::function<void(Layout&)>& change) {
    return [change](Version1Header& h) {
      auto changed = std::make_shared<Layout>(*h.layout);
      change(*changed);
      h.layout = std::move(changed);
    };
  };
  expectRefusedWith({with([](Layout& l) { l.fields[0].name.clear(); }),
                     with([](Layout& l) { l.fields[0].name.assign(65, 'a'); }),
                     with([](Layout& l) { l.fields[0].type = FieldType{0}; }),
                     with([](Layout& l) { l.fields[0].type = FieldType{9}; }),
                     with([](Layout& l) { l.fields[0].step = 1.0; }),
                     with([](Layout& l) { l.fields[0].count = 0; }),
                     with([](Layout& l) { l.fields[1].count = 3; }),
                     with([](Layout& l) { l.fields[1].count = 0xffffffff; }),
                     with([](Layout& l) { l.fields[1].offset = 9; }),
                     with([](Layout& l) { l.fields[1].offset = 0xfffffffc; }),
                     with([](Layout& l) { l.fields.resize(200, l.fields[0]); }),
                     with([](Layout& l) { l.point_step = 0; }),
                     with([](Layout& l) { l.point_step = 4097; }),
                     with([](Layout& l) { l.row_padding = 65537; }),
                     with([](Layout& l) { l.row_padding = 0xffffffff; })},
                    first,
                    frame);
  // A P-frame has none.
  Bytes p_frame = encoded(encoder, frame);
  constexpr std::size_t content_offset = flags_offset + 1 + 4;
  ASSERT_EQ(p_frame[content_offset], 64);
  p_frame[content_offset] = 64 + 128; // the first byte of 64 + 2048
  p_frame.insert(p_frame.begin() + content_offset + 1, 16);
  EXPECT_EQ(answerTo(withChecksum(p_frame, takeApart(first).checksum), first, {}, {}),
            CompressionCode::Corrupt);
}

/** \brief A scan of a camera or a lidar. */
scan::ScanFrame
scanOf(bool is_camera, unsigned int seed)
{
  scan::ScanFrame frame = is_camera ? makeCamera() : makeLidar();
  if (!is_camera)
    fireOddRowsFirst(frame);
  addPoints(frame, seed);
  return frame;
}

TEST(ForgedContents, OfScansAreRefused)
{
  constexpr std::int32_t beyond_one = (1 << 30) + 1;
  constexpr std::int32_t beyond_step = (1 << 29) + 1;
  constexpr std::int64_t far_away = (std::int64_t{1} << 42) + 1;
  constexpr std::int64_t steep = std::int64_t{1} << 45;
  using scan::ScanLayout;
  using ScanChange = std::function<void(ScanLayout&)>;
  const std::vector<ScanChange> of_all = {
      [](ScanLayout& s) { s.width = 0xffffffff; },
      [](ScanLayout& s) { ++s.width; },
      [](ScanLayout& s) { s.height = 0; },
      [](ScanLayout& s) { s.order = scan::PointOrder{3}; },
      [](ScanLayout& s) { s.rays.pose.origin[1] = far_away; },
      [](ScanLayout& s) {
        s.rays.pose.origin[2] = std::numeric_limits<std::int64_t>::min();
      }};
  const std::vector<ScanChange> of_cameras = {
      [](ScanLayout& s) { s.order = scan::PointOrder::ColumnByColumn; },
      [](ScanLayout& s) { s.rays.pose.vectors[0][2] = steep + 1; },
      [](ScanLayout& s) { s.rays.pose.vectors[1][0] = steep / s.width + 1; },
      [](ScanLayout& s) { s.rays.pose.vectors[2][1] = -steep / s.height - 1; },
      [](ScanLayout& s) {
        s.rays.pose.vectors[0][0] = s.rays.pose.vectors[1][0] = steep / s.width;
        s.rays.pose.vectors[2][0] = steep / s.height;
      },
      [](ScanLayout& s) {
        s.rays.pose.vectors[1][1] = std::numeric_limits<std::int64_t>::min();
      }};
  const std::vector<ScanChange> of_lidars = {
      [](ScanLayout& s) { s.firing_order[3] = 8; },
      [=](ScanLayout& s) { s.rays.pose.vectors[2][1] = beyond_one; },
      [](ScanLayout& s) { s.rays.motion.origin[1] = -far_away; },
      [](ScanLayout& s) { s.rays.motion.vectors[1][2] = steep / s.width + 1; },
      [](ScanLayout& s) {
        s.rays.turns[0] = {1 << 30, 1 << 16};
      },
      [](ScanLayout& s) { s.rays.turns.clear(); },
      [](ScanLayout& s) { s.rays.turns.resize(32, s.rays.turns[0]); },
      [](ScanLayout& s) { s.rays.rows.pop_back(); },
      [](ScanLayout& s) { s.rays.rows[3].cosine = s.rays.rows[3].sine = 1 << 30; },
      [=](ScanLayout& s) { s.rays.rows[1].rise = -beyond_step; },
      [=](ScanLayout& s) { s.rays.rows[1].run = s.rays.rows[1].rise = 1 << 29; },
      [=](ScanLayout& s) { s.rays.rows[2].along = beyond_one; },
      [=](ScanLayout& s) { s.rays.rows[3].across = -beyond_one; },
      [=](ScanLayout& s) { s.rays.rows[4].up = beyond_one; }};
  for (const bool is_camera : {true, false}) {
    const scan::ScanFrame scan = scanOf(is_camera, 7);
    FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
    const Bytes first = encoded(encoder, scan);
    std::vector<Change> changes;
    for (const auto& of_scans : {of_all, is_camera ? of_cameras : of_lidars})
      for (const ScanChange& change : of_scans)
        changes.push_back([change](Version1Header& h) { change(h.scan); });
    changes.push_back([](Version1Header& h) { ++h.point_count; });
    changes.push_back([](Version1Header& h) { h.point_count = 0; });
    changes.push_back([](Version1Header& h) { h.content.has_point_counts = false; });
    changes.push_back([](Version1Header& h) { h.content.refinement_levels = 2; });
    changes.push_back([](Version1Header& h) { h.has_depth_model = true; });
    expectRefusedWith(changes, first, frameOf(scan));
  }
}

TEST(ForgedContents, OfPlacementsAreRefused)
{
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Bytes first = encoded(encoder, scanOf(false, 8));
  scan::ScanFrame moved = scanOf(false, 9);
  moved.rays.pose.origin[0] += 1000;
  const VoxelFrame next = frameOf(moved);
  const Bytes second = encoded(encoder, moved);
  const Parts good = takeApart(second);
  ASSERT_TRUE(good.header.placement);
  const std::uint32_t checksum = takeApart(first).checksum;
  const auto answer_to = [&](const Parts& parts) {
    return answerTo(putTogether(parts, checksum), first, {second}, {next});
  };
  EXPECT_EQ(answer_to(good), CompressionCode::Ok);
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  for (const std::int64_t number : {(std::int64_t{1} << 42) + 1, least}) {
    Parts parts = good;
    parts.header.placement->pose.origin[2] = number;
    EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
    parts = good;
    parts.header.placement->pose.vectors[1][1] = number;
    EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
    parts = good;
    parts.header.placement->motion.vectors[1][1] = number;
    EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
  }
  for (const std::uint32_t width : {0u, 89u, 1u << 16, (1u << 16) + 1}) {
    Parts parts = good;
    parts.header.placement->width = width;
    EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
  }
  // In a frame without a scan, and in an I-frame.
  Parts parts = good;
  parts.header.content.has_scan = false;
  EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
  parts = takeApart(first);
  parts.header.placement = good.header.placement;
  VoxelFrame back;
  FrameDecoder decoder;
  EXPECT_EQ(decoded(decoder, putTogether(parts), back), CompressionCode::Corrupt);
}

TEST(ForgedContents, OfPFramesAreThoseOfTheirIFrames)
{
  std::mt19937_64 random(6);
  RoomStream room(roomSettings(6, 20));
  std::vector<VoxelFrame> frames;
  for (int i = 0; i < 2; ++i) {
    frames.push_back(room.next());
    addColours(random, 5, frames.back());
  }
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Bytes first = encoded(encoder, frames[0]);
  const std::uint32_t checksum = takeApart(first).checksum;
  const Bytes second = encoded(encoder, frames[1]);
  ASSERT_FALSE(encoder.statistics().is_i_frame);
  const Parts good = takeApart(second);
  for (const auto& content : {supplement::Content{},
                              supplement::Content{0, 0, true},
                              supplement::Content{0, 1, true},
                              supplement::Content{1, 1, false},
                              supplement::Content{0, 1, false, true},
                              supplement::Content{0, 1, true, false, true}}) {
    Parts parts = good;
    parts.header.content = content;
    EXPECT_NE(answerTo(putTogether(parts, checksum), first, {second}, {frames[1]}),
              CompressionCode::Ok);
  }
}

} // namespace
