// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "support/temporal_scenes.h"
#include "voxelizing/point_batches.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::temporal;
using namespace std::chrono_literals;
using io::SensorMotion;
using io::VoxelFrame;

Voxels
operator+(Voxels symbols, const Voxels& others)
{
  symbols.insert(others.begin(), others.end());
  return symbols;
}

bool
hasNear(const Voxels& symbols, const LatticeIndex& index)
{
  for (std::int64_t x = -1; x <= 1; ++x)
    for (std::int64_t y = -1; y <= 1; ++y)
      for (std::int64_t z = -1; z <= 1; ++z)
        if (symbols.count({index[0] + x, index[1] + y, index[2] + z}) != 0)
          return true;
  return false;
}

/** \brief The wall with a hole through which nothing is seen. */
Voxels
wallWithHole(std::int64_t margin = 0)
{
  Voxels some = flatWall();
  for (std::int64_t x = 20 + margin; x < 26 - margin; ++x)
    for (std::int64_t y = 20 + margin; y < 26 - margin; ++y)
      some.erase({x, y, wall_depth});
  return some;
}

TEST(TemporalVoxelFilter, ASurfaceOnTheFaceBetweenVoxelsComesToRest)
{
  TemporalVoxelFilter filter;
  std::mt19937 random(1);
  std::set<Voxels> shown_late;
  for (int i = 0; i < 60; ++i) {
    // Each voxel now in front of the face and now behind it, one frame of three.
    Voxels symbols;
    for (std::int64_t x = 0; x < wall_size; ++x)
      for (std::int64_t y = 0; y < wall_size; ++y)
        symbols[{x, y, wall_depth + (random() % 3 == 0 ? 1 : 0)}] = 9;
    const Voxels shown = shownOf(filter, symbols);
    for (const auto& [index, symbol] : symbols)
      EXPECT_TRUE(hasNear(shown, index)) << i;
    if (i >= 40)
      shown_late.insert(shown);
  }
  // Few of 2304 voxels change in 20 frames; each frame had 1024 others than the last one.
  EXPECT_LE(shown_late.size(), 20u);
  std::size_t changed = 0;
  for (auto i = shown_late.begin(), j = std::next(i); j != shown_late.end(); ++i, ++j)
    for (const auto& [index, symbol] : *j)
      changed += 1 - i->count(index);
  EXPECT_LT(changed, 2304u);
}

/** \brief The wall as pixels see it whose depth has a standard deviation of 1.8 voxels,
 * two for each voxel across. */
Voxels
noisyWall(std::mt19937& random)
{
  Voxels symbols;
  for (std::int64_t x = 0; x < wall_size; ++x)
    for (std::int64_t y = 0; y < wall_size; ++y)
      for (int pixel = 0; pixel < 2; ++pixel) {
        std::int64_t sixteenths = 0; // nearly a normal distribution
        for (int i = 0; i < 4; ++i)
          sixteenths += static_cast<std::int64_t>(random() % 50);
        symbols[{x, y, wall_depth + (sixteenths - 98) / 16}] = 9;
      }
  return symbols;
}

TEST(TemporalVoxelFilter, OfNoiseLargerThanTheVoxelsAThickLayerComesToRest)
{
  TemporalVoxelFilter filter;
  std::mt19937 random(1);
  Voxels last;
  std::size_t measured = 0;
  std::size_t near = 0;
  std::size_t shown_voxels = 0;
  std::size_t changed = 0;
  for (int i = 0; i < 100; ++i) {
    const Voxels symbols = noisyWall(random);
    const Voxels shown = shownOf(filter, symbols);
    if (i >= 60) {
      measured += symbols.size();
      shown_voxels += shown.size();
      for (const auto& [index, symbol] : symbols)
        near += hasNear(shown, index) ? 1 : 0;
      for (const auto& [index, symbol] : shown)
        changed += 1 - last.count(index);
    }
    last = shown;
  }
  EXPECT_GT(static_cast<double>(near), 0.985 * static_cast<double>(measured));
  EXPECT_LT(static_cast<double>(changed), 0.02 * static_cast<double>(shown_voxels));
  // The layer is gone 1.6 s, 96 sixtieths, after the wall, of which nothing is near.
  const Voxels far = flatWall(wall_depth - 20);
  std::size_t left = 0;
  std::size_t frames = 0;
  do {
    const Voxels shown = shownOf(filter, far);
    left = shown.size() - far.size();
    ++frames;
  }
  while (left > 0 && frames < 100);
  EXPECT_LE(frames, 33u);
}

TEST(TemporalVoxelFilter, WhereVoxelsComeAndGoASurfaceNeedsOneNeighbourMore)
{
  const Voxels two_neighbours_each = {
      {{5, 5, 20}, 3}, {{6, 5, 20}, 3}, {{5, 6, 20}, 3}};
  const Voxels three_neighbours_each = two_neighbours_each + Voxels{{{6, 6, 20}, 3}};
  const std::array<Voxels, 3> seldom = {Voxels{{{5, 5, 21}, 1}, {{6, 6, 21}, 1}},
                                        Voxels{{{5, 6, 21}, 1}, {{6, 5, 21}, 1}},
                                        Voxels{{{5, 5, 19}, 1}, {{6, 6, 19}, 1}}};
  const auto is_shown_after = [&](std::size_t frames, const Voxels& surface) {
    TemporalVoxelFilter filter = filterBehind(flatWall());
    for (std::size_t i = 0; i < frames; ++i)
      EXPECT_EQ(shownOf(filter, flatWall() + seldom[i]), flatWall());
    return shownOf(filter, flatWall() + surface) == flatWall() + surface;
  };
  EXPECT_TRUE(is_shown_after(0, two_neighbours_each));
  EXPECT_FALSE(is_shown_after(1, two_neighbours_each));
  EXPECT_TRUE(is_shown_after(1, three_neighbours_each));
  // More of them than noise leaves.
  EXPECT_TRUE(is_shown_after(3, two_neighbours_each));
}

TEST(TemporalVoxelFilter, AVoxelWithOneNeighbourIsShownWhenItWasInMostFrames)
{
  TemporalVoxelFilter filter = filterBehind(flatWall());
  const Voxels pair = {{{15, 15, 30}, 1}, {{15, 15, 31}, 1}};
  // 1 - (7/8)^n exceeds .6 with the seventh frame.
  for (int i = 1; i <= 6; ++i)
    EXPECT_EQ(shownOf(filter, flatWall() + pair), flatWall()) << i;
  EXPECT_EQ(shownOf(filter, flatWall() + pair), flatWall() + pair);
}

TEST(TemporalVoxelFilter, WhatIsNotSeenIsHiddenAfterFiveEighthsOfTheFrames)
{
  for (const unsigned int frames : {8u, 16u}) {
    TemporalVoxelFilter filter = filterBehind(flatWall(), frames);
    for (unsigned int i = 1; i <= frames * 5 / 8; ++i)
      EXPECT_EQ(shownOf(filter, wallWithHole()), flatWall()) << i;
    EXPECT_EQ(shownOf(filter, wallWithHole()), wallWithHole());
  }
}

TEST(TemporalVoxelFilter, WhatTheSensorSeesThroughIsHiddenInTheSecondFrame)
{
  const Voxels box = squarePlate(20, 26, 30);
  // The box hides nothing of the wall that its frames lack.
  TemporalVoxelFilter filter = filterBehind(flatWall() + box);
  TemporalVoxelFilter without_sensor;
  for (int i = 0; i < 10; ++i)
    shownOf(without_sensor, flatWall() + box, std::nullopt);
  EXPECT_EQ(shownOf(filter, flatWall()), flatWall() + box);
  EXPECT_EQ(shownOf(filter, flatWall()), flatWall());
  for (int i = 1; i <= 5; ++i)
    EXPECT_EQ(shownOf(without_sensor, flatWall(), std::nullopt), flatWall() + box) << i;
  EXPECT_EQ(shownOf(without_sensor, flatWall(), std::nullopt), flatWall());
}

TEST(TemporalVoxelFilter, WhatIsBehindOthersIsHiddenInTheSecondFrame)
{
  const auto plateAt = [](std::int64_t depth) { return squarePlate(16, 30, depth); };
  // The plate comes nearer: where it was is behind it.
  TemporalVoxelFilter filter = filterBehind(flatWall() + plateAt(30));
  EXPECT_EQ(shownOf(filter, flatWall() + plateAt(20)),
            flatWall() + plateAt(20) + plateAt(30));
  // But at its edge, whose directions have nothing of the plate.
  const Voxels shown = shownOf(filter, flatWall() + plateAt(20));
  for (std::int64_t x = 18; x < 28; ++x)
    for (std::int64_t y = 18; y < 28; ++y)
      EXPECT_EQ(shown.count({x, y, 30}), 0u) << x << ' ' << y;
}

TEST(TemporalVoxelFilter, TimeDecidesHowLongIsShownWhatHasNothingNear)
{
  // Next to the hole's edge there is something measured within a voxel: frames decide.
  const Voxels edge_only = wallWithHole(1);
  for (const auto& [interval, frames] : {std::pair(500ms, 0),
                                         std::pair(200ms, 1),
                                         std::pair(100ms, 2),
                                         std::pair(50ms, 5),
                                         std::pair(33ms, 7)}) {
    SCOPED_TRACE(interval.count());
    TemporalVoxelFilter filter;
    std::chrono::nanoseconds time = 1000s;
    for (int i = 0; i < 10; ++i)
      shownOf(filter, flatWall(), in_front, time += interval);
    for (int i = 1; i <= 5; ++i)
      EXPECT_EQ(shownOf(filter, wallWithHole(), in_front, time += interval),
                i <= frames ? flatWall() : edge_only)
          << i;
    // One frame more ends what frames decide, too.
    Voxels rest = wallWithHole();
    for (const auto& [index, symbol] : flatWall())
      if (frames > 5 && edge_only.count(index) == 0)
        rest[index] = symbol;
    EXPECT_EQ(shownOf(filter, wallWithHole(), in_front, time += interval), rest);
  }
}

TEST(TemporalVoxelFilter, StampsThatJitterRepeatOrGoBackCountAsEvenOnes)
{
  std::mt19937 random(8);
  for (const bool has_jitter : {true, false}) {
    TemporalVoxelFilter stamped;
    TemporalVoxelFilter without;
    for (int i = 0; i < 30; ++i) {
      const std::chrono::milliseconds jitter(random() % 13);
      const auto time = has_jitter ? 50ms * i + jitter - 6ms : 1000ms - 50ms * (i / 2);
      const Voxels symbols = i % 7 < 2 ? flatWall() : wallWithHole();
      EXPECT_EQ(shownOf(stamped, symbols, in_front, time),
                shownOf(without, symbols, in_front))
          << i;
    }
  }
}

TEST(TemporalVoxelFilter, APauseEndsWhatIsHeld)
{
  TemporalVoxelFilter filter;
  for (int i = 0; i < 10; ++i)
    shownOf(filter, flatWall(), in_front, 50ms * i);
  EXPECT_EQ(shownOf(filter, wallWithHole(), in_front, 10h), wallWithHole(1));
}

TEST(TemporalVoxelFilter, PointsBehindTheCropProveThatTheWayToThemIsFree)
{
  const Voxels box = squarePlate(20, 26, 30);
  // A part of the wall is outside of the crop box; it is seen where the box was.
  Voxels in_crop;
  for (const auto& [index, symbol] : flatWall())
    if (index[0] > 30)
      in_crop[index] = symbol;
  std::vector<float> wall{std::nanf(""), 0.0f, 0.0f, 1e30f, 1e30f, 3e38f};
  for (int x = 0; x < 4 * wall_size; ++x)
    for (int y = 0; y < 4 * wall_size; ++y)
      for (const int axis : {x, y, static_cast<int>(4 * wall_depth)})
        wall.push_back(0.01f * static_cast<float>(axis));
  io::PointView view;
  view.coordinates = wall.data();
  view.coordinate_stride = 3 * sizeof(float);
  view.count = wall.size() / 3;
  for (const auto& [min_x, most_frames] :
       {std::pair(31 * voxel_edge, 1), std::pair(-1.0, 5)}) { // all inside: nothing
    TemporalVoxelFilter filter = filterBehind(in_crop + box);
    const io::BoundingBox crop{{min_x, -1.0, -1.0}, {4.0, 4.0, 4.0}};
    for (int i = 1; i <= 6; ++i) {
      io::SingleBatch points(view);
      filter.seeBeyond(points, crop, in_front);
      EXPECT_EQ(shownOf(filter, in_crop), i <= most_frames ? in_crop + box : in_crop)
          << i;
    }
  }
}

TEST(TemporalVoxelFilter, WithoutHoldingNothingIsShownThatHasNothingNear)
{
  TemporalVoxelFilter filter(8, false);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(shownOf(filter, flatWall()), flatWall());
  EXPECT_EQ(shownOf(filter, wallWithHole()), wallWithHole(1));
  EXPECT_EQ(shownOf(filter, flatWall()), flatWall());
  // Whatever the noise.
  TemporalVoxelFilter of_noise(8, false);
  std::mt19937 random(1);
  for (int i = 0; i < 60; ++i) {
    const Voxels symbols = noisyWall(random);
    for (const auto& [index, symbol] : shownOf(of_noise, symbols))
      EXPECT_TRUE(hasNear(symbols, index)) << i;
  }
}

TEST(TemporalVoxelFilter, OfASensorThatMovesWhatIsMeasuredIsShown)
{
  const auto motionOf =
      [](TemporalVoxelFilter& filter, const Voxels& symbols, double sensor_x) {
        VoxelFrame frame = scene(symbols);
        const TemporalFilterStatus status =
            filter.filter(frame, {std::array{sensor_x, 1.0, -0.5}, std::nullopt});
        EXPECT_TRUE(status.ok()) << status;
        if (status.sensor_motion == SensorMotion::Moving) {
          EXPECT_EQ(voxelsOf(frame), symbols);
          EXPECT_EQ(status.held + status.hidden, 0u);
        }
        return status.sensor_motion;
      };
  // In its own coordinates a wall comes nearer.
  TemporalVoxelFilter filter;
  EXPECT_EQ(motionOf(filter, flatWall(), 1.0), SensorMotion::Unknown);
  EXPECT_EQ(motionOf(filter, flatWall(), 1.0), SensorMotion::AtRest);
  for (int i = 1; i <= 10; ++i)
    EXPECT_EQ(motionOf(filter, flatWall(wall_depth - 2 * i), 1.0), SensorMotion::Moving)
        << i;
  for (int i = 0; i < 5; ++i)
    motionOf(filter, flatWall(40), 1.0);
  EXPECT_EQ(motionOf(filter, flatWall(40), 1.0), SensorMotion::AtRest);
  // Less than a third that moves before a wall is not the sensor.
  for (const std::int64_t edge : {20, 30})
    for (std::int64_t i = 0; i < 10; ++i) {
      const Voxels plate = squarePlate(0, edge, 30 - 3 * i);
      EXPECT_EQ(motionOf(filter, flatWall(40) + plate, 1.0), SensorMotion::AtRest) << i;
    }
  // By its positions, though nothing else changes.
  TemporalVoxelFilter posed;
  motionOf(posed, flatWall(), 1.0);
  EXPECT_EQ(motionOf(posed, flatWall(), 1.0 + voxel_edge / 2), SensorMotion::AtRest);
  EXPECT_EQ(motionOf(posed, flatWall(), 1.0 + 2 * voxel_edge), SensorMotion::Moving);
  for (int i = 0; i < 9; ++i)
    EXPECT_EQ(motionOf(posed, flatWall(), 1.0 + 2 * voxel_edge), SensorMotion::Moving);
  EXPECT_EQ(motionOf(posed, flatWall(), 1.0 + 2 * voxel_edge), SensorMotion::AtRest);
}

TEST(TemporalVoxelFilter, FramesWithoutSurfacesDoNotShowThatTheSensorMoves)
{
  const Voxels plate = squarePlate(0, 5, 10);
  for (const Voxels& few : {Voxels(), plate}) {
    TemporalVoxelFilter filter;
    for (int i = 0; i < 100; ++i) {
      const bool has_few = i == 0 || (i >= 40 && i < 60);
      VoxelFrame frame = scene(has_few ? few : flatWall());
      const TemporalFilterStatus status = filter.filter(frame, {});
      EXPECT_NE(status.sensor_motion, SensorMotion::Moving) << i;
    }
    // It is still found out by the frames that have some.
    VoxelFrame frame = scene(flatWall(wall_depth - 5));
    EXPECT_EQ(filter.filter(frame, {}).sensor_motion, SensorMotion::Moving);
  }
}

TEST(TemporalVoxelFilter, ASensorThatMovesSlowlyIsRecognisedByWhatDoesNotComeAgain)
{
  // It moves along the wall, of which nothing changes; posts before it pass by.
  TemporalVoxelFilter filter;
  int moving = 0;
  for (std::int64_t i = 0; i < 40; ++i) {
    Voxels symbols = flatWall();
    for (std::int64_t x = 23 - i % 24; x < wall_size; x += 24)
      for (std::int64_t y = 0; y < wall_size; ++y)
        for (std::int64_t z = 1; z <= 4; ++z)
          symbols[{x, y, wall_depth - z}] = 5;
    VoxelFrame frame = scene(symbols);
    const TemporalFilterStatus status = filter.filter(frame, {});
    ASSERT_TRUE(status.ok()) << status;
    moving += status.sensor_motion == SensorMotion::Moving ? 1 : 0;
    std::size_t not_near = 0;
    for (const auto& [index, symbol] : voxelsOf(frame))
      not_near += hasNear(symbols, index) ? 0 : 1;
    if (i >= 4) {
      EXPECT_LE(16 * not_near, frame.size()) << i;
    }
  }
  EXPECT_GE(moving, 20);
}

TEST(TemporalVoxelFilter, APositionThatMostVoxelsAreHiddenFromIsNotUsed)
{
  // From beside the scene all walls are behind the first one.
  const std::array<double, 3> beside = {
      -1.0, wall_size * voxel_edge / 2, wall_depth * voxel_edge};
  Voxels walls;
  for (std::int64_t depth = 40; depth <= 60; depth += 4)
    walls = walls + flatWall(depth);
  const Voxels box = squarePlate(20, 26, 10);
  const std::array<double, 3> wrong = {
      wall_size * voxel_edge / 2, wall_size * voxel_edge / 2, -0.5};
  for (const auto& position :
       {wrong, beside, std::array<double, 3>{std::nan(""), 0.0, 0.0}}) {
    TemporalVoxelFilter filter;
    for (int i = 0; i < 10; ++i)
      shownOf(filter, walls + box, position);
    for (int i = 1; i <= 5; ++i)
      EXPECT_EQ(shownOf(filter, walls, position).size(), walls.size() + box.size());
    EXPECT_EQ(shownOf(filter, walls, position), walls);
  }
}

} // namespace
