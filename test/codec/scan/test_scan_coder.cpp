// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
// The coder of scans: what it decodes, where points are, and bytes that are no scan.
#include "codec/scan/plane.h"
#include "codec/scan/point_places.h"
#include "codec/scan/scan_coder.h"
#include "codec/scan/scan_stripes.h"
#include "codec/scan/symbol_coding.h"
#include "codec/scan/symbol_table.h"
#include "support/scan_frames.h"
#include "voxelizing/scan_locator.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

namespace {

/** \brief What a decoder is given of a frame. */
scan::ScanFrame
emptied(const scan::ScanFrame& frame)
{
  scan::ScanFrame empty;
  empty.grid = frame.grid;
  empty.width = frame.width;
  empty.height = frame.height;
  empty.rays = frame.rays;
  empty.rays.columns.clear();
  empty.intensity_scale = frame.intensity_scale;
  empty.colour_bits = frame.colour_bits;
  return empty;
}

TEST(ScanCoder, DepthsThatStayTakeFewBytes)
{
  scan::ScanFrame frame = makeCamera();
  addPoints(frame, 7);
  frame.intensity_scale.bits = 0;
  frame.colour_bits = 0;
  frame.beside.clear();
  scan::ScanCoder encoder;
  std::vector<std::uint8_t> first;
  encoder.encode(true, frame, first);
  std::vector<std::uint8_t> second;
  encoder.encode(false, frame, second);
  // Which pixels have points is noise, of which .8 bits are left where it is unknown.
  EXPECT_LT(second.size(), first.size() * 7 / 10);
}

TEST(ScanCoder, FieldsBeginAnewAfterAnIFrameWithoutPoints)
{
  scan::ScanFrame frame = makeLidar();
  addPoints(frame, 2, true);
  addFields(frame, 2);
  scan::ScanFrame empty = emptied(frame);
  empty.fields = frame.fields;
  for (FrameField& field : empty.fields)
    field.numbers.clear();
  scan::ScanCoder encoder;
  std::vector<std::uint8_t> bytes;
  encoder.encode(true, frame, bytes);
  bytes.clear();
  encoder.encode(true, empty, bytes);
  EXPECT_TRUE(bytes.empty());
  encoder.encode(false, frame, bytes);

  scan::ScanCoder late_decoder; // has not seen the first frame
  scan::ScanFrame decoded = empty;
  ASSERT_TRUE(late_decoder.decode(true, bytes.data(), bytes.data(), 0, decoded));
  late_decoder.learn();
  ASSERT_TRUE(late_decoder.decode(
      false, bytes.data(), bytes.data() + bytes.size(), frame.pixels.size(), decoded));
  for (std::size_t field = 0; field < frame.fields.size(); ++field)
    EXPECT_EQ(decoded.fields[field].numbers, frame.fields[field].numbers);
}

TEST(ScanCoder, APFrameOfAnotherSizeIsRefused)
{
  scan::ScanFrame frame = makeCamera();
  addPoints(frame, 1);
  std::vector<std::uint8_t> bytes;
  scan::ScanCoder encoder;
  encoder.encode(true, frame, bytes);
  bytes.clear();
  encoder.encode(false, frame, bytes);
  scan::ScanFrame decoded = emptied(frame);
  scan::ScanCoder decoder;
  EXPECT_FALSE(decoder.decode(
      false, bytes.data(), bytes.data() + bytes.size(), frame.pixels.size(), decoded));
}

using PlaneNumbers = std::vector<std::uint32_t>;

constexpr std::uint32_t plane_width = 40;

scan::Plane
planeOf(PlaneNumbers& numbers)
{
  return {
      plane_width, static_cast<std::uint32_t>(numbers.size()) / plane_width, numbers};
}

/** \brief The number that tells what a plane is expected from, and its numbers. */
std::pair<std::uint64_t, PlaneNumbers>
codedAndDecoded(PlaneNumbers numbers)
{
  scan::SymbolWorkspace work;
  scan::SymbolEncoding coding(work);
  scan::PlanePass<scan::SymbolEncoding>(planeOf(numbers), 0, nullptr)
      .codeValues(coding);
  std::vector<std::uint8_t> bytes;
  coding.finish(scan::plane_contexts, bytes);
  const auto decoding = [&] {
    return scan::SymbolDecoding(
        bytes.data(), bytes.data() + bytes.size(), scan::plane_contexts, work);
  };
  PlaneNumbers decoded(numbers.size(), 0);
  scan::SymbolDecoding of_numbers = decoding();
  EXPECT_TRUE(scan::PlanePass<scan::SymbolDecoding>(planeOf(decoded), 0, nullptr)
                  .codeValues(of_numbers));
  EXPECT_TRUE(of_numbers.isAtEnd());
  return {decoding().code(scan::run_context, 0), decoded};
}

TEST(Plane, IsExpectedFromEdgesOrMeansWhicheverAreNearer)
{
  std::mt19937 random(3);
  for (const std::uint32_t rows : {1, 30}) {
    PlaneNumbers noise(rows * plane_width);
    PlaneNumbers walls(noise.size());
    for (std::uint32_t i = 0; i < noise.size(); ++i) {
      noise[i] = 5000 + static_cast<std::uint32_t>(random() % 1000);
      walls[i] = 100 * (1 + (i % plane_width) / 7);
    }
    constexpr std::uint64_t mean = 1;
    EXPECT_EQ(codedAndDecoded(noise), std::make_pair(mean, noise)) << rows;
    const auto [source, decoded] = codedAndDecoded(walls);
    EXPECT_EQ(decoded, walls) << rows;
    // In a single row what is above is two to the left.
    EXPECT_EQ(source, rows > 1 ? 0u : source) << rows;
  }
}

TEST(Plane, IsRefusedWithAnotherExpectation)
{
  for (const std::uint64_t source : {std::uint64_t{2}, scan::first_word}) {
    scan::SymbolWorkspace work;
    scan::SymbolEncoding coding(work);
    coding.reserve(plane_width + 1);
    coding.code(scan::run_context, source);
    for (std::uint32_t i = 0; i < plane_width; ++i)
      coding.code(0, 0);
    std::vector<std::uint8_t> bytes;
    coding.finish(scan::plane_contexts, bytes);
    PlaneNumbers numbers(plane_width);
    scan::SymbolDecoding decoding(
        bytes.data(), bytes.data() + bytes.size(), scan::plane_contexts, work);
    EXPECT_FALSE(scan::PlanePass<scan::SymbolDecoding>(planeOf(numbers), 0, nullptr)
                     .codeValues(decoding));
  }
}

TEST(SymbolTable, WidthsFollowCounts)
{
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i) {
    scan::SymbolCounts counts{};
    const std::size_t used = 1 + random() % counts.size();
    for (std::size_t k = 0; k < used; ++k)
      counts[random() % counts.size()] = 1u << random() % 25;
    const scan::SymbolTable::Widths widths = scan::widthsOf(counts);
    EXPECT_EQ(std::accumulate(widths.begin(), widths.end(), 0u), 4096u);
    for (std::size_t symbol = 0; symbol < counts.size(); ++symbol) {
      EXPECT_LT(widths[symbol], 4096u);
      EXPECT_TRUE(counts[symbol] == 0 || widths[symbol] > 0);
    }
    scan::SymbolTable table;
    table.set(widths);
    for (std::uint32_t slot = 0; slot < 4096; ++slot) {
      const auto range = table.range(table.find(slot));
      ASSERT_GE(slot, range.start);
      ASSERT_LT(slot, range.start + range.width);
    }
  }
}

/** \brief Rays and places by themselves, in floating point. */
std::array<double, 3>
placeOf(const scan::ScanFrame& frame, std::size_t point)
{
  const double depth = frame.depths[point];
  const std::uint32_t row = frame.pixels[point] / frame.width;
  const std::uint32_t column = frame.pixels[point] % frame.width;
  std::array<double, 3> place{524288.0, 524288.0, 524288.0};
  if (frame.depths[point] == scan::at_sensor)
    return place;
  if (frame.rays.shape == scan::RayShape::Planar) {
    const double away = depth + (frame.rays.has_half_depths ? 0.5 : 0.0);
    place[0] += away * (-0.4 + 0.02 * column);
    place[1] += away * (-0.3 + 0.02 * row);
    place[2] += away;
    return place;
  }
  const double angle = (frame.rays.columns[column] + frame.turns[point]) *
                       3.14159265358979323846 / 180.0;
  const double along = 30.0 + 0.98 * depth;
  place[0] += 2.0 * column + along * std::cos(angle) + 20.0 * std::sin(angle);
  place[1] += along * std::sin(angle) - 20.0 * std::cos(angle);
  place[2] += 40.0 + 0.02 * row * depth;
  return place;
}

TEST(PlacesOfPoints, AreOnTheRays)
{
  scan::ScanFrame other_camera = makeCamera();
  other_camera.rays.has_half_depths = true;
  for (scan::ScanFrame frame : {makeCamera(), other_camera, makeLidar()}) {
    addPoints(frame, 9, frame.rays.shape == scan::RayShape::Spinning);
    frame.beside.clear();
    std::size_t point = 0;
    scan::visitPlaces(frame, [&](const scan::Triple& place) {
      const std::array<double, 3> expected = placeOf(frame, point++);
      for (std::size_t axis = 0; axis < 3; ++axis)
        ASSERT_NEAR(
            std::ldexp(static_cast<double>(place[axis]), -32), expected[axis], 0.002);
    });
    EXPECT_EQ(point, frame.pixels.size());
  }
}

/** \brief Where the points of a scan are, and the same off by at most so many edges. */
std::vector<std::array<double, 3>>
makePositions(const scan::ScanFrame& points, double most_off)
{
  std::mt19937 random(13);
  std::uniform_real_distribution<double> noise(-most_off, most_off);
  std::vector<std::array<double, 3>> positions;
  scan::visitPlaces(points, [&](const scan::Triple& place) {
    std::array<double, 3>& position = positions.emplace_back();
    for (std::size_t axis = 0; axis < 3; ++axis)
      position[axis] =
          (std::ldexp(static_cast<double>(place[axis]), -32) + noise(random)) *
              points.grid.resolution +
          points.grid.lowerCorner(axis);
  });
  return positions;
}

/** \brief Puts all points on the rays of a scan again. */
bool
locateAll(const scan::ScanFrame& points,
          const std::vector<std::array<double, 3>>& positions,
          scan::ScanFrame& frame)
{
  frame = emptied(points);
  frame.rays = points.rays;
  ScanLocator locator(frame, !points.turns.empty());
  std::vector<std::uint32_t> indices(positions.size());
  std::iota(indices.begin(), indices.end(), 0u);
  for (std::size_t begin = 0, end = 0; begin < indices.size(); begin = end) {
    const std::uint32_t row = points.pixels[begin] / points.width;
    std::vector<std::uint32_t> columns;
    for (; end < indices.size() && points.pixels[end] / points.width == row; ++end)
      columns.push_back(points.pixels[end] % points.width);
    if (!locator.append(row, columns, positions, &indices[begin]))
      return false;
  }
  return true;
}

TEST(ScanLocator, NoCoordinateIsOffByMoreThanHalfAnEdge)
{
  for (const unsigned int sensor : {0u, 1u, 2u}) {
    SCOPED_TRACE(sensor);
    const bool is_lidar = sensor == 0;
    scan::ScanFrame points = is_lidar ? makeLidar() : makeCamera();
    points.rays.has_half_depths = sensor == 1;
    addPoints(points, 2, is_lidar);
    points.beside.clear();
    // Four edges, and where nearly all are on their rays for certain.
    for (const double off : {4.0, 0.2}) {
      const std::vector<std::array<double, 3>> positions = makePositions(points, off);
      scan::ScanFrame frame;
      ASSERT_TRUE(locateAll(points, positions, frame));
      EXPECT_EQ(frame.pixels, points.pixels);
      // Nearly all are on their turned rays.
      if (off < 0.25) {
        EXPECT_LT(20 * frame.beside.size(), frame.pixels.size());
        EXPECT_EQ(frame.turns.empty(), points.turns.empty());
      }
      for (std::size_t point = 0; point < frame.turns.size(); ++point)
        if (frame.depths[point] == scan::at_sensor) {
          EXPECT_EQ(frame.turns[point], 0);
        }
      auto position = positions.begin();
      scan::visitPlaces(frame, [&](const scan::Triple& place) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          ASSERT_NEAR(std::ldexp(static_cast<double>(place[axis]), -32) *
                              frame.grid.resolution +
                          frame.grid.lowerCorner(axis),
                      (*position)[axis],
                      0.5 * frame.grid.resolution + 1e-9);
        ++position;
      });
      EXPECT_EQ(position, positions.end());
    }
  }
}

TEST(ScanLocator, OfTwoDepthsAsNearTakesTheOneOnTheRay)
{
  for (const bool looks_back : {false, true}) {
    scan::ScanFrame points = makeCamera();
    points.grid.resolution = 0x1p-6; // so that nothing is rounded
    if (looks_back)
      for (scan::Triple& vector : points.rays.pose.vectors)
        for (std::int64_t& element : vector)
          element = -element;
    addPoints(points, 3, false);
    points.beside.clear();
    std::vector<std::array<double, 3>> positions = makePositions(points, 0.0);
    for (std::array<double, 3>& position : positions)
      position[2] += 0x1p-7;
    scan::ScanFrame frame;
    ASSERT_TRUE(locateAll(points, positions, frame));
    EXPECT_LT(100 * frame.beside.size(), positions.size()) << looks_back;
  }
}

TEST(ScanLocator, RefusesWhatIsTooFarAway)
{
  for (const bool is_on_lattice : {false, true}) {
    scan::ScanFrame points = makeCamera();
    points.is_on_lattice = is_on_lattice;
    addPoints(points, 2, false);
    for (const double number : {std::nan(""), 0.7e5, -0.7e5, HUGE_VAL})
      for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<std::array<double, 3>> positions = makePositions(points, 0.0);
        positions.back()[axis] = number;
        scan::ScanFrame frame;
        EXPECT_FALSE(locateAll(points, positions, frame)) << number << ", " << axis;
      }
  }
}

TEST(ScanStripes, HavePointsAsTheyAre)
{
  std::size_t beside = 0;
  for (const bool is_camera : {true, false}) {
    scan::ScanFrame whole = is_camera ? makeCamera() : makeLidar();
    addPoints(whole, 4, !is_camera);
    addFields(whole, 4);
    const scan::ScanFrame part = scan::stripesOf(whole);
    ASSERT_EQ(part.width, whole.width);
    EXPECT_GT(20 * part.pixels.size(), whole.pixels.size());
    EXPECT_LT(4 * part.pixels.size(), whole.pixels.size());
    beside += part.beside.size();

    const auto positions_of = [](scan::ScanFrame scan) {
      scan.order = scan::PointOrder::Organised;
      VoxelFrame frame;
      scan::movePoints(scan, frame);
      return frame.points.positions;
    };
    const auto of_whole = positions_of(whole);
    const auto of_part = positions_of(part);
    std::size_t same = 0;
    for (std::size_t i = 0, j = 0; i < whole.pixels.size(); ++i) {
      if (j == part.pixels.size() || whole.pixels[i] != part.pixels[j])
        continue;
      same += of_whole[i] == of_part[j] &&
                      (whole.intensities.empty() ||
                       whole.intensities[i] == part.intensities[j]) &&
                      whole.fields[2].numbers[2 * i + 1] ==
                          part.fields[2].numbers[2 * j + 1]
                  ? 1
                  : 0;
      ++j;
    }
    EXPECT_EQ(same, part.pixels.size());
  }
  EXPECT_GT(beside, 0u);
}

} // namespace
