// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief The least depth in each direction around a sensor.
 *
 * Directions are squares on the six faces of a cube around the sensor, 0.35 degrees
 * wide in the middle of a face and half as wide at its edges. A depth is the distance
 * along the face's axis, in any unit. Each result of floating-point arithmetic is one
 * operation, so that no compiler rounds otherwise.
 */
class DirectionDepths {
public:
  /** \brief Squares along an edge of a face. */
  static constexpr std::uint32_t width = 256;

  /** \brief Of a square without a depth. */
  static constexpr float unseen = std::numeric_limits<float>::infinity();

  /** \brief Where a point is from the sensor. */
  struct Direction {
    std::uint32_t square; ///< (face * width + row) * width + column
    float depth;
  };

  /** \param[in] from_sensor the point, less the sensor's position */
  static Direction
  directionOf(const std::array<float, 3>& from_sensor)
  {
    // The axes in their order from that of the face on; without an array, whose members
    // would be read before they are written.
    const auto [x, y, z] = from_sensor;
    std::uint32_t axis = 0;
    float ahead = x;
    float row = y;
    float column = z;
    if (std::fabs(y) > std::fabs(ahead)) {
      axis = 1;
      ahead = y;
      row = z;
      column = x;
    }
    if (std::fabs(z) > std::fabs(ahead)) {
      axis = 2;
      ahead = z;
      row = x;
      column = y;
    }
    const float depth = std::fabs(ahead);
    // -1..1 -> squares
    const auto square = [depth](float across) {
      return std::min(static_cast<std::uint32_t>((across / depth + 1.0f) * 128.0f),
                      width - 1);
    };
    if (!(depth > 0.0f))
      return {0, 0.0f};
    const std::uint32_t face = 2 * axis + (ahead < 0.0f ? 1 : 0);
    return {(face * width + square(row)) * width + square(column), depth};
  }

  /** \brief Takes a depth, if it is the least of its square. */
  void
  add(const Direction& direction)
  {
    std::vector<float>& face = faces_[direction.square / face_size];
    if (face.empty())
      face.assign(face_size, unseen);
    float& depth = face[direction.square % face_size];
    // Without a branch, which would be mispredicted.
    io::ensureSize(squares_, count_ + 1);
    squares_[count_] = direction.square;
    count_ += static_cast<std::size_t>(depth == unseen);
    depth = std::min(depth, direction.depth);
  }

  /** \brief The least depth of a square, or \ref unseen. */
  float
  operator[](std::uint32_t square) const
  {
    const std::vector<float>& face = faces_[square / face_size];
    return face.empty() ? unseen : face[square % face_size];
  }

  /** \brief Calls a function with each square that has one. */
  template <typename Visit>
  void
  forEachSquare(Visit&& visit) const
  {
    for (std::size_t i = 0; i < count_; ++i)
      visit(squares_[i]);
  }

  void
  clear()
  {
    forEachSquare([this](std::uint32_t square) {
      faces_[square / face_size][square % face_size] = unseen;
    });
    count_ = 0;
  }

private:
  static constexpr std::uint32_t face_size = width * width;

  std::array<std::vector<float>, 6> faces_; // empty until there is a depth
  std::vector<std::uint32_t> squares_;      // count_ of them are not unseen
  std::size_t count_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI
