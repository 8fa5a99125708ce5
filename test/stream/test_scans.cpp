// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "codec/scan/point_places.h"
#include "stream/frame_encoder.h"
#include "support/forged_frames.h"
#include "support/scan_frames.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::VoxelOutlierRemoval;

/** \brief The points of a scan in the order of their cloud. */
std::vector<std::size_t>
orderOf(const scan::ScanFrame& scan)
{
  std::vector<std::size_t> order(scan.pixels.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (scan.order != scan::PointOrder::ColumnByColumn)
    return order;
  const auto place_of = [&](std::size_t point) {
    const std::uint32_t row = scan.pixels[point] / scan.width;
    const auto rank =
        std::find(scan.firing_order.begin(), scan.firing_order.end(), row) -
        scan.firing_order.begin();
    const std::size_t ray = scan.pixels[point] % scan.width - scan.shiftOf(row);
    return ray * scan.height + static_cast<std::size_t>(rank);
  };
  std::sort(order.begin(), order.end(), [&](std::size_t one, std::size_t other) {
    return place_of(one) < place_of(other);
  });
  return order;
}

void
expectPoints(const VoxelFrame& frame, const scan::ScanFrame& scan)
{
  const bool is_organised = scan.order == scan::PointOrder::Organised;
  EXPECT_EQ(frame.cloudWidth(), is_organised ? scan.width : scan.pixels.size());
  EXPECT_EQ(frame.cloudHeight(), is_organised ? scan.height : 1);
  EXPECT_TRUE(frame.grid == scan.grid);
  ASSERT_EQ(frame.pointCount(), scan.pixels.size());
  std::vector<scan::Triple> places;
  scan::visitPlaces(scan,
                    [&places](const scan::Triple& place) { places.push_back(place); });
  const std::vector<std::size_t> order = orderOf(scan);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t point = order[i];
    ASSERT_EQ(frame.cloudIndex(i), is_organised ? scan.pixels[point] : i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t place = places[point][axis];
      const double edges = scan.is_on_lattice
                               ? 0.5 + static_cast<double>(place >> 32)
                               : std::ldexp(static_cast<double>(place), -32);
      ASSERT_NEAR(frame.points.positions[i][axis],
                  scan.grid.lowerCorner(axis) + edges * scan.grid.resolution,
                  1e-6 * scan.grid.resolution);
    }
    if (scan.intensity_scale.bits > 0) {
      ASSERT_EQ(frame.points.intensities[i], scan.intensities[point]);
    }
    if (scan.colour_bits > 0) {
      ASSERT_TRUE(frame.points.colours[i] == scan.colours[point]);
    }
    for (std::size_t k = 0; k < scan.fields.size(); ++k)
      for (std::size_t value = 0; value < scan.fields[k].count; ++value)
        ASSERT_EQ(frame.fields[k].numbers[i * scan.fields[k].count + value],
                  scan.fields[k].numbers[point * scan.fields[k].count + value]);
  }
}

/** \brief An encoder of scans, which are coded the same whatever the effort. */
FrameEncoder
scanEncoder(unsigned int i_frame_rate)
{
  return {StreamFormat::Version1, i_frame_rate, Effort::Fast};
}

TEST(Scans, HaveTheSamePayloadInAllEfforts)
{
  std::vector<Bytes> expected;
  for (const Effort effort : all_efforts) {
    FrameEncoder encoder(StreamFormat::Version1, 30, effort);
    std::vector<Bytes> payloads;
    for (const bool is_lidar : {false, true})
      for (unsigned int i = 0; i < 2; ++i) {
        scan::ScanFrame scan = is_lidar ? makeLidar() : makeCamera();
        addPoints(scan, i, is_lidar);
        addFields(scan, i);
        payloads.push_back(takeApart(encoded(encoder, scan)).payload);
        EXPECT_EQ(encoder.statistics().is_i_frame, i == 0);
      }
    if (effort == Effort::Fast)
      expected = payloads;
    EXPECT_EQ(payloads, expected) << nameOf(effort);
  }
}

TEST(Scans, ComeBack)
{
  FrameEncoder encoder = scanEncoder(4);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (unsigned int i = 0; i < 24; ++i) {
    SCOPED_TRACE(i);
    scan::ScanFrame scan = i / 6 % 2 == 0 ? makeCamera() : makeLidar();
    if (i / 6 == 1)
      fireOddRowsFirst(scan);
    if (i / 6 == 2)
      scan.is_on_lattice = true;
    if (i / 6 == 3)
      scan.order = scan::PointOrder::RowByRow;
    if (i % 6 == 5) {
      scan.intensity_scale.bits = 12;
      scan.colour_bits = 7;
    }
    else
      addPoints(scan, i, i / 6 % 2 == 1, i % 6 == 4 ? 4 : 40);
    if (i >= 12)
      addFields(scan, i);
    const Bytes bytes = encoded(encoder, scan);
    EXPECT_TRUE(encoder.statistics().has_points);
    EXPECT_EQ(encoder.statistics().is_i_frame, i % 6 == 0 || i % 6 == 4);
    const FrameDescription description = describeFrame(bytes.data(), bytes.size());
    EXPECT_TRUE(description.has_points);
    EXPECT_EQ(description.points, scan.pixels.size());
    if (description.is_i_frame) {
      EXPECT_EQ(description.scan.width, scan.width);
      EXPECT_EQ(description.scan.height, scan.height);
    }
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    EXPECT_EQ(decoder.statistics().has_points, true);
    EXPECT_EQ(decoder.statistics().voxels, scan.pixels.size());
    EXPECT_TRUE(back.keys.empty());
    expectPoints(back, scan);
  }
}

TEST(Scans, WithoutRaysComeBack)
{
  FrameEncoder encoder = scanEncoder(4);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (unsigned int i = 0; i < 18; ++i) {
    SCOPED_TRACE(i);
    const bool is_organised = i / 6 == 2;
    const std::uint32_t count = is_organised ? 600 : i % 6 == 5 ? 1 : 300 + i;
    const std::uint32_t width = is_organised ? 30 : i / 6 == 1 ? 16 : count;
    scan::ScanFrame scan = makeFreePoints(i, width, count, is_organised);
    addFields(scan, i);
    const Bytes bytes = encoded(encoder, scan);
    // Sequences may have any size.
    EXPECT_EQ(encoder.statistics().is_i_frame, i % 4 == 0);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    expectPoints(back, scan);
  }
}

TEST(Scans, WithMovedRowsComeBack)
{
  FrameEncoder encoder = scanEncoder(30);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (unsigned int i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    scan::ScanFrame scan = makeLidar();
    fireOddRowsFirst(scan);
    scan.width -= i;
    scan.rays.columns.resize(scan.width);
    moveRows(scan);
    addPoints(scan, i, i % 2 == 1);
    addFields(scan, i);
    const Bytes bytes = encoded(encoder, scan);
    EXPECT_EQ(encoder.statistics().is_i_frame, i == 0);
    VoxelFrame back;
    ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    expectPoints(back, scan);
  }
}

TEST(Scans, HaveVoxelsOnDemand)
{
  scan::ScanFrame scan = makeCamera();
  addPoints(scan, 1);
  addFields(scan, 1);
  FrameEncoder encoder = scanEncoder(4);
  FrameDecoder decoder;
  VoxelFrame back;
  const Bytes bytes = encoded(encoder, scan);
  const CompressionStatus status = decoder.decode(bytes.data(), bytes.size(), back);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_TRUE(isConsistent(back));
  EXPECT_FALSE(back.keys.empty());
  // Points far beside their rays are outside of the grid.
  EXPECT_LT(back.pointCount(), scan.pixels.size());
  EXPECT_GT(back.pointCount(), scan.pixels.size() * 9 / 10);
  const std::size_t outside = scan.pixels.size() - back.pointCount();
  EXPECT_EQ(back.points.outside_grid, outside);
  EXPECT_TRUE(status.hasWarning());
  EXPECT_EQ(status.message().rfind(std::to_string(outside) + " points", 0), 0u)
      << status;

  decoder.setDecodesVoxels(false);
  const Bytes next = encoded(encoder, scan);
  EXPECT_FALSE(decoder.decode(next.data(), next.size(), back).hasWarning());
  EXPECT_EQ(back.pointCount(), scan.pixels.size());
  EXPECT_EQ(back.points.outside_grid, 0u);
  // Whoever makes the voxels tells it.
  VoxelFrame filtered = back;
  VoxelOutlierRemoval removal;
  const pcl_ext::OutlierRemovalStatus removed = removal.filter(filtered);
  EXPECT_TRUE(removed.hasWarning());
  EXPECT_NE(removed.message().find(std::to_string(outside) + " points"),
            std::string::npos)
      << removed;
  EXPECT_EQ(filtered.points.outside_grid, outside);
}

TEST(Scans, OthersTakeAnIFrame)
{
  FrameEncoder encoder = scanEncoder(30);
  unsigned int seed = 0;
  const auto is_i_frame = [&](scan::ScanFrame scan) {
    addPoints(scan, ++seed);
    scan.rays.columns.resize(scan.rays.columns.empty() ? 0 : scan.rayColumns());
    encoded(encoder, scan);
    return encoder.statistics().is_i_frame;
  };
  scan::ScanFrame lidar = makeLidar();
  EXPECT_TRUE(is_i_frame(lidar));
  EXPECT_FALSE(is_i_frame(lidar));
  // The sensor moves, and turns.
  lidar.rays.pose.origin[0] += 99;
  lidar.rays.motion.origin[0] += 99;
  lidar.width -= 2;
  EXPECT_FALSE(is_i_frame(lidar));
  ++lidar.rays.rows[7].up;
  EXPECT_TRUE(is_i_frame(lidar));
  EXPECT_FALSE(is_i_frame(lidar));
  lidar.order = scan::PointOrder::RowByRow;
  EXPECT_TRUE(is_i_frame(lidar));
  fireOddRowsFirst(lidar);
  EXPECT_TRUE(is_i_frame(lidar));
  std::swap(lidar.firing_order[0], lidar.firing_order[1]);
  EXPECT_TRUE(is_i_frame(lidar));
  moveRows(lidar);
  EXPECT_TRUE(is_i_frame(lidar));
  lidar.grid.resolution *= 2.0;
  EXPECT_TRUE(is_i_frame(lidar));
  EXPECT_FALSE(is_i_frame(lidar));
  scan::ScanFrame camera = makeCamera();
  EXPECT_TRUE(is_i_frame(camera));
  EXPECT_FALSE(is_i_frame(camera));
  camera.is_on_lattice = true;
  EXPECT_TRUE(is_i_frame(camera));
  camera.rays.has_half_depths = true;
  EXPECT_TRUE(is_i_frame(camera));
  camera.width -= 2;
  EXPECT_TRUE(is_i_frame(camera));
}

TEST(Scans, AndVoxelsTakeTurns)
{
  std::mt19937_64 random(2);
  FrameEncoder encoder = scanEncoder(30);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  for (unsigned int i = 0; i < 27; ++i) {
    if (i % 9 == 0)
      encoder.setEffort(all_efforts[i / 9]);
    VoxelFrame back;
    if (i / 3 % 2 == 0) {
      scan::ScanFrame scan = makeCamera();
      addPoints(scan, i);
      addFields(scan, i);
      ASSERT_EQ(decoded(decoder, encoded(encoder, scan), back), CompressionCode::Ok);
      expectPoints(back, scan);
    }
    else {
      VoxelFrame frame = randomFrame(random, 7, 500);
      const Bytes bytes = encoded(encoder, frame);
      EXPECT_FALSE(describeFrame(bytes.data(), bytes.size()).has_points);
      ASSERT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
      expectSameFrame(back, frame);
      EXPECT_FALSE(back.points.areThere());
    }
    EXPECT_EQ(encoder.statistics().is_i_frame, i % 3 == 0);
  }
}

TEST(Scans, OfStillSensorsHaveShortHeaders)
{
  FrameEncoder encoder = scanEncoder(30);
  scan::ScanFrame scan = makeLidar();
  addPoints(scan, 1);
  std::array<std::size_t, 3> header_bytes{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (i == 2)
      scan.rays.pose.origin[1] += 5;
    encoded(encoder, scan);
    header_bytes[i] = encoder.statistics().header_bytes;
  }
  EXPECT_LT(header_bytes[1], 24u);
  EXPECT_LT(header_bytes[1] + 20, header_bytes[2]);
  EXPECT_LT(header_bytes[2], header_bytes[0]);
}

/** \brief A lidar whose header is as long as an encoder can make it: as many rows as
 * there may be, with numbers that take five bytes each, and as many fields, of long
 * names. */
scan::ScanFrame
lidarOfTheLongestHeader()
{
  scan::ScanFrame frame = makeLidar();
  frame.width = 1;
  frame.height = scan::most_side;
  frame.order = scan::PointOrder::ColumnByColumn;
  frame.grid.origin = {1.0, 2.0, 3.0};
  frame.intensity_scale.bits = 8;
  frame.intensity_scale.companded_range = 300;
  frame.colour_bits = 8;
  scan::ScanRays& rays = frame.rays;
  constexpr std::int32_t unit = 1 << 30;
  const auto most = [](int bits) { return std::int64_t{1} << bits; };
  rays.pose.origin.fill(-most(42));
  rays.motion.origin.fill(-most(42));
  for (std::size_t i = 0; i < 3; ++i) {
    rays.pose.vectors[i].fill(-most(30));
    rays.motion.vectors[i].fill(-most(45) / 256); // of a column
  }
  rays.turns.assign(31, {-unit / 2, -unit / 2});
  rays.columns = {0};
  rays.rows.clear();
  for (std::uint32_t row = 0; row < frame.height; ++row) {
    const std::int32_t sign = row % 2 == 0 ? 1 : -1;
    rays.rows.push_back({sign * (unit / 10 * 7),
                         sign * (unit / 10 * 7),
                         sign * (unit / 20 * 7),
                         sign * (unit / 20 * 7),
                         sign * unit,
                         sign * unit,
                         sign * unit});
    frame.firing_order.push_back(static_cast<std::uint16_t>(row));
  }
  // Wider scans have fewer rows.
  frame.width = 256;
  frame.row_shifts.assign(frame.height, 255);
  for (std::size_t i = 0; i < most_fields; ++i) {
    FrameField field;
    field.name = std::string(most_field_name_bytes - 2, 'n') + std::to_string(10 + i);
    field.type = FieldType::Float64;
    field.count = most_field_values / most_fields;
    field.step = 0.1;
    frame.fields.push_back(field);
  }
  MessageLayout layout;
  for (const std::size_t letters :
       {64, 64, 64, 64, 64, 64, 64, 64, 64, 64, 64, 64, 64, 64, 32}) {
    PlacedField& place = layout.fields.emplace_back();
    place.name = std::string(letters, 'n');
    place.type = FieldType::UInt8;
    place.count = place.offset = most_point_step / 2;
  }
  layout.point_step = most_point_step;
  layout.row_padding = most_row_padding;
  EXPECT_EQ(bytesOf(layout), most_layout_bytes);
  frame.layout = std::make_shared<MessageLayout>(layout);
  return frame;
}

TEST(ScanHeaders, AreWithinTheirBound)
{
  const scan::ScanFrame scan = lidarOfTheLongestHeader();
  FrameEncoder encoder = scanEncoder(4);
  const FrameStamp stamp{~std::uint64_t{0}, std::string(1024, 'f')};
  const Bytes bytes = encoded(encoder, scan, stamp);
  const std::size_t size = encoder.statistics().header_bytes;
  EXPECT_LE(size, most_frame_header_bytes);
  // Shifts are low, lower rows take a byte or two less in the firing order, and the
  // counts of this frame are low.
  EXPECT_GT(size + 65536 + 16384 + 128 + 1024, most_frame_header_bytes);
  const FrameDescription description =
      describeFrame(bytes.data(), std::min(bytes.size(), most_frame_header_bytes));
  EXPECT_TRUE(description.status.ok()) << description.status;
  EXPECT_EQ(description.scan.height, scan.height);
  EXPECT_EQ(description.fields.size(), most_fields);
  EXPECT_EQ(description.frame_id, stamp.frame_id);
  EXPECT_EQ(describeFrame(bytes.data(), size - 1).status.code(),
            CompressionCode::Truncated);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  VoxelFrame back;
  EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
}

TEST(ScanHeaders, WithoutRowsAreWithin8192Bytes)
{
  scan::ScanFrame scan = lidarOfTheLongestHeader();
  scan.rays = makeCamera().rays;
  scan.order = scan::PointOrder::RowByRow;
  scan.firing_order.clear();
  scan.row_shifts.clear();
  for (std::size_t axis = 0; axis < 3; ++axis)
    scan.rays.pose.vectors[2][axis] /= scan.height;
  FrameEncoder encoder = scanEncoder(4);
  const FrameStamp stamp{~std::uint64_t{0}, std::string(1024, 'f')};
  const Bytes bytes = encoded(encoder, scan, stamp);
  EXPECT_LE(encoder.statistics().header_bytes, 8192u);
  EXPECT_GT(encoder.statistics().header_bytes, 5900u);
  // 41 more bytes a row.
  scan.rays = makeLidar().rays;
  scan.rays.columns = {0};
  scan.height = 8;
  const Bytes lidar = encoded(encoder, scan, stamp);
  EXPECT_LE(encoder.statistics().header_bytes, 8192u + 8u * 41u);
}

TEST(Scans, OfManyPixelsTakeBytes)
{
  // 2^24 pixels with a point are what decoders take for some bytes, and not for fewer.
  scan::ScanFrame scan = makeCamera();
  scan.width = scan.height = 1 << 12;
  for (const std::size_t side : {1u, 2u})
    for (std::int64_t& change : scan.rays.pose.vectors[side])
      change /= 1024;
  scan.pixels = {77};
  scan.depths = {1000};
  FrameEncoder encoder = scanEncoder(4);
  FrameDecoder decoder;
  decoder.setDecodesVoxels(false);
  VoxelFrame back;
  ASSERT_EQ(decoded(decoder, encoded(encoder, scan), back), CompressionCode::Ok);
  expectPoints(back, scan);
  DecoderLimits limits;
  limits.max_points = (1 << 24) - 1;
  FrameDecoder strict(limits);
  FrameEncoder again = scanEncoder(4);
  EXPECT_EQ(decoded(strict, encoded(again, scan), back),
            CompressionCode::LimitExceeded);
}

} // namespace
