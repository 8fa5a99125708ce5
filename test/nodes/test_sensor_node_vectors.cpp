// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/sensor_node.h>

#include "simd/vector_choice.h"
#include "simulator/crop_box.h"
#include "simulator/robot_cell.h"

#include <pcl/conversions.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace {

using pcl_ext::cell::CellFrame;
using pcl_ext::cell::RobotCell;
using pcl_ext::nodes::SensorNode;
using pcl_ext::nodes::SensorNodeSettings;

using Bytes = std::vector<std::uint8_t>;

/** \brief While it lives, vectors are those of a machine without AVX2. */
class WithoutAvx2 {
public:
  WithoutAvx2() { pcl_ext::may_use_avx2 = false; }
  ~WithoutAvx2() { pcl_ext::may_use_avx2 = true; }
  WithoutAvx2(const WithoutAvx2&) = delete;
  WithoutAvx2&
  operator=(const WithoutAvx2&) = delete;
};

std::vector<Bytes>
encode(const std::vector<CellFrame>& frames, double resolution)
{
  SensorNodeSettings settings;
  settings.law = pcl_ext::IntensityLaw::Count;
  settings.compression.resolution = resolution;
  settings.crop_box = pcl_ext::cell::cropBox();
  SensorNode node(settings);
  std::vector<Bytes> stream(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    pcl::PCLPointCloud2 cloud;
    pcl::toPCLPointCloud2(frames[i].cloud, cloud);
    EXPECT_TRUE(node.encode(cloud, pcl_ext::WorldPose(frames[i].pose), stream[i]).ok());
  }
  return stream;
}

TEST(SensorNodeVectors, BytesAreTheSameWithAvx2AndWithout)
{
  if (!pcl_ext::hasAvx2())
    GTEST_SKIP() << "this machine has no AVX2";
  RobotCell cell;
  std::vector<CellFrame> frames(3);
  for (std::uint32_t i = 0; i < frames.size(); ++i)
    cell.capture(1, i, frames[i]);
  // In the third case the points' voxels are computed by division.
  for (const double resolution : {0.04, 0.005, 0.00001}) {
    EXPECT_TRUE(pcl_ext::usesAvx2());
    const std::vector<Bytes> with_avx2 = encode(frames, resolution);
    const WithoutAvx2 without;
    EXPECT_FALSE(pcl_ext::usesAvx2());
    EXPECT_EQ(encode(frames, resolution), with_avx2) << resolution;
  }
}

} // namespace
