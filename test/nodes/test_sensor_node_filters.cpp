// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Outliers and what the temporal filter hides are removed before a SensorNode
 * encodes; what the filters themselves do is tested in test/outliers.
 */
#include <pcl_ext/filters/cloud_outlier_removal.h>
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "simulator/crop_box.h"
#include "support/cell_frames.h"
#include "support/lidar_room.h"
#include "support/node_tests.h"
#include "voxelizing/point_batches.h"

#include <cmath>

namespace {

namespace sensor_node_filters {

using namespace pcl_ext;
using namespace pcl_ext::nodes::test;

/** \brief A lidar's cloud of a standing sensor, in which it snows. */
pcl::PCLPointCloud2
lidarCloud(unsigned int seed, bool is_organised = true)
{
  pcl_ext::test::LidarRoom room;
  room.width = 180;
  room.height = 16;
  room.snow = 0.05;
  room.seed = seed;
  auto cloud = room.scan().cloud<pcl::PointCloud<pcl::PointXYZ>>();
  if (!is_organised) {
    cloud.width *= cloud.height;
    cloud.height = 1;
  }
  return messageOf(cloud, 1000 + seed);
}

std::size_t
finitePoints(const pcl::PCLPointCloud2& message)
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  pcl::fromPCLPointCloud2(message, cloud);
  std::size_t count = 0;
  for (const pcl::PointXYZ& point : cloud)
    count += std::isfinite(point.x) ? 1 : 0;
  return count;
}

TEST(SensorNodeLidarOutliers, AreRemovedAsPointsBeforeTheyAreVoxelsOfAnyEdge)
{
  for (const bool is_organised : {true, false}) {
    SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
    settings.compression.resolution = is_organised ? 0.0005 : 0.5;
    SensorNode plain(settings);
    settings.outlier_removal.emplace();
    PointOutlierRemovalSettings expected_settings;
    if (!is_organised) { // others than by default
      settings.outlier_removal->min_log_odds = expected_settings.min_log_odds = 3.0f;
      settings.outlier_removal->unit = AutomaticUnit{{false}};
      expected_settings.use_history = false;
    }
    SensorNode node(settings);
    PointOutlierRemoval removal(expected_settings);
    FrameDecoder decoder;
    FrameDecoder plain_decoder;
    for (unsigned int seed = 1; seed < 4; ++seed) {
      const pcl::PCLPointCloud2 cloud = lidarCloud(seed, is_organised);
      pcl::PCLPointCloud2 kept = cloud;
      const OutlierRemovalStatus status = removeOutliers(kept, removal);
      ASSERT_TRUE(status.ok()) << status.message();
      // The sensor has moved, but its points are judged as it saw them.
      const VoxelFrame voxels =
          decodedWith(decoder, encoded(node, cloud, poseOf(seed)));
      const VoxelFrame expected =
          decodedWith(plain_decoder, encoded(plain, kept, poseOf(seed)));
      EXPECT_EQ(voxels.keys, expected.keys);
      EXPECT_EQ(voxels.intensities, expected.intensities);
      const SensorNodeStatistics statistics = node.statistics();
      EXPECT_TRUE(statistics.judged_points);
      EXPECT_FALSE(statistics.outliers_stay);
      EXPECT_GT(statistics.points_removed, 50u);
      EXPECT_EQ(statistics.points_removed, status.removed);
      EXPECT_EQ(statistics.outliers_removed, 0u);
      EXPECT_EQ(statistics.preprocessing.points, std::size_t{180} * 16);
      EXPECT_EQ(statistics.preprocessing.points_not_finite,
                std::size_t{180} * 16 - finitePoints(cloud));
      EXPECT_EQ(statistics.frame.voxelization.points_used,
                finitePoints(cloud) - status.removed);
    }
  }
}

TEST(SensorNodeLidarOutliers, CloudsWithoutRowsAndNamedUnitsHaveTheirVoxelsJudged)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.outlier_removal.emplace();
  SensorNode node(settings);
  encoded(node, lidarCloud(1), poseOf(0));
  EXPECT_TRUE(node.statistics().judged_points);
  encoded(node, messageOf(cloudSeenFrom(poseOf(0), 1, 400, 5)), poseOf(0));
  EXPECT_FALSE(node.statistics().judged_points);
  EXPECT_EQ(node.statistics().points_removed, 0u);
  EXPECT_GT(node.statistics().outliers_removed, 0u);
  // What is refused leaves the statistics, and the next cloud is a lidar's again.
  pcl::PCLPointCloud2 invalid = lidarCloud(2);
  invalid.data.pop_back();
  expectLeftOut(node, invalid, poseOf(0), SensorNodeCode::InvalidCloud);
  EXPECT_FALSE(node.statistics().judged_points);
  encoded(node, lidarCloud(2), poseOf(0));
  EXPECT_TRUE(node.statistics().judged_points);
  EXPECT_GT(node.statistics().points_removed, 0u);
  EXPECT_EQ(node.statistics().outliers_removed, 0u);

  settings.outlier_removal->unit = VoxelsUnit();
  settings.outlier_removal->min_log_odds = 1000.0f; // all of them
  SensorNode of_voxels(settings);
  encoded(of_voxels, lidarCloud(1), poseOf(0));
  const SensorNodeStatistics statistics = of_voxels.statistics();
  EXPECT_FALSE(statistics.judged_points);
  EXPECT_EQ(statistics.points_removed, 0u);
  EXPECT_GT(statistics.outliers_removed, 0u);
  EXPECT_EQ(statistics.outliers_removed, statistics.frame.voxelization.voxels);
}

SensorNodeSettings
cellSettings(IntensityLaw law)
{
  SensorNodeSettings settings;
  settings.compression.resolution = 0.08;
  settings.law = law;
  settings.sensor = runtimeKinect();
  settings.crop_box = cell::cropBox();
  return settings;
}

/** \brief A camera of the robot cell. */
class CellFilters : public ::testing::Test {
protected:
  pcl::PCLPointCloud2
  capture(std::uint32_t frame)
  {
    return messageOf(cell::test::capture(cell, 1, frame).cloud);
  }

  cell::RobotCell cell{1};
  const WorldPose pose{cell.sensorPose(1)};
  std::array<double, 3> position{
      pose.translation().x(), pose.translation().y(), pose.translation().z()};
};

using SensorNodeOutlierRemoval = CellFilters;

TEST_F(SensorNodeOutlierRemoval, SendsWhatTheFilterKeeps)
{
  for (const auto& [law, unit] :
       {std::pair(IntensityLaw::Count, DensityUnit::Points),
        std::pair(IntensityLaw::Linear, DensityUnit::Faces),
        std::pair(IntensityLaw::Quadratic, DensityUnit::Faces)}) {
    SensorNodeSettings settings = cellSettings(law);
    EXPECT_FALSE(settings.outlier_removal);
    SensorNode plain(settings);
    settings.outlier_removal.emplace();
    SensorNode filtering(settings);
    VoxelOutlierRemoval removal({densityUnitSettings(densityUnitOf(law))});
    FrameDecoder plain_decoder;
    FrameDecoder filtered_decoder;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const pcl::PCLPointCloud2 cloud = capture(i);
      const auto bytes = encoded(plain, cloud, pose);
      const auto filtered_bytes = encoded(filtering, cloud, pose);
      EXPECT_LT(filtered_bytes.size(), bytes.size());
      VoxelFrame expected = decodedWith(plain_decoder, bytes);
      const VoxelFrame voxels = decodedWith(filtered_decoder, filtered_bytes);
      // The receiver's filter sees what the sensor's does.
      const std::size_t removed = removal.filter(expected).removed;
      EXPECT_GT(removed, 0u);
      EXPECT_EQ(filtering.statistics().outliers_removed, removed);
      EXPECT_EQ(filtering.statistics().density_unit, unit);
      EXPECT_EQ(plain.statistics().outliers_removed, 0u);
      EXPECT_EQ(voxels.keys, expected.keys);
      EXPECT_EQ(voxels.intensities, expected.intensities);
    }
  }
}

TEST_F(SensorNodeOutlierRemoval, TheQuadraticLawIsMeasuredInFacesInAnyLayout)
{
  SensorNodeSettings settings = cellSettings(IntensityLaw::Quadratic);
  settings.compression.format = io::StreamFormat::Published;
  const auto removedBy = [&](DensityUnit unit) {
    settings.outlier_removal.emplace().unit = densityUnitSettings(unit);
    SensorNode node(settings);
    encoded(node, capture(0), pose);
    return node.statistics().outliers_removed;
  };
  EXPECT_EQ(removedBy(DensityUnit::Automatic), removedBy(DensityUnit::Faces));
  EXPECT_NE(removedBy(DensityUnit::Automatic), removedBy(DensityUnit::Points));
}

TEST_F(SensorNodeOutlierRemoval, RaysBeginWhereTheSensorIs)
{
  SensorNodeSettings settings = cellSettings(IntensityLaw::Count);
  SensorNode plain(settings);
  settings.outlier_removal.emplace().unit = RaysUnit();
  SensorNode filtering(settings);
  settings.outlier_removal->unit = RaysUnit{{{0.0, 0.0, 50.0}}};
  SensorNode elsewhere(settings);
  RaysUnit rays;
  rays.intensities_are_counts = true;
  FrameDecoder decoder;
  for (std::uint32_t i = 0; i < 2; ++i) {
    WorldPose moved = pose;
    moved.pretranslate(Eigen::Vector3d(0.3 * i, 0.0, 0.0));
    const pcl::PCLPointCloud2 cloud = capture(i);
    const VoxelFrame frame = decodedWith(decoder, encoded(plain, cloud, moved));
    encoded(filtering, cloud, moved);
    encoded(elsewhere, cloud, moved);
    const auto removedFrom = [&](const std::array<double, 3>& at) {
      rays.sensor_position = at;
      VoxelFrame voxels = frame;
      return VoxelOutlierRemoval({rays}).filter(voxels).removed;
    };
    const std::size_t removed =
        removedFrom({position[0] + 0.3 * i, position[1], position[2]});
    EXPECT_GT(removed, 0u);
    EXPECT_EQ(filtering.statistics().outliers_removed, removed);
    EXPECT_EQ(elsewhere.statistics().outliers_removed, removedFrom({0.0, 0.0, 50.0}));
    EXPECT_NE(elsewhere.statistics().outliers_removed, removed);
  }
}

TEST_F(SensorNodeOutlierRemoval, VoxelsOfAnEdgeThatIsNotJudgedStayWithAWarning)
{
  SensorNodeSettings settings = cellSettings(IntensityLaw::Count);
  settings.compression.resolution = 0.25;
  settings.outlier_removal.emplace();
  SensorNode node(settings);
  Bytes bytes;
  EXPECT_EQ(node.encode(capture(0), pose, bytes).message(),
            "outliers stay: resolution is 0.25; it must be 0.001 to 0.2 m for outliers "
            "to be removed from voxels");
  EXPECT_TRUE(node.statistics().outliers_stay);
  settings.outlier_removal->unit = PointsUnit();
  EXPECT_FALSE(SensorNode(settings).settingsStatus().ok());
}

TEST_F(SensorNodeOutlierRemoval, UnitsMustFitTheLaw)
{
  const std::tuple<IntensityLaw, DensityUnitSettings, std::string> cases[] = {
      {IntensityLaw::Count,
       FacesUnit(),
       "outlier_removal.unit is faces and law is count, whose intensities are numbers "
       "of points; choose automatic or points, or law quadratic"},
      {IntensityLaw::Native,
       FacesUnit(),
       "outlier_removal.unit is faces and law is native, whose intensities are no "
       "densities; choose automatic, voxels or rays, or law quadratic"},
      {IntensityLaw::None,
       PointsUnit(),
       "outlier_removal.unit is points and law is none, which has no intensities; "
       "choose automatic, voxels or rays, or law count"},
      {IntensityLaw::Linear,
       FacesUnit{{}, -1.0f},
       "outlier_removal: full_intensity is -1; it must be a finite number above 0"},
      {IntensityLaw::Linear, AutomaticUnit(), ""},
      {IntensityLaw::Quadratic, FacesUnit(), ""},
      {IntensityLaw::Count, PointsUnit(), ""},
      {IntensityLaw::Native, AutomaticUnit(), ""},
      {IntensityLaw::Native, VoxelsUnit(), ""},
      {IntensityLaw::Native, RaysUnit(), ""},
      {IntensityLaw::None, AutomaticUnit(), ""},
      {IntensityLaw::None, VoxelsUnit(), ""},
      {IntensityLaw::None, RaysUnit(), ""}};
  for (const auto& [law, unit, message] : cases) {
    SensorNodeSettings settings = cellSettings(law);
    settings.outlier_removal.emplace().unit = unit;
    const SensorNodeStatus status = SensorNode(settings).settingsStatus();
    EXPECT_EQ(status.message(), message);
    EXPECT_EQ(status.code() == SensorNodeCode::InvalidSettings, !message.empty());
  }
}

using SensorNodeTemporalFilter = CellFilters;

TEST_F(SensorNodeTemporalFilter, SendsWhatTheFilterShowsFromTheSensorsPosition)
{
  for (const bool removes_outliers : {false, true}) {
    SCOPED_TRACE(removes_outliers);
    SensorNodeSettings settings = cellSettings(IntensityLaw::Count);
    settings.compression.i_frame_rate = 1000;
    SensorNode plain(settings);
    settings.compression.temporal_filter = 8;
    if (removes_outliers) // before the filter
      settings.outlier_removal.emplace();
    SensorNode filtering(settings);
    FrameDecoder plain_decoder;
    FrameDecoder filtered_decoder;
    VoxelOutlierRemoval removal({PointsUnit()});
    TemporalVoxelFilter filter(8);
    TemporalVoxelFilter without_position(8);
    SensorPreprocessor<NoIntensity> preprocessor{NoIntensity(0.08)};
    preprocessor.setSensorPose(Eigen::Isometry3d(pose));
    bool does_position_matter = false;
    for (std::uint32_t number = 0; number < 10; ++number) {
      pcl::PCLPointCloud2 cloud = capture(number);
      const auto time = 50ms * (number + 1);
      cloud.header.stamp = std::uint64_t{50000} * (number + 1); // microseconds
      VoxelFrame expected = decodedWith(plain_decoder, encoded(plain, cloud, pose));
      const std::size_t voxelized = expected.size();
      if (removes_outliers) {
        ASSERT_TRUE(removal.filter(expected).ok());
      }
      VoxelFrame other = expected;
      pcl::PointCloud<pcl::PointXYZI> points;
      ASSERT_TRUE(preprocessor.process(cloud, points).ok());
      io::PointView view;
      view.coordinates = &points[0].x;
      view.coordinate_stride = sizeof(points[0]);
      view.count = points.size();
      io::SingleBatch batch(view);
      filter.seeBeyond(batch, cell::cropBox(), position);
      ASSERT_TRUE(filter.filter(expected, {position, time}).ok());
      const VoxelFrame sent =
          decodedWith(filtered_decoder, encoded(filtering, cloud, pose));
      EXPECT_EQ(sent.keys, expected.keys);
      EXPECT_EQ(sent.intensities, expected.intensities);
      ASSERT_TRUE(without_position.filter(other).ok());
      does_position_matter |= other.keys != expected.keys;
      const io::FrameStatistics statistics = filtering.statistics().frame;
      EXPECT_EQ(statistics.voxelization.voxels, voxelized);
      EXPECT_EQ(statistics.coding.voxels, expected.size());
    }
    EXPECT_TRUE(does_position_matter);
  }
}

} // namespace sensor_node_filters

} // namespace
