// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames with valid checksums whose header has another content than the payload,
 * or impossible counts of it.
 */
#include "support/forged_frames.h"
#include "support/image_frames.h"
#include "support/supplement_frames.h"
#include "support/voxel_frames.h"
#include "support/voxel_streams.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
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
      [](Version1Header& h) { h.has_depth_model = true; }};
  expectRefusedWith(changes, first, frame);
}

TEST(ForgedContents, PaddingIsOfZerosAtTheEndOfAnIFrame)
{
  std::mt19937_64 random(6);
  VoxelFrame frame = fineFrame(random, 8);
  addColours(random, 5, frame);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Parts i_frame = takeApart(encoded(encoder, frame));
  const VoxelFrame next = [&] {
    VoxelFrame other = fineFrame(random, 8);
    addColours(random, 5, other);
    return other;
  }();
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

TEST(ForgedContents, OfFieldsAreRefused)
{
  std::mt19937_64 random(6);
  RoomStream room(roomSettings(6, 20));
  VoxelFrame frame = room.next();
  addPointCounts(random, frame);
  addFields(random, frame);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Bytes first = encoded(encoder, frame);
  const std::vector<Change> changes = {
      [](Version1Header& h) { h.fields.clear(); },
      [](Version1Header& h) { h.fields.pop_back(); },
      [](Version1Header& h) { h.fields.resize(65, h.fields[0]); },
      [](Version1Header& h) { h.fields[0].name.clear(); },
      [](Version1Header& h) { h.fields[0].name.assign(65, 'a'); },
      [](Version1Header& h) { h.fields[0].type = FieldType{0}; },
      [](Version1Header& h) { h.fields[0].type = FieldType{9}; },
      [](Version1Header& h) { h.fields[0].count = 0; },
      [](Version1Header& h) { h.fields[0].count = 2; },
      [](Version1Header& h) { h.fields[0].count = 4097; },
      [](Version1Header& h) { h.fields[0].count = 0xffffffff; },
      [](Version1Header& h) { h.fields[1].step = -1.0; },
      [](Version1Header& h) {
        h.fields[1].step = std::numeric_limits<double>::infinity();
      },
      [](Version1Header& h) { h.viewpoint[2] = (1 << 22) + 1; },
      [](Version1Header& h) { h.viewpoint[0] = -(1 << 22) - 1; },
      [](Version1Header& h) { h.content.has_fields = false; }};
  expectRefusedWith(changes, first, frame);
}

TEST(ForgedContents, OfImagesAreRefused)
{
  std::mt19937_64 random(7);
  constexpr std::int32_t beyond_one = (1 << 30) + 1;
  constexpr std::int64_t far_away = (std::int64_t{1} << 38) + 1;
  constexpr std::int64_t steep = std::int64_t{1} << 46;
  using ImageChange = std::function<void(PointImage&)>;
  const std::vector<ImageChange> of_all = {
      [](PointImage& i) { i.width = 0; },
      [](PointImage& i) { i.width = 0xffffffff; },
      [](PointImage& i) { i.width = i.height = 1 << 13; },
      [](PointImage& i) { ++i.width; },
      [](PointImage& i) { i.height = 0; },
      [](PointImage& i) { --i.height; },
      [](PointImage& i) { i.rays.pose.origin[1] = far_away; },
      [](PointImage& i) {
        i.rays.pose.origin[2] = std::numeric_limits<std::int64_t>::min();
      },
      [](PointImage& i) { i.rays = RayModel(); }};
  const std::vector<ImageChange> of_cameras = {
      [](PointImage& i) { i.rays.pose.vectors[0][2] = steep + 1; },
      [](PointImage& i) { i.rays.pose.vectors[1][0] = steep / i.width + 1; },
      [](PointImage& i) { i.rays.pose.vectors[2][1] = -steep / i.height - 1; },
      [](PointImage& i) {
        i.rays.pose.vectors[0][0] = i.rays.pose.vectors[1][0] = steep / i.width;
        i.rays.pose.vectors[2][0] = steep / i.height;
      },
      [](PointImage& i) {
        i.rays.pose.vectors[1][1] = std::numeric_limits<std::int64_t>::min();
      }};
  const std::vector<ImageChange> of_lidars = {
      [=](PointImage& i) { i.rays.pose.vectors[2][1] = beyond_one; },
      [](PointImage& i) {
        i.rays.turns[0] = {1 << 30, 1 << 16};
      },
      [](PointImage& i) { i.rays.turns.pop_back(); },
      [](PointImage& i) { i.rays.rows.pop_back(); },
      [](PointImage& i) { i.rays.rows[3].cosine = i.rays.rows[3].sine = 1 << 30; },
      [=](PointImage& i) { i.rays.rows[0].run = beyond_one; },
      [=](PointImage& i) { i.rays.rows[1].rise = -beyond_one; },
      [=](PointImage& i) { i.rays.rows[2].along = beyond_one; },
      [=](PointImage& i) { i.rays.rows[3].across = -beyond_one; },
      [=](PointImage& i) { i.rays.rows[4].up = beyond_one; }};
  for (const bool is_camera : {true, false}) {
    const VoxelFrame frame = is_camera
                                 ? imageFrame(random, planarImage(48, 32), 8)
                                 : imageFrame(random, spinningImage(48, 16, 8), 8);
    FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
    const Bytes first = encoded(encoder, frame);
    ASSERT_TRUE(encoder.statistics().has_image);
    std::vector<Change> changes;
    for (const auto& of_images : {of_all, is_camera ? of_cameras : of_lidars})
      for (const ImageChange& change : of_images)
        changes.push_back([change](Version1Header& h) { change(h.image); });
    expectRefusedWith(changes, first, frame);
  }
}

TEST(ForgedContents, OfPointsAtASensorOutsideTheGridAreRefused)
{
  std::mt19937_64 random(9);
  PointImage image = planarImage(48, 32);
  image.has_points_at_sensor = true;
  VoxelFrame frame = imageFrame(random, image, 8);
  addPointsAtSensor(random, frame);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const Parts good = takeApart(encoded(encoder, frame));
  ASSERT_TRUE(good.header.content.has_image);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const std::int64_t position : {-1, 256}) {
      Parts parts = good;
      parts.header.image.rays.pose.origin[axis] = position * (1 << 16);
      VoxelFrame back;
      FrameDecoder decoder;
      EXPECT_EQ(decoded(decoder, putTogether(parts), back), CompressionCode::Corrupt);
    }
}

TEST(ForgedContents, OfRayPosesAreRefused)
{
  std::mt19937_64 random(8);
  PointImage image = spinningImage(48, 16, 8);
  FrameEncoder encoder(StreamFormat::Version1, 10, Effort::Balanced);
  const VoxelFrame frame = imageFrame(random, image, 8);
  const Bytes first = encoded(encoder, frame);
  image.rays.pose.origin[0] += 1000;
  const VoxelFrame next = imageFrame(random, image, 8);
  const Bytes second = encoded(encoder, next);
  const Parts good = takeApart(second);
  ASSERT_TRUE(good.header.ray_pose);
  const std::uint32_t checksum = takeApart(first).checksum;
  const auto answer_to = [&](const Parts& parts) {
    return answerTo(putTogether(parts, checksum), first, {second}, {next});
  };
  EXPECT_EQ(answer_to(good), CompressionCode::Ok);
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  for (const std::int64_t number : {(std::int64_t{1} << 38) + 1, least}) {
    Parts parts = good;
    parts.header.ray_pose->origin[2] = number;
    EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
    parts = good;
    parts.header.ray_pose->vectors[1][1] = number;
    EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
  }
  // In a frame without an image, and in an I-frame.
  Parts parts = good;
  parts.header.content.has_image = false;
  EXPECT_EQ(answer_to(parts), CompressionCode::Corrupt);
  parts = takeApart(first);
  parts.header.ray_pose = good.header.ray_pose;
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
