// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "simulator/crop_box.h"
#include "simulator/robot_cell.h"
#include "support/cell_frames.h"
#include "support/node_tests.h"
#include "voxelizing/point_batches.h"

namespace {

namespace sensor_node_temporal_filter {

using namespace pcl_ext;
using nodes::test::decodedWith;
using nodes::test::encoded;
using nodes::test::messageOf;

constexpr double resolution = 0.08;
constexpr unsigned int frames = 8; // of the filter

nodes::SensorNodeSettings
settings(unsigned int temporal_filter)
{
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = resolution;
  settings.compression.i_frame_rate = 1000;
  settings.compression.temporal_filter = temporal_filter;
  settings.law = IntensityLaw::Count;
  settings.crop_box = cell::cropBox();
  return settings;
}

void
seeBeyondTheCrop(const pcl::PointCloud<pcl::PointXYZ>& cloud,
                 const WorldPose& pose,
                 TemporalVoxelFilter& filter)
{
  SensorPreprocessor<NoIntensity> preprocessor{NoIntensity(resolution)};
  preprocessor.setSensorPose(Eigen::Isometry3d(pose));
  pcl::PointCloud<pcl::PointXYZI> points;
  ASSERT_TRUE(preprocessor.process(cloud, points).ok());
  io::PointView view;
  view.coordinates = &points[0].x;
  view.coordinate_stride = sizeof(points[0]);
  view.count = points.size();
  io::SingleBatch batch(view);
  const Eigen::Vector3d position(pose.translation());
  filter.seeBeyond(batch, cell::cropBox(), {position.x(), position.y(), position.z()});
}

TEST(SensorNodeTemporalFilter, SendsWhatTheFilterShowsFromTheSensorsPosition)
{
  cell::RobotCell cell{1};
  const WorldPose pose{cell.sensorPose(1)};
  const std::array<double, 3> position = {
      pose.translation().x(), pose.translation().y(), pose.translation().z()};
  for (const bool removes_outliers : {false, true}) {
    nodes::SensorNode plain(settings(0));
    nodes::SensorNodeSettings filtering_settings = settings(frames);
    if (removes_outliers)
      filtering_settings.outlier_removal.emplace();
    nodes::SensorNode filtering(filtering_settings);
    io::FrameDecoder plain_decoder;
    io::FrameDecoder filtered_decoder;
    VoxelOutlierRemoval removal({PointsUnit()});
    TemporalVoxelFilter filter(frames);
    TemporalVoxelFilter without_position(frames);
    bool does_position_matter = false;
    for (std::uint32_t number = 0; number < 10; ++number) {
      const auto captured = cell::test::capture(cell, 1, number).cloud;
      pcl::PCLPointCloud2 cloud = messageOf(captured);
      const auto time = std::chrono::milliseconds(50) * (number + 1);
      cloud.header.stamp = std::uint64_t{50000} * (number + 1); // microseconds
      io::VoxelFrame expected = decodedWith(plain_decoder, encoded(plain, cloud, pose));
      const std::size_t voxelized = expected.size();
      if (removes_outliers) {
        ASSERT_TRUE(removal.filter(expected).ok());
      }
      io::VoxelFrame other = expected;
      seeBeyondTheCrop(captured, pose, filter);
      ASSERT_TRUE(filter.filter(expected, {position, time}).ok());
      const io::VoxelFrame sent =
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

} // namespace sensor_node_temporal_filter

} // namespace
