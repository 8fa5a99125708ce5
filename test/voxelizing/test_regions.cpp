/** \file
 * \brief Voxels of clouds in regions, and their levels and centres, against a naive
 * computation in metres.
 */
#include <pcl_ext/compression/voxel_frame.h>

#include "support/voxelized_stream.h"
#include "voxels/region_cells.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::WorldPose;

constexpr double edge = 0.05;

/** \brief The sensor at the centre of a voxel, as it is rounded to. */
WorldPose
tiltedPose()
{
  WorldPose pose = WorldPose::Identity();
  pose.linear() =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).matrix();
  pose.translation() = edge * Eigen::Vector3d(10.5, -3.5, 20.5);
  return pose;
}

IntensityCompressionSettings
regionsOf(const std::vector<Region>& boxes, double coarser_beyond = 0.0)
{
  IntensityCompressionSettings settings = settingsOf(edge);
  settings.regions.boxes = boxes;
  settings.regions.coarser_beyond = coarser_beyond;
  return settings;
}

/** \brief Regions that overlap, in both frames. */
std::vector<Region>
someBoxes()
{
  return {{{{-0.4, -0.4, -0.4}, {0.6, 0.3, 0.8}}, 0, RegionFrame::World},
          {{{-1.0, -1.5, 0.1}, {1.3, 1.7, 2.1}}, 2, RegionFrame::Sensor},
          {{{-3.0, -1.0, -2.0}, {0.0, 3.0, 2.0}}, 1, RegionFrame::World}};
}

/** \brief A coarse voxel by its levels and, in units of its edge, its lowest corner. */
using Cell = std::pair<int, LatticeIndex>;

class NaiveRegions {
public:
  NaiveRegions(const RegionSettings& settings, const WorldPose& pose)
  : settings_(settings), pose_(pose)
  {
    for (const Region& region : settings.boxes)
      most_levels_ = std::max(most_levels_, static_cast<int>(region.doublings));
    coarsest_ = most_levels_;
    if (settings.coarser_beyond > 0.0)
      most_levels_ = std::max(most_levels_, static_cast<int>(settings.most_doublings));
  }

  /** \brief Levels -1: left out. Nothing: too near to a boundary to be sure. */
  std::optional<Cell>
  cellOf(const Point& point) const
  {
    for (int levels = most_levels_; levels >= 0; --levels) {
      const double side = std::ldexp(edge, levels);
      const auto index = [side](float coordinate) {
        return static_cast<std::int64_t>(std::floor(double{coordinate} / side));
      };
      const LatticeIndex at = {index(point.x), index(point.y), index(point.z)};
      const Eigen::Vector3d centre = Eigen::Vector3d(static_cast<double>(at[0]) + 0.5,
                                                     static_cast<double>(at[1]) + 0.5,
                                                     static_cast<double>(at[2]) + 0.5) *
                                     side;
      const std::optional<int> wanted = levelsAt(centre);
      if (!wanted)
        return std::nullopt;
      if (*wanted >= levels)
        return Cell{levels, at};
    }
    return Cell{-1, {}};
  }

private:
  std::optional<int>
  levelsAt(const Eigen::Vector3d& centre) const
  {
    constexpr double unsure = 0.1 * edge;
    const Eigen::Vector3d from_sensor = pose_.inverse() * centre;
    for (const Region& region : settings_.boxes) {
      const bool is_of_sensor = region.frame == RegionFrame::Sensor;
      const Eigen::Vector3d& at = is_of_sensor ? from_sensor : centre;
      double inside = 1e9; // depth below the nearest face
      for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        inside = std::min(
            {inside, at[axis] - region.box.min[i], region.box.max[i] - at[axis]});
      }
      // On a face of a world's box the lower end is inside, which half-open boxes of
      // whole voxels decide; rotated ones are rounded.
      if (std::abs(inside) < unsure)
        return std::nullopt;
      if (inside > 0.0)
        return static_cast<int>(region.doublings);
    }
    if (settings_.outside == OutsideRegions::LeftOut)
      return -1;
    if (settings_.coarser_beyond == 0.0)
      return coarsest_;
    const double doublings = std::log2(from_sensor.norm() / settings_.coarser_beyond);
    const double off =
        std::abs(std::exp2(std::round(doublings)) - std::exp2(doublings)) *
        settings_.coarser_beyond;
    if (off < unsure)
      return std::nullopt;
    return std::clamp(static_cast<int>(std::floor(doublings)) + 1,
                      0,
                      static_cast<int>(settings_.most_doublings));
  }

  const RegionSettings& settings_;
  WorldPose pose_;
  int most_levels_ = 0;
  int coarsest_ = 0;
};

/** \brief Voxelizes a cloud, and compares cells, sums and centres with naive ones. */
void
expectNaiveVoxels(const IntensityCompressionSettings& settings, const Cloud& all)
{
  const NaiveRegions naive(settings.regions, tiltedPose());
  std::map<Cell, float> sums;
  Cloud cloud;
  std::size_t left_out_points = 0;
  for (const Point& point : all)
    if (const std::optional<Cell> cell = naive.cellOf(point)) {
      cloud.push_back(point);
      if (cell->first < 0)
        ++left_out_points;
      else
        sums[*cell] += point.intensity;
    }
  ASSERT_GT(2 * cloud.size(), all.size());
  Stream stream(settings, pcl_ext::IntensityUnit::Native);
  stream.setSensorPose(tiltedPose());
  const VoxelFrame& frame = stream.add(cloud);
  EXPECT_EQ(stream.statistics.points_outside_regions, left_out_points);
  ASSERT_TRUE(frame.regions);
  EXPECT_EQ(frame.size(), sums.size());
  const std::vector<std::uint8_t> levels = voxelLevels(frame);
  std::size_t voxel = 0;
  forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    const double side = std::ldexp(edge, levels[voxel]);
    Cell cell{levels[voxel], {}};
    const std::array<float, 3> centre = {x, y, z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = double{centre[axis]} / side - 0.5;
      cell.second[axis] = std::llround(at);
      EXPECT_NEAR(at, std::round(at), 1e-4);
    }
    const auto sum = sums.find(cell);
    ASSERT_NE(sum, sums.end()) << "levels " << cell.first << " at " << x << ' ' << y;
    EXPECT_EQ(intensity, sum->second);
    ++voxel;
  });
  for (const auto& sum : sums) { // of all that contain another one, there is none
    Cell cell = sum.first;
    for (int up = cell.first + 1; up <= 5; ++up) {
      for (std::int64_t& index : cell.second)
        index = index >> 1;
      EXPECT_EQ(sums.count({up, cell.second}), 0u);
    }
  }
}

/** \brief A cloud with intensities that are whole numbers, so that sums are exact. */
Cloud
countedCloud(std::uint64_t seed, double half_side, std::size_t points = 20000)
{
  Cloud cloud = randomCloud(seed, -half_side, half_side, points);
  std::mt19937_64 random(seed);
  for (Point& point : cloud)
    point.intensity = static_cast<float>(random() % 4);
  return cloud;
}

TEST(Regions, HaveTheVoxelsAndSumsOfANaiveComputation)
{
  IntensityCompressionSettings settings = regionsOf(someBoxes());
  settings.aggregation = Aggregation::Sum;
  expectNaiveVoxels(settings, countedCloud(1, 2.5));
  settings.regions.outside = OutsideRegions::LeftOut;
  expectNaiveVoxels(settings, countedCloud(2, 3.5));
  settings = regionsOf(someBoxes(), 1.0);
  settings.aggregation = Aggregation::Sum;
  settings.regions.most_doublings = 4;
  expectNaiveVoxels(settings, countedCloud(3, 12.0));
  settings.regions.boxes.clear();
  expectNaiveVoxels(settings, countedCloud(4, 6.0));
}

TEST(Regions, AreCutOffWhereTheBoxOfTheSettingsIs)
{
  IntensityCompressionSettings settings = regionsOf(someBoxes(), 1.0);
  settings.aggregation = Aggregation::Sum;
  settings.bounding_box = {{-2.0, -2.0, -2.0}, {2.01, 2.02, 2.03}};
  Stream stream(settings);
  const VoxelFrame& frame = stream.add(countedCloud(5, 3.0));
  EXPECT_TRUE(isAligned(frame.grid, 3));
  EXPECT_GT(stream.statistics.points_outside_box, 1000u);
  EXPECT_EQ(stream.statistics.points_outside_grid, 0u);
}

TEST(Regions, MeansAreThoseOfAllPoints)
{
  const IntensityCompressionSettings settings =
      regionsOf({{{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}}, 3, RegionFrame::World}});
  Stream stream(settings, pcl_ext::IntensityUnit::Native);
  // Three points of one voxel and one of another, all in one coarse voxel.
  const VoxelFrame& frame = stream.add({{0.01f, 0.01f, 0.01f, 2.0f},
                                        {0.02f, 0.01f, 0.01f, 2.0f},
                                        {0.03f, 0.01f, 0.01f, 2.0f},
                                        {0.39f, 0.39f, 0.39f, 10.0f}});
  ASSERT_EQ(frame.size(), 1u);
  EXPECT_EQ(frame.intensity_scale.value(frame.intensities[0]), 4.0f);
  forEachPreciseCentre(frame, [](double x, double y, double z, float /*intensity*/) {
    EXPECT_NEAR(x, 0.2, 1e-7);
    EXPECT_NEAR(y, 0.2, 1e-7);
    EXPECT_NEAR(z, 0.2, 1e-7);
  });
}

TEST(Regions, FacesOfTheLatticeAndOfBoxesAreOfTheVoxelsAboveThem)
{
  // A box of whole coarse voxels, and what touches it on both sides.
  const IntensityCompressionSettings settings =
      regionsOf({{{{-0.4, -0.4, -0.4}, {0.4, 0.4, 0.4}}, 2, RegionFrame::World},
                 {{{-9.0, -9.0, -9.0}, {9.0, 9.0, 9.0}}, 0, RegionFrame::World}});
  Stream stream(settings);
  const VoxelFrame& frame = stream.add({{-0.41f, 0.01f, 0.01f},
                                        {-0.39f, 0.01f, 0.01f},
                                        {0.39f, 0.01f, 0.01f},
                                        {0.41f, 0.01f, 0.01f}});
  EXPECT_EQ(voxelLevels(frame), (std::vector<std::uint8_t>{0, 2, 2, 0}));
}

TEST(Regions, FramesOfOtherVoxelsAreInconsistent)
{
  Stream stream(regionsOf(someBoxes(), 1.0));
  const VoxelFrame good = stream.add(countedCloud(6, 3.0));
  ASSERT_TRUE(isConsistent(good));
  const std::vector<std::uint8_t> levels = voxelLevels(good);
  std::size_t coarse = 0;
  while (levels[coarse] != 2)
    ++coarse;
  const auto changed = [&good](auto&& change) {
    VoxelFrame frame = good;
    change(frame);
    return frame;
  };
  // Another voxel of the coarse one.
  EXPECT_FALSE(isConsistent(changed([&](VoxelFrame& f) { ++f.keys[coarse]; })));
  EXPECT_FALSE(isConsistent(changed([](VoxelFrame& f) { ++f.grid.first_index[0]; })));
  EXPECT_FALSE(isConsistent(changed([](VoxelFrame& f) {
    f.regions->boxes.clear();
    f.regions->coarser_beyond = 0;
  })));
  EXPECT_FALSE(isConsistent(changed([](VoxelFrame& f) {
    f.has_point_counts = true;
    f.point_counts.assign(f.size(), 1);
  })));
  const auto is_kept = [&](auto&& change) {
    VoxelRegions regions = *good.regions;
    change(regions);
    return isConsistent(regions);
  };
  using R = VoxelRegions;
  EXPECT_TRUE(is_kept([](R& r) { r.boxes.resize(64, r.boxes[0]); }));
  EXPECT_FALSE(is_kept([](R& r) { r.boxes.resize(65, r.boxes[0]); }));
  EXPECT_TRUE(is_kept([](R& r) { r.boxes[0].levels = 5; }));
  EXPECT_FALSE(is_kept([](R& r) { r.boxes[0].levels = 6; }));
  EXPECT_FALSE(is_kept([](R& r) { r.boxes[0].min[1] = r.boxes[0].max[1]; }));
  EXPECT_TRUE(is_kept([](R& r) { r.boxes[0].max[1] = farthest_region; }));
  EXPECT_FALSE(is_kept([](R& r) { r.boxes[0].max[1] = farthest_region + 1; }));
  EXPECT_FALSE(is_kept([](R& r) { r.levels_outside = 0; }));
  EXPECT_FALSE(is_kept([](R& r) { r.levels_outside = 6; }));
  EXPECT_FALSE(is_kept([](R& r) { r.leaves_out_outside = true; }));
  EXPECT_FALSE(is_kept([](R& r) { r.coarser_beyond = farthest_region + 1; }));
  EXPECT_FALSE(is_kept([](R& r) { r.pose.position[2] = -farthest_region - 1; }));
  EXPECT_FALSE(is_kept([](R& r) { r.pose.rotation[0][0] = whole_rotation + 1; }));
  EXPECT_FALSE(is_kept([](R& r) { r.boxes[1].is_in_sensor_frame = false; }));
}

} // namespace
