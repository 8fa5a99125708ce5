// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "codec/scan/scan_frame.h"
#include "codec/scan/scan_points.h"
#include "voxels/point_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief A camera of 40 x 30 pixels in the middle of a grid of 1 mm. */
inline scan::ScanFrame
makeCamera()
{
  scan::ScanFrame frame;
  frame.grid.resolution = 0.001;
  frame.grid.depth = 20;
  frame.grid.first_index = {-(1 << 19), -(1 << 19), -(1 << 19)};
  frame.width = 40;
  frame.height = 30;
  frame.intensity_scale.bits = 0;
  frame.rays.pose.origin.fill(std::int64_t{1} << (19 + 16));
  // x and y of a step of depth of 1 mm: from -0.4 and -0.3, 0.02 a pixel.
  const auto fixed = [](double number) {
    return static_cast<std::int64_t>(std::ldexp(number, 40));
  };
  frame.rays.pose.vectors = {{{fixed(-0.4), fixed(-0.3), fixed(1.0)},
                              {fixed(0.02), 0, 0},
                              {0, fixed(0.02), 0}}};
  return frame;
}

/** \brief A lidar of 8 rows and 90 columns of 4 degrees that moves along x by 2 mm from a
 * column to the next. */
inline scan::ScanFrame
makeLidar()
{
  constexpr double pi = 3.14159265358979323846;
  scan::ScanFrame frame = makeCamera();
  frame.width = 90;
  frame.height = 8;
  scan::ScanRays& rays = frame.rays;
  rays.shape = scan::RayShape::Spinning;
  rays.pose.vectors = {};
  for (std::size_t axis = 0; axis < 3; ++axis)
    rays.pose.vectors[axis][axis] = 1 << 30;
  rays.motion.origin = {std::int64_t{2} << 32, 0, 0};
  for (int bit = 0; bit < 7; ++bit)
    rays.turns.push_back(
        {static_cast<std::int32_t>(std::ldexp(std::cos(std::ldexp(pi / 180, bit)), 30)),
         static_cast<std::int32_t>(
             std::ldexp(std::sin(std::ldexp(pi / 180, bit)), 30))});
  for (std::int32_t column = 0; column < 90; ++column)
    rays.columns.push_back(4 * column % 128);
  for (int row = 0; row < 8; ++row)
    rays.rows.push_back({1 << 30,
                         0,
                         static_cast<std::int32_t>(std::ldexp(0.98, 24)),
                         static_cast<std::int32_t>(std::ldexp(0.02 * row, 24)),
                         30 << 16,
                         -20 * (1 << 16),
                         40 << 16});
  return frame;
}

/** \brief Moves each row of a lidar to the right by another number of columns. */
inline void
moveRows(scan::ScanFrame& frame)
{
  frame.row_shifts.clear();
  for (std::uint32_t row = 0; row < frame.height; ++row)
    frame.row_shifts.push_back(static_cast<std::uint16_t>(3 * row % 8));
  frame.width += 7;
}

/** \brief Points without rays: a walk with leaps, some points at the sensor.
 * \param[in] count of them; of an organised scan all its pixels, of which a few are empty
 */
inline scan::ScanFrame
makeFreePoints(unsigned int seed,
               std::uint32_t width,
               std::uint32_t count,
               bool is_organised)
{
  std::mt19937 random(seed);
  const auto around_zero = [&random](std::int32_t most) {
    const auto numbers = 2 * static_cast<std::uint32_t>(most) + 1;
    return static_cast<std::int32_t>(random() % numbers) - most;
  };
  scan::ScanFrame frame = makeCamera();
  frame.rays.shape = scan::RayShape::Free;
  frame.rays.pose.vectors = {};
  frame.order = is_organised ? scan::PointOrder::Organised : scan::PointOrder::RowByRow;
  frame.width = is_organised ? width : std::min(width, count);
  frame.height = (count + frame.width - 1) / frame.width;
  std::array<std::int32_t, 3> steps = {4000, -3000, 1000};
  for (std::uint32_t pixel = 0; pixel < count; ++pixel) {
    if (is_organised && random() % 5 == 0)
      continue;
    const bool leaps = random() % 30 == 0;
    for (std::int32_t& along : steps)
      along = std::clamp(along + around_zero(leaps ? scan::most_steps - 1 : 9),
                         -scan::most_steps + 1,
                         scan::most_steps - 1);
    const bool is_at_sensor = random() % 40 == 0;
    frame.pixels.push_back(pixel);
    frame.depths.push_back(is_at_sensor && is_organised ? scan::at_sensor : 0);
    if (!is_at_sensor)
      frame.beside.push_back({pixel, steps});
  }
  frame.intensity_scale.bits = 9;
  for (std::size_t point = 0; point < frame.pixels.size(); ++point)
    frame.intensities.push_back(static_cast<std::uint16_t>(random() % 512));
  return frame;
}

/** \brief Adds a point to about three of four pixels that have a ray: on a surface with
 * steps, with noise, some at the sensor, with intensities and colours.
 * \param[in] beside_every one of so many points is beside its ray
 */
inline void
addPoints(scan::ScanFrame& frame,
          unsigned int seed,
          bool is_turned = false,
          std::uint32_t beside_every = 40)
{
  std::mt19937 random(seed);
  const auto below = [&random](std::uint32_t end) {
    return static_cast<std::uint32_t>(random() % end);
  };
  frame.intensity_scale.bits = 12;
  frame.colour_bits = 7;
  for (std::uint32_t pixel = 0; pixel < frame.pixelCount(); ++pixel) {
    const std::uint32_t column = pixel % frame.width;
    const std::uint32_t ray = column - frame.shiftOf(pixel / frame.width);
    if (below(4) == 0 || ray >= frame.rayColumns())
      continue;
    frame.pixels.push_back(pixel);
    frame.depths.push_back(below(50) == 0 ? scan::at_sensor
                                          : 2000 + 3 * column +
                                                (column > 20 ? 5000 : 0) + below(4));
    if (frame.depths.back() != scan::at_sensor && below(beside_every) == 0)
      frame.beside.push_back(
          {pixel,
           {static_cast<std::int32_t>(below(7)) - 3,
            scan::most_steps - 1 - static_cast<std::int32_t>(below(9)),
            -scan::most_steps + 1}});
    if (is_turned)
      frame.turns.push_back(static_cast<std::int32_t>(below(3)) - 1);
    frame.intensities.push_back(static_cast<std::uint16_t>(below(4096)));
    frame.colours.push_back({static_cast<std::uint8_t>(below(128)),
                             static_cast<std::uint8_t>(below(128)),
                             static_cast<std::uint8_t>(below(128))});
  }
}

/** \brief Makes the points of a lidar come column by column, its odd rows first. */
inline void
fireOddRowsFirst(scan::ScanFrame& frame)
{
  frame.order = scan::PointOrder::ColumnByColumn;
  frame.firing_order.clear();
  for (const std::uint32_t first : {1u, 0u})
    for (std::uint32_t row = first; row < frame.height; row += 2)
      frame.firing_order.push_back(static_cast<std::uint16_t>(row));
}

/** \brief Adds fields of a row, of a time that goes with the column, and of noise with
 * two values of each point. */
inline void
addFields(scan::ScanFrame& frame, unsigned int seed)
{
  std::mt19937 random(seed);
  frame.fields = {{{"ring", FieldType::UInt16}, {}},
                  {{"time", FieldType::UInt32}, {}},
                  {{"noise", FieldType::UInt8, 2}, {}}};
  for (const std::uint32_t pixel : frame.pixels) {
    frame.fields[0].numbers.push_back(pixel / frame.width);
    frame.fields[1].numbers.push_back(1000000000 + 55296 * (pixel % frame.width));
    for (int i = 0; i < 2; ++i)
      frame.fields[2].numbers.push_back(random() % 16);
  }
}

inline VoxelFrame
frameOf(scan::ScanFrame scan)
{
  VoxelFrame frame;
  scan::movePoints(scan, frame);
  setVoxels(frame);
  return frame;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::test
