// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "codec/scan/scan_points.h"
#include "support/golden_stream.h"
#include "support/scan_frames.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief A scan, and the points that it is decoded to. */
inline GoldenFrame
goldenScan(const scan::ScanFrame& scan)
{
  GoldenFrame golden;
  golden.scan = scan;
  scan::ScanFrame given_up = scan;
  scan::movePoints(given_up, golden.frame);
  return golden;
}

/** \brief Scans of a camera and of a lidar: with points beside their rays, few and many,
 * with intensities and colours, with fields, and without points. */
inline GoldenStream
goldenScans(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 5, {}};
  for (unsigned int i = 0; i < 7; ++i) {
    scan::ScanFrame frame = makeCamera();
    if (i == 3) { // nothing is seen
      frame.intensity_scale.bits = 12;
      frame.colour_bits = 7;
    }
    else
      addPoints(frame, i, false, i == 2 ? 3 : 40);
    stream.frames.push_back(goldenScan(frame));
  }
  for (unsigned int i = 0; i < 4; ++i) {
    scan::ScanFrame frame = makeLidar();
    fireOddRowsFirst(frame);
    addPoints(frame, 10 + i, i != 2);
    frame.intensity_scale.bits = 0;
    frame.intensities.clear();
    addFields(frame, i);
    stream.frames.push_back(goldenScan(frame));
  }
  return stream;
}

/** \brief Points without rays, in one row, in several, and in rows and columns, with
 * P-frames of other sizes; and scans of a lidar whose rows are moved. */
inline GoldenStream
goldenFreeScans(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 4, {}};
  for (unsigned int i = 0; i < 9; ++i) {
    const bool is_organised = i / 3 == 2;
    const std::uint32_t count = is_organised ? 600 : 500 + 7 * i;
    const std::uint32_t width = is_organised ? 30 : i / 3 == 1 ? 16 : count;
    scan::ScanFrame frame = makeFreePoints(i, width, count, is_organised);
    frame.is_on_lattice = i / 3 == 1;
    if (i / 3 == 0)
      addFields(frame, i);
    stream.frames.push_back(goldenScan(frame));
  }
  for (unsigned int i = 0; i < 3; ++i) {
    scan::ScanFrame frame = makeLidar();
    fireOddRowsFirst(frame);
    frame.width -= 2 * i;
    frame.rays.columns.resize(frame.width);
    moveRows(frame);
    addPoints(frame, 40 + i, i == 1);
    addFields(frame, i);
    stream.frames.push_back(goldenScan(frame));
  }
  return stream;
}

/** \brief Scans of sensors that move, with points in the centres of voxels, of other
 * numbers of columns, of one row and one column, and of a list of points. */
inline GoldenStream
goldenMovingScans(const std::string& name, Effort effort)
{
  GoldenStream stream{name, effort, 9, {}};
  scan::ScanFrame camera = makeCamera();
  for (unsigned int i = 0; i < 5; ++i) {
    camera.rays.pose.origin[0] += i < 3 ? 30000 : 0;
    camera.rays.pose.vectors[2][0] -= i % 2 == 0 ? std::int64_t{1} << 32 : 0;
    scan::ScanFrame frame = camera;
    frame.is_on_lattice = true;
    addPoints(frame, 20 + i);
    stream.frames.push_back(goldenScan(frame));
  }
  for (std::uint32_t i = 0; i < 5; ++i) {
    scan::ScanFrame frame = makeLidar();
    frame.order = scan::PointOrder::RowByRow;
    frame.width -= i / 2 * 3;
    frame.rays.columns.resize(frame.width);
    for (std::int32_t& column : frame.rays.columns)
      column -= static_cast<std::int32_t>(i);
    frame.rays.pose.origin[1] += 1000 * i;
    frame.rays.motion.vectors[0][1] = 1000000 * i;
    addPoints(frame, 30 + i, true);
    stream.frames.push_back(goldenScan(frame));
  }
  for (const auto& [width, height] :
       {std::pair<std::uint32_t, std::uint32_t>(3000, 1), {1, 3000}}) {
    scan::ScanFrame frame = makeCamera();
    frame.width = width;
    frame.height = height;
    frame.rays.has_half_depths = true;
    for (const std::size_t side : {1u, 2u})
      for (std::int64_t& change : frame.rays.pose.vectors[side])
        change /= 1024;
    addPoints(frame, height);
    addFields(frame, height);
    stream.frames.push_back(goldenScan(frame));
  }
  for (unsigned int i = 0; i < 2; ++i) {
    scan::ScanFrame frame = makeCamera();
    frame.order = scan::PointOrder::RowByRow;
    addPoints(frame, 50 + i);
    stream.frames.push_back(goldenScan(frame));
  }
  return stream;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
