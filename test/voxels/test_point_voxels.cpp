// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/point_frames.h"
#include "voxels/keep_voxels.h"
#include "voxels/point_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief Points in rows and columns or in one row, with all values or some. */
std::vector<PointContent>
contents()
{
  std::vector<PointContent> contents;
  for (const std::uint32_t height : {1u, 32u})
    for (const unsigned int intensity_bits : {0u, 8u, 16u})
      for (const unsigned int colour_bits : {0u, 5u, 8u})
        contents.push_back({48,
                            height,
                            height == 1 ? 2u : 3u,
                            intensity_bits,
                            colour_bits,
                            intensity_bits != 8});
  return contents;
}

/** \brief The points of a frame without voxels, by the keys of the voxels that they are
 * in. */
std::map<std::uint64_t, std::vector<std::size_t>>
pointsOfVoxels(const VoxelFrame& frame)
{
  std::map<std::uint64_t, std::vector<std::size_t>> voxels;
  for (std::size_t point = 0; point < frame.points.indices.size(); ++point) {
    std::array<std::int64_t, 3> at;
    for (std::size_t axis = 0; axis < 3; ++axis)
      at[axis] = static_cast<std::int64_t>(std::floor(
                     (frame.points.positions[point][axis] - frame.grid.origin[axis]) /
                     frame.grid.resolution)) -
                 frame.grid.first_index[axis];
    if (std::all_of(at.begin(), at.end(), [&frame](std::int64_t position) {
          return position >= 0 && position < frame.grid.size();
        }))
      voxels[mortonKey({static_cast<std::uint32_t>(at[0]),
                        static_cast<std::uint32_t>(at[1]),
                        static_cast<std::uint32_t>(at[2])})]
          .push_back(point);
  }
  return voxels;
}

/** \brief A row of points in a grid, without voxels. */
VoxelFrame
rowOfPoints(std::mt19937_64& random, const VoxelGrid& grid, std::uint32_t count)
{
  VoxelFrame frame;
  frame.grid = grid;
  frame.has_point_counts = true;
  frame.points.width = count;
  frame.points.height = 1;
  for (std::uint32_t i = 0; i < count; ++i) {
    frame.points.indices.push_back(i);
    frame.points.positions.push_back(positionWithin(grid, random));
  }
  setValues(random, false, frame);
  return frame;
}

template <typename ValueOfT>
std::uint64_t
roundedMean(const std::vector<std::size_t>& points, const ValueOfT& value_of)
{
  double sum = 0.0;
  for (const std::size_t point : points)
    sum += static_cast<double>(value_of(point));
  return static_cast<std::uint64_t>(
      std::llround(sum / static_cast<double>(points.size())));
}

/** \brief Expects the voxels of all points of a frame without voxels. */
void
expectVoxels(const VoxelFrame& frame, const VoxelFrame& points)
{
  const auto voxels = pointsOfVoxels(points);
  ASSERT_EQ(frame.size(), voxels.size());
  std::size_t voxel = 0;
  for (const auto& [key, of_voxel] : voxels) {
    ASSERT_EQ(frame.keys[voxel], key);
    ASSERT_EQ(frame.point_counts[voxel], of_voxel.size());
    if (frame.hasIntensities()) {
      ASSERT_EQ(frame.intensities[voxel], roundedMean(of_voxel, [&](std::size_t i) {
                  return points.points.intensities[i];
                }));
    }
    if (frame.colour_bits > 0) {
      const auto& colours = points.points.colours;
      const auto mean = [&](std::uint8_t VoxelColour::*channel) {
        return static_cast<std::uint8_t>(
            roundedMean(of_voxel, [&](std::size_t i) { return colours[i].*channel; }));
      };
      ASSERT_TRUE(frame.colours[voxel] == (VoxelColour{mean(&VoxelColour::r),
                                                       mean(&VoxelColour::g),
                                                       mean(&VoxelColour::b)}));
    }
    ++voxel;
  }
  ASSERT_EQ(frame.intensities.size(), frame.hasIntensities() ? frame.size() : 0);
  ASSERT_EQ(frame.colours.size(), frame.colour_bits > 0 ? frame.size() : 0);
}

/** \brief Expects the points of a frame without voxels, voxel by voxel. */
void
expectPointsOfVoxels(const VoxelFrame& frame, const VoxelFrame& points)
{
  std::size_t next = 0;
  for (const auto& [key, of_voxel] : pointsOfVoxels(points))
    for (const std::size_t i : of_voxel) {
      ASSERT_LT(next, frame.points.indices.size());
      ASSERT_EQ(frame.points.indices[next], points.points.indices[i]);
      ASSERT_EQ(frame.points.positions[next], points.points.positions[i]);
      if (frame.hasIntensities()) {
        ASSERT_EQ(frame.points.intensities[next], points.points.intensities[i]);
      }
      if (frame.colour_bits > 0) {
        ASSERT_TRUE(frame.points.colours[next] == points.points.colours[i]);
      }
      for (std::size_t field = 0; field < frame.fields.size(); ++field) {
        const std::size_t count = frame.fields[field].count;
        for (std::size_t k = 0; k < count; ++k)
          ASSERT_EQ(frame.fields[field].numbers[next * count + k],
                    points.fields[field].numbers[i * count + k]);
      }
      ++next;
    }
  ASSERT_EQ(frame.points.indices.size(), next);
  ASSERT_EQ(frame.points.width, points.points.width);
  ASSERT_EQ(frame.points.height, points.points.height);
}

TEST(PointVoxels, AreThoseThatThePointsAreIn)
{
  std::mt19937_64 random(1);
  for (const PointContent& content : contents()) {
    const VoxelFrame points = frameOfPoints(random, content);
    VoxelFrame frame = points;
    setVoxels(frame);
    EXPECT_TRUE(isConsistent(frame));
    expectVoxels(frame, points);
    expectPointsOfVoxels(frame, points);
    EXPECT_LT(frame.size(), frame.points.indices.size()); // several in a voxel
    EXPECT_EQ(frame.pointCount(), points.pointCount());
    const VoxelFrame before = frame;
    setVoxels(frame); // which has them
    expectSameFrame(frame, before);
  }
}

TEST(PointVoxels, AreOnTheGridWhereverItIs)
{
  std::mt19937_64 random(2);
  for (const unsigned int depth : {1u, 6u, 12u, 21u}) {
    const VoxelFrame points = rowOfPoints(
        random, {0.04, {1234.5, -0.25, 98765.0}, {-3, 70000, -1}, depth}, 500);
    VoxelFrame frame = points;
    setVoxels(frame);
    EXPECT_TRUE(isConsistent(frame));
    expectVoxels(frame, points);
    expectPointsOfVoxels(frame, points);
  }
}

TEST(PointVoxels, PointsOutsideTheGridAreLeftOut)
{
  std::mt19937_64 random(3);
  VoxelFrame points = frameOfPoints(random);
  const double edge = points.grid.resolution;
  const double size = edge * static_cast<double>(points.grid.size());
  const double not_a_number = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < points.points.positions.size(); i += 3)
    points.points.positions[i][i % 9 / 3] =
        points.grid.lowerCorner(i % 9 / 3) + (i % 2 == 0 ? -0.001 * edge : size + edge);
  points.points.positions[1] = {1e300, -1e300, 0.0};
  points.points.positions[2][1] = not_a_number;
  VoxelFrame frame = points;
  EXPECT_EQ(statusOfVoxels(frame).message(), "");
  setVoxels(frame);
  EXPECT_TRUE(isConsistent(frame));
  EXPECT_LT(frame.points.indices.size(), points.points.indices.size() * 2 / 3 + 1);
  const std::size_t outside =
      points.points.indices.size() - frame.points.indices.size();
  EXPECT_EQ(frame.points.outside_grid, outside);
  const CompressionStatus status = statusOfVoxels(frame);
  EXPECT_TRUE(status.hasWarning());
  EXPECT_EQ(status.message().rfind(std::to_string(outside) +
                                       " points of the scan are outside its grid",
                                   0),
            0u)
      << status;
  setVoxels(frame); // counts none again
  EXPECT_EQ(frame.points.outside_grid, outside);
  points.points.positions[1] = points.points.positions[0];
  points.points.positions[2] = points.points.positions[0];
  expectVoxels(frame, points);
  expectPointsOfVoxels(frame, points);

  for (std::array<double, 3>& position : points.points.positions)
    position = {1e9, 1e9, 1e9};
  const std::size_t all = points.points.positions.size();
  setVoxels(points);
  EXPECT_EQ(points.size(), 0u);
  EXPECT_EQ(points.pointCount(), 0u);
  EXPECT_TRUE(isConsistent(points));
  setVoxels(points);
  EXPECT_EQ(points.points.outside_grid, all);
}

TEST(PointVoxels, ARowHasNoGapsWherePointsAreOutsideTheGrid)
{
  std::mt19937_64 random(4);
  VoxelFrame frame = frameOfPoints(random, {40, 1});
  for (std::uint32_t i = 0; i < 40; ++i)
    if (i % 4 == 1)
      frame.points.positions[i][2] = 1e9;
  setVoxels(frame);
  EXPECT_TRUE(isConsistent(frame));
  EXPECT_EQ(frame.cloudWidth(), 30u);
  EXPECT_EQ(frame.pointCount(), 30u);
  EXPECT_TRUE(frame.isDense());
  const FrameField& index = frame.fields[0]; // where each point was
  for (std::size_t point = 0; point < 30; ++point)
    EXPECT_EQ(frame.points.indices[point],
              3 * (index.numbers[point] / 4) + (index.numbers[point] % 4 + 1) / 2);

  for (std::array<double, 3>& position : frame.points.positions)
    position[0] = -1e9;
  frame.keys.clear();
  setVoxels(frame);
  EXPECT_TRUE(isConsistent(frame));
  EXPECT_EQ(frame.cloudSize(), 0u);
}

TEST(PointVoxels, FramesWithoutPointsStay)
{
  std::mt19937_64 random(4);
  VoxelFrame frame = randomFrame(random, 5, 100);
  const VoxelFrame before = frame;
  setVoxels(frame);
  expectSameFrame(frame, before);
  EXPECT_FALSE(frame.has_point_counts);
}

struct CloudPoint {
  double x;
  double y;
  double z;
  float intensity;
  VoxelColour colour;
  std::vector<std::uint64_t> fields;

  bool
  operator==(const CloudPoint& other) const
  {
    return x == other.x && y == other.y && z == other.z &&
           intensity == other.intensity && colour == other.colour &&
           fields == other.fields;
  }
};

template <typename NumberT>
std::vector<std::optional<CloudPoint>>
cloudOf(const VoxelFrame& frame)
{
  std::vector<std::optional<CloudPoint>> cloud(frame.cloudSize());
  std::size_t points = 0;
  const auto add = [&](std::size_t point,
                       auto x,
                       auto y,
                       auto z,
                       float intensity,
                       const VoxelColour& colour) {
    EXPECT_EQ(sizeof(x), sizeof(NumberT));
    EXPECT_EQ(point, points++);
    std::optional<CloudPoint>& place = cloud.at(frame.cloudIndex(point));
    EXPECT_FALSE(place.has_value());
    place = CloudPoint{x, y, z, intensity, colour, {}};
    for (const FrameField& field : frame.fields)
      for (std::size_t k = 0; k < field.count; ++k)
        place->fields.push_back(field.numbers[point * field.count + k]);
  };
  forEachPoint(frame, add);
  EXPECT_EQ(points, frame.pointCount());
  EXPECT_EQ(frame.isDense(), points == cloud.size());
  EXPECT_EQ(frame.cloudWidth() * frame.cloudHeight(), cloud.size());
  return cloud;
}

TEST(PointVoxels, CloudsAreTheSameWithAndWithoutVoxels)
{
  std::mt19937_64 random(5);
  for (const PointContent& content : contents()) {
    VoxelFrame frame = frameOfPoints(random, content);
    frame.intensity_scale.offset = 3.0f;
    frame.intensity_scale.step = 0.5f;
    const auto cloud = cloudOf<float>(frame);
    std::size_t point = 0;
    for (std::uint32_t index = 0; index < cloud.size(); ++index) {
      if (point == frame.points.indices.size() ||
          frame.points.indices[point] != index) {
        EXPECT_FALSE(cloud[index]);
        continue;
      }
      ASSERT_TRUE(cloud[index]);
      const auto& position = frame.points.positions[point];
      EXPECT_EQ(cloud[index]->x, static_cast<double>(static_cast<float>(position[0])));
      EXPECT_EQ(cloud[index]->y, static_cast<double>(static_cast<float>(position[1])));
      EXPECT_EQ(cloud[index]->z, static_cast<double>(static_cast<float>(position[2])));
      EXPECT_EQ(cloud[index]->intensity,
                content.intensity_bits > 0
                    ? 3.0f + 0.5f * static_cast<float>(frame.points.intensities[point])
                    : 0.0f);
      const VoxelColour white = {255, 255, 255};
      EXPECT_TRUE(cloud[index]->colour ==
                  (content.colour_bits > 0
                       ? frame.fullColour(frame.points.colours[point])
                       : white));
      ++point;
    }
    VoxelFrame with_voxels = frame;
    setVoxels(with_voxels);
    EXPECT_TRUE(cloudOf<float>(with_voxels) == cloud);
  }
}

TEST(PointVoxels, FarFromTheOriginCoordinatesAreDoubles)
{
  std::mt19937_64 random(6);
  const VoxelFrame frame =
      rowOfPoints(random, {0.04, {5e6, 0.0, 0.0}, {-4, -4, -4}, 3}, 20);
  ASSERT_TRUE(frame.grid.needsDoubles());
  const auto cloud = cloudOf<double>(frame);
  for (std::size_t i = 0; i < 20; ++i)
    EXPECT_EQ((std::array<double, 3>{cloud[i]->x, cloud[i]->y, cloud[i]->z}),
              frame.points.positions[i]);
  VoxelFrame with_voxels = frame;
  setVoxels(with_voxels);
  EXPECT_TRUE(cloudOf<double>(with_voxels) == cloud);
  with_voxels.points = FramePoints();
  EXPECT_EQ(cloudOf<double>(with_voxels).size(), 20u); // at the centres
}

TEST(PointVoxels, PointsOfFramesWithVoxelsOnlyAreAtTheirCentres)
{
  std::mt19937_64 random(7);
  for (const bool has_counts : {false, true})
    for (const unsigned int colour_bits : {0u, 1u, 5u, 8u}) {
      VoxelFrame frame = randomFrame(random, 6, 300);
      frame.has_point_counts = has_counts;
      frame.colour_bits = colour_bits;
      const auto channel = [&] {
        return static_cast<std::uint8_t>(
            below(random, std::uint64_t{1} << colour_bits));
      };
      for (std::size_t i = 0; i < frame.size(); ++i) {
        if (has_counts)
          frame.point_counts.push_back(1 +
                                       static_cast<std::uint32_t>(below(random, 4)));
        if (colour_bits > 0)
          frame.colours.push_back({channel(), channel(), channel()});
      }
      ASSERT_TRUE(isConsistent(frame));
      const auto cloud = cloudOf<float>(frame);
      std::size_t point = 0;
      for (std::size_t voxel = 0; voxel < frame.size(); ++voxel)
        for (std::uint32_t i = 0; i < (has_counts ? frame.point_counts[voxel] : 1);
             ++i) {
          ASSERT_TRUE(cloud.at(point));
          const CloudPoint& found = *cloud[point++];
          const std::array<float, 3> centre = centreOf(frame, voxel);
          EXPECT_EQ(found.x, static_cast<double>(centre[0]));
          EXPECT_EQ(found.y, static_cast<double>(centre[1]));
          EXPECT_EQ(found.z, static_cast<double>(centre[2]));
          EXPECT_EQ(found.intensity,
                    frame.intensity_scale.value(frame.intensities[voxel]));
          const VoxelColour white = {255, 255, 255};
          EXPECT_TRUE(found.colour ==
                      (colour_bits > 0 ? frame.fullColour(voxel) : white));
        }
      EXPECT_EQ(point, cloud.size());
    }
}

std::size_t
firstOfSeveral(const VoxelFrame& frame)
{
  std::size_t point = 0;
  for (const std::uint32_t count : frame.point_counts) {
    if (count > 1)
      return point;
    point += count;
  }
  ADD_FAILURE() << "each voxel has one point";
  return 0;
}

TEST(PointVoxels, FramesWithWrongPointsAreNotConsistent)
{
  std::mt19937_64 random(8);
  const VoxelFrame good = pointFrame(random);
  ASSERT_TRUE(isConsistent(good));
  const std::size_t first = firstOfSeveral(good);
  const auto changed = [&good](auto change) {
    VoxelFrame frame = good;
    change(frame);
    return isConsistent(frame);
  };
  EXPECT_TRUE(changed([](VoxelFrame&) {}));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.indices.pop_back(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.positions.pop_back(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.intensities.pop_back(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.intensities.clear(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.intensities[3] = 256; }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.colours.push_back({}); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.colours.clear(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.colours[7].g = 32; }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.indices[5] = 48 * 32; }));
  EXPECT_FALSE(
      changed([](VoxelFrame& f) { f.points.indices[5] = f.points.indices[90]; }));
  EXPECT_FALSE(changed([first](VoxelFrame& f) {
    std::swap(f.points.indices[first], f.points.indices[first + 1]);
  }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.width = 0; }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.height = 0; }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.points.height = 31; }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { ++f.point_counts.back(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { --f.point_counts[f.size() / 2]; }));
  EXPECT_FALSE(changed([](VoxelFrame& f) { f.fields[1].numbers.pop_back(); }));
  EXPECT_FALSE(changed([](VoxelFrame& f) {
    f.has_point_counts = false;
    f.point_counts.clear();
  }));
  EXPECT_TRUE(changed([](VoxelFrame& f) { f.points = FramePoints(); }));
  EXPECT_TRUE(changed([](VoxelFrame& f) { f.points.height = 33; }));
}

TEST(PointVoxels, PointsOfVoxelsThatStayAreKept)
{
  std::mt19937_64 random(9);
  for (const PointContent& content : contents()) {
    const VoxelFrame before = pointFrame(random, content);
    VoxelFrame frame = before;
    const auto is_kept = [&before](std::size_t voxel) {
      return before.keys[voxel] % 3 != 0;
    };
    const std::size_t removed = keepVoxels(frame, is_kept);
    EXPECT_GT(removed, 0u);
    EXPECT_EQ(frame.size() + removed, before.size());
    EXPECT_TRUE(isConsistent(frame));
    const auto whole = cloudOf<float>(before);
    std::vector<std::optional<CloudPoint>> expected = whole;
    std::size_t point = 0;
    for (std::size_t voxel = 0; voxel < before.size(); ++voxel)
      for (std::uint32_t i = 0; i < before.point_counts[voxel]; ++i, ++point)
        if (!is_kept(voxel))
          expected[before.cloudIndex(point)].reset();
    if (content.height == 1) // has no missing points
      expected.erase(std::remove(expected.begin(), expected.end(), std::nullopt),
                     expected.end());
    EXPECT_TRUE(cloudOf<float>(frame) == expected);
    EXPECT_EQ(frame.cloudHeight(), content.height);
  }
}

TEST(PointVoxels, WithoutVoxelsThereAreNoPoints)
{
  std::mt19937_64 random(10);
  for (const PointContent& content : contents()) {
    VoxelFrame frame = pointFrame(random, content);
    keepVoxels(frame, [](std::size_t) { return false; });
    EXPECT_TRUE(isConsistent(frame));
    EXPECT_EQ(frame.pointCount(), 0u);
    EXPECT_EQ(frame.cloudSize(), content.height == 1 ? 0u : 48u * content.height);
    EXPECT_EQ(frame.cloudHeight(), content.height);
    setVoxels(frame);
    EXPECT_EQ(frame.size(), 0u);
    frame.clearVoxels();
    EXPECT_EQ(frame.cloudSize(), 0u);
  }
}

} // namespace
