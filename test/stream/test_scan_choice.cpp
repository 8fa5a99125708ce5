// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "codec/scan/scan_points.h"
#include "stream/frame_encoder.h"
#include "stream/scan_choice.h"
#include "support/scan_frames.h"
#include "support/voxel_frames.h"
#include "voxels/point_voxels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

TEST(ScanChoice, JudgesStripesOfColumnsButNotOfSequences)
{
  EncoderSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  ScanChoice choice(settings);
  // Points in 27 voxels, without an order in these: a few bytes as voxels.
  scan::ScanFrame scan = makeCamera();
  scan.rays.shape = scan::RayShape::Free;
  scan.rays.pose.vectors = {};
  scan.width = 200;
  scan.height = 200;
  std::mt19937 random(1);
  for (std::uint32_t pixel = 0; pixel < scan.pixelCount(); ++pixel) {
    scan.pixels.push_back(pixel);
    scan.depths.push_back(0);
    const auto step = [&random] { return static_cast<std::int32_t>(random() % 3) - 1; };
    scan.beside.push_back({pixel, {step(), step(), step()}});
  }
  EXPECT_TRUE(choice.prefersVoxels(scan));
  scan.order = scan::PointOrder::RowByRow;
  EXPECT_FALSE(ScanChoice(settings).prefersVoxels(scan));
}

/** \brief A lidar of 128 rows whose rays take as many bytes as an eighth of its points. */
scan::ScanFrame
makeLidarOfManyRows()
{
  scan::ScanFrame frame = makeLidar();
  std::mt19937 random(2);
  const auto below = [&random](std::uint32_t end) {
    return static_cast<std::int32_t>(random() % end);
  };
  scan::ScanRays& rays = frame.rays;
  rays.motion = {};
  for (int bit = 7; bit < 9; ++bit) {
    const double angle = std::ldexp(M_PI / 180.0, bit);
    rays.turns.push_back({static_cast<std::int32_t>(std::ldexp(std::cos(angle), 30)),
                          static_cast<std::int32_t>(std::ldexp(std::sin(angle), 30))});
  }
  rays.columns.clear();
  for (std::int32_t column = 0; column < 360; ++column)
    rays.columns.push_back(column);
  frame.width = 360;
  frame.height = 128;
  rays.rows.assign(frame.height, rays.rows.front());
  for (std::uint32_t i = 0; i < frame.height; ++i) {
    scan::RayRow& row = rays.rows[i];
    row.sine = below(1 << 28);
    row.rise = static_cast<std::int32_t>(i << 16) + below(1 << 14);
    row.along = below(1 << 18);
    row.across = below(1 << 18);
    row.up = below(1 << 18);
  }
  for (std::uint32_t pixel = 0; pixel < frame.pixelCount(); ++pixel) {
    frame.pixels.push_back(pixel);
    frame.depths.push_back(static_cast<std::uint32_t>(60 + below(4)));
  }
  return frame;
}

TEST(ScanChoice, RaysCountOnceForAPartOfThePoints)
{
  EncoderSettings settings;
  settings.resolution = 0.001;
  settings.keep_points = true;
  scan::ScanFrame scan = makeLidarOfManyRows();
  ScanChoice choice(settings);
  EXPECT_FALSE(choice.prefersVoxels(scan));
  FrameEncoder as_scan(settings.format, settings.i_frame_rate, settings.effort);
  const std::size_t scan_bytes = encoded(as_scan, scan).size();
  VoxelFrame voxels;
  scan::movePoints(scan, voxels);
  setVoxels(voxels);
  FrameEncoder as_voxels(settings.format, settings.i_frame_rate, settings.effort);
  EXPECT_LT(scan_bytes, encoded(as_voxels, voxels).size());
}

} // namespace
