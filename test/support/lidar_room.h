// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/compression/point_view.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace pcl_ext::test {

enum class Hit : std::uint8_t { None, Wall, Snow, Pole, Person };

/** \brief An image of a lidar, from the lowest row up. */
struct LidarScan {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<float> ranges; ///< metres, row after row; 0: no return
  std::vector<Hit> hits;
  std::vector<float> coordinates; ///< x, y, z; NaN without a return

  std::size_t
  size() const
  {
    return ranges.size();
  }

  io::PointView
  view() const
  {
    io::PointView points;
    points.count = size();
    points.coordinates = coordinates.data();
    points.coordinate_stride = 3 * sizeof(float);
    points.image = {width, height};
    return points;
  }

  template <typename CloudT>
  CloudT
  cloud() const
  {
    CloudT points(width, height);
    points.is_dense = false;
    for (std::size_t i = 0; i < size(); ++i) {
      points[i].x = coordinates[3 * i];
      points[i].y = coordinates[3 * i + 1];
      points[i].z = coordinates[3 * i + 2];
    }
    return points;
  }
};

struct LidarRoom {
  std::uint32_t width = 510; ///< columns, 0.7 degrees apart
  std::uint32_t height = 24; ///< rows, 1.25 degrees apart from -15 degrees up
  double x = 0.0;            ///< place of the sensor, whose floor is 1.5 m below it
  double snow = 0.0;         ///< share of the rays that meet a flake
  bool has_pole = false;     ///< one column wide, 3 m away
  bool has_person = false;   ///< half a metre wide, 4 m away, 1.7 m high
  double waviness = 0.0;     ///< degrees by which rows go up and down in a turn
  unsigned int seed = 1;

  double
  azimuth(std::uint32_t column) const
  {
    return M_PI * ((2.0 * column + 1.0) / width - 1.0);
  }

  double
  elevation(std::uint32_t row, std::uint32_t column) const
  {
    return M_PI / 180.0 * (1.25 * row - 15.0 + waviness * std::sin(azimuth(column)));
  }

  LidarScan
  scan() const
  {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    std::normal_distribution<double> noise(0.0, 0.008);
    LidarScan made;
    made.width = width;
    made.height = height;
    for (std::uint32_t row = 0; row < height; ++row)
      for (std::uint32_t column = 0; column < width; ++column) {
        const double turned = azimuth(column);
        const double slope = std::tan(elevation(row, column));
        const double cosine = std::cos(turned);
        const double sine = std::sin(turned);
        // Walls of 16 m x 12 m and 4.5 m high, without a roof.
        double from_axis = std::min(((cosine > 0.0 ? 8.0 : -8.0) - x) / cosine,
                                    (sine > 0.0 ? 6.0 : -6.0) / sine);
        if (slope < 0.0)
          from_axis = std::min(from_axis, -1.5 / slope);
        Hit hit = from_axis * slope < 3.0 ? Hit::Wall : Hit::None;
        if (has_pole && column == width / 3) {
          from_axis = 3.0;
          hit = Hit::Pole;
        }
        if (has_person && std::abs(turned) < std::atan(0.25 / 4.0) &&
            4.0 * slope > -1.5 && 4.0 * slope < 0.2) {
          from_axis = 4.0;
          hit = Hit::Person;
        }
        if (share(generator) < snow) {
          // Anywhere before what is behind it, or before the sky.
          from_axis = 1.0 + share(generator) *
                                (0.9 * (hit == Hit::None ? 10.0 : from_axis) - 1.0);
          hit = Hit::Snow;
        }
        const double range =
            from_axis * std::sqrt(1.0 + slope * slope) + noise(generator);
        const bool has_return = hit != Hit::None && share(generator) > 0.01;
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const double flat = has_return ? range / std::sqrt(1.0 + slope * slope) : nan;
        made.ranges.push_back(has_return ? static_cast<float>(range) : 0.0f);
        made.hits.push_back(has_return ? hit : Hit::None);
        made.coordinates.push_back(static_cast<float>(flat * cosine));
        made.coordinates.push_back(static_cast<float>(flat * sine));
        made.coordinates.push_back(static_cast<float>(flat * slope));
      }
    return made;
  }
};

} // namespace pcl_ext::test
