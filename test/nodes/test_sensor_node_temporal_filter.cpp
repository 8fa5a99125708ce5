// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A SensorNode with the setting temporal_filter.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "simulator/crop_box.h"
#include "simulator/robot_cell.h"
#include "support/cell_frames.h"
#include "support/node_tests.h"
#include "voxelizing/point_batches.h"

namespace {

using namespace pcl_ext;
using nodes::test::decodedWith;
using nodes::test::encoded;
using nodes::test::messageOf;

/** \brief The first camera of the robot cell, with and without the filter. */
class SensorNodeTemporalFilter : public ::testing::Test {
protected:
  static constexpr unsigned int frames = 8; // of the filter

  SensorNodeTemporalFilter() : plain_(settings(0)), filtering_(settings(frames)) {}

  static nodes::SensorNodeSettings
  settings(unsigned int temporal_filter)
  {
    nodes::SensorNodeSettings settings;
    settings.compression.resolution = 0.08;
    settings.compression.i_frame_rate = 1000;
    settings.compression.temporal_filter = temporal_filter;
    settings.law = IntensityLaw::Count;
    settings.crop_box = cell::cropBox();
    return settings;
  }

  /** \brief One of 20 clouds a second. */
  pcl::PCLPointCloud2
  nextCloud()
  {
    pcl::PCLPointCloud2 cloud =
        messageOf(cell::test::capture(cell_, 1, number_++).cloud);
    cloud.header.stamp = std::uint64_t{50000} * number_; // microseconds
    return cloud;
  }

  /** \brief Of the last cloud. */
  std::chrono::nanoseconds
  time() const
  {
    return std::chrono::milliseconds(50) * number_;
  }

  /** \brief Encodes the next cloud with both nodes, and decodes it. */
  void
  step()
  {
    const pcl::PCLPointCloud2 cloud = nextCloud();
    plain_bytes_ = encoded(plain_, cloud, pose_);
    filtered_bytes_ = encoded(filtering_, cloud, pose_);
    plain_voxels_ = decodedWith(plain_decoder_, plain_bytes_);
    filtered_voxels_ = decodedWith(filtered_decoder_, filtered_bytes_);
  }

  /** \brief Shows a filter the points of the last cloud. */
  void
  seeBeyondTheCrop(TemporalVoxelFilter& filter)
  {
    SensorPreprocessor<NoIntensity> preprocessor(NoIntensity(0.08));
    preprocessor.setSensorPose(Eigen::Isometry3d(pose_));
    pcl::PointCloud<pcl::PointXYZI> points;
    ASSERT_TRUE(
        preprocessor.process(cell::test::capture(cell_, 1, number_ - 1).cloud, points)
            .ok());
    io::PointView view;
    view.coordinates = &points[0].x;
    view.coordinate_stride = sizeof(points[0]);
    view.count = points.size();
    io::SingleBatch batch(view);
    const Eigen::Vector3d position(pose_.translation());
    filter.seeBeyond(
        batch, cell::cropBox(), {position.x(), position.y(), position.z()});
  }

  cell::RobotCell cell_{1};
  const WorldPose pose_{cell_.sensorPose(1)};
  std::uint32_t number_ = 0;
  nodes::SensorNode plain_;
  nodes::SensorNode filtering_;
  io::FrameDecoder plain_decoder_;
  io::FrameDecoder filtered_decoder_;
  // Of the last cloud.
  std::vector<std::uint8_t> plain_bytes_;
  std::vector<std::uint8_t> filtered_bytes_;
  io::VoxelFrame plain_voxels_;
  io::VoxelFrame filtered_voxels_;
};

TEST_F(SensorNodeTemporalFilter, SendsWhatTheFilterShowsFromTheSensorsPosition)
{
  const std::array<double, 3> position = {
      pose_.translation().x(), pose_.translation().y(), pose_.translation().z()};
  TemporalVoxelFilter filter(frames);
  TemporalVoxelFilter without_position(frames);
  bool does_position_matter = false;
  for (int i = 0; i < 10; ++i) {
    step();
    io::VoxelFrame expected = plain_voxels_;
    seeBeyondTheCrop(filter);
    ASSERT_TRUE(filter.filter(expected, {position, time()}).ok());
    EXPECT_EQ(filtered_voxels_.keys, expected.keys);
    EXPECT_EQ(filtered_voxels_.intensities, expected.intensities);
    io::VoxelFrame other = plain_voxels_;
    ASSERT_TRUE(without_position.filter(other).ok());
    does_position_matter |= other.keys != expected.keys;
    const io::FrameStatistics statistics = filtering_.statistics().frame;
    EXPECT_EQ(statistics.voxelization.voxels, plain_voxels_.size());
    EXPECT_EQ(statistics.coding.voxels, expected.size());
  }
  EXPECT_TRUE(does_position_matter);
}

TEST_F(SensorNodeTemporalFilter, FiltersWhatTheOutlierRemovalLeaves)
{
  nodes::SensorNodeSettings both_settings = settings(frames);
  both_settings.outlier_removal.emplace();
  nodes::SensorNode both(both_settings);
  io::FrameDecoder decoder;
  VoxelOutlierRemoval removal({PointsUnit()});
  TemporalVoxelFilter filter(frames);
  const std::array<double, 3> position = {
      pose_.translation().x(), pose_.translation().y(), pose_.translation().z()};
  for (int i = 0; i < 10; ++i) {
    const pcl::PCLPointCloud2 cloud = nextCloud();
    io::VoxelFrame expected =
        decodedWith(plain_decoder_, encoded(plain_, cloud, pose_));
    ASSERT_TRUE(removal.filter(expected).ok());
    seeBeyondTheCrop(filter);
    ASSERT_TRUE(filter.filter(expected, {position, time()}).ok());
    const io::VoxelFrame sent = decodedWith(decoder, encoded(both, cloud, pose_));
    EXPECT_EQ(sent.keys, expected.keys);
    EXPECT_EQ(sent.intensities, expected.intensities);
  }
}

} // namespace
