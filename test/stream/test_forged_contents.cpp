/** \file
 * \brief Frames with valid checksums whose header has another content than the payload,
 * or impossible counts of it.
 */
#include "support/forged_frames.h"
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

TEST(ForgedContents, OfIFramesAreRefused)
{
  std::mt19937_64 random(6);
  std::vector<VoxelFrame> frames;
  for (int i = 0; i < 3; ++i) {
    frames.push_back(fineFrame(random, 8));
    addColours(random, 5, frames.back());
    addPointCounts(random, frames.back());
  }
  FrameEncoder encoder(StreamFormat::Version1, 10);
  const Bytes first = encoded(encoder, frames[0]);
  const Parts good = takeApart(first);
  ASSERT_GT(good.header.content.refinement_levels, 0u);
  using Change = std::function<void(Version1Header&)>;
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
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE(i);
    Parts parts = good;
    changes[i](parts.header);
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_NE(decoded(decoder, putTogether(parts), back), CompressionCode::Ok);
    EXPECT_EQ(decoded(decoder, first, back), CompressionCode::Ok);
    expectSameFrame(back, frames[0]);
  }
}

TEST(ForgedContents, OfFieldsAreRefused)
{
  std::mt19937_64 random(6);
  RoomStream room(roomSettings(6, 20));
  VoxelFrame frame = room.next();
  addPointCounts(random, frame);
  addFields(random, frame);
  FrameEncoder encoder(StreamFormat::Version1, 10);
  const Bytes first = encoded(encoder, frame);
  const Parts good = takeApart(first);
  using Change = std::function<void(Version1Header&)>;
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
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE(i);
    Parts parts = good;
    changes[i](parts.header);
    FrameDecoder decoder;
    VoxelFrame back;
    EXPECT_NE(decoded(decoder, putTogether(parts), back), CompressionCode::Ok);
    EXPECT_EQ(decoded(decoder, first, back), CompressionCode::Ok);
    expectSameFrame(back, frame);
  }
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
  FrameEncoder encoder(StreamFormat::Version1, 10);
  const Bytes first = encoded(encoder, frames[0]);
  const std::uint32_t checksum = takeApart(first).checksum;
  const Bytes second = encoded(encoder, frames[1]);
  ASSERT_FALSE(encoder.statistics().is_i_frame);
  const Parts good = takeApart(second);
  for (const auto& content : {supplement::Content{},
                              supplement::Content{0, 0, true},
                              supplement::Content{0, 1, true},
                              supplement::Content{1, 1, false},
                              supplement::Content{0, 1, false, true}}) {
    Parts parts = good;
    parts.header.content = content;
    EXPECT_NE(answerTo(putTogether(parts, checksum), first, {second}, {frames[1]}),
              CompressionCode::Ok);
  }
}

} // namespace
