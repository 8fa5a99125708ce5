// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/point_image.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Numbers of x, y and z. */
using Triple = std::array<std::int64_t, 3>;

/** \brief The ray of a pixel: the point at depth n is at start + n * step, voxels from
 * the grid's lowest corner in units of 2^-32. */
struct Ray {
  Triple start;
  Triple step;

  /** \brief Position of a depth along an axis. */
  std::int64_t
  at(std::uint32_t depth, std::size_t axis) const
  {
    return start[axis] + static_cast<std::int64_t>(depth) * step[axis];
  }
};

/** \brief Computes the rays of an image, row by row (doc/bitstream_supplement.md,
 * "Image"). */
class RayReader {
public:
  /** \param[in] image isConsistent(); must not change while it is read */
  explicit RayReader(const PointImage& image);

  /** \brief Goes to a row. */
  void
  moveTo(std::uint32_t row);

  /** \brief The ray of a column of the row. */
  Ray
  at(std::uint32_t column) const
  {
    Ray ray = rays_.shape == RayShape::Planar ? planarRay(column) : spinningRay(column);
    for (std::size_t axis = 0; rays_.has_half_steps && axis < 3; ++axis)
      ray.start[axis] += ray.step[axis] >> 1;
    return ray;
  }

private:
  struct Direction {
    std::int64_t cosine;
    std::int64_t sine;
  };

  static Direction
  turned(const Direction& first, const Direction& second);

  Ray
  planarRay(std::uint32_t column) const;

  Ray
  spinningRay(std::uint32_t column) const;

  const RayModel& rays_;
  std::vector<Direction> columns_; // of a spinning sensor
  std::uint32_t row_ = 0;
};

} // namespace io
} // namespace pcl_ext
