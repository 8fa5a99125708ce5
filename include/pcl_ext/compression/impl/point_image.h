// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Rays of a row of a spinning sensor: the point at depth n is at
 * `along + n * run` in the direction of its column, turned by (cosine, sine), at
 * `across` to the left of that, and at `up + n * rise`. */
struct RayRow {
  std::int32_t cosine = 0; ///< units of 2^-30
  std::int32_t sine = 0;   ///< units of 2^-30
  std::int32_t run = 0;    ///< voxels for a step of depth, units of 2^-24
  std::int32_t rise = 0;   ///< likewise
  std::int32_t along = 0;  ///< voxels, units of 2^-16
  std::int32_t across = 0; ///< likewise
  std::int32_t up = 0;     ///< likewise

  bool
  operator==(const RayRow& other) const
  {
    return cosine == other.cosine && sine == other.sine && run == other.run &&
           rise == other.rise && along == other.along && across == other.across &&
           up == other.up;
  }
};

/** \brief What kind of sensor measures along its rays. */
enum class RayShape : std::uint8_t {
  Planar = 0,  ///< a camera: depth along the optical axis
  Spinning = 1 ///< a lidar that turns: rows are cones, columns are directions
};

/** \brief Place and directions of rays: what changes as the sensor moves. */
struct RayPose {
  /** \brief Position of the sensor from the grid's lowest corner, voxels in units of
   * 2^-16. */
  std::array<std::int64_t, 3> origin{};
  /** \brief Of a camera x, y, z of a step of depth at row and column 0, and its changes
   * from a column to the next and from a row to the next, voxels in units of 2^-40; of a
   * spinning sensor its axes x, y and z in the grid, units of 2^-30. */
  std::array<std::array<std::int64_t, 3>, 3> vectors{};

  bool
  operator==(const RayPose& other) const
  {
    return origin == other.origin && vectors == other.vectors;
  }

  bool
  operator!=(const RayPose& other) const
  {
    return !(*this == other);
  }
};

/** \brief Where the points of an image can be: one number, the depth, says where on the
 * ray of its pixel a point is. All numbers are integers, so that all machines compute the
 * same positions (doc/bitstream_supplement.md, "Image"). */
struct RayModel {
  RayShape shape = RayShape::Planar;
  /** \brief Whether depth n is half a step further: in the middle of what it stands
   * for, where depths are no multiples of a step. */
  bool has_half_steps = false;
  RayPose pose;
  /** \brief Of a spinning sensor: cosine and sine of the angle by which column 2^k is
   * turned against column 0, units of 2^-30. */
  std::vector<std::array<std::int32_t, 2>> turns;
  std::vector<RayRow> rows; ///< likewise; as many as the image has

  /** \brief Whether rays are the same but for their pose. */
  bool
  isSameButForPose(const RayModel& other) const
  {
    return shape == other.shape && has_half_steps == other.has_half_steps &&
           turns == other.turns && rows == other.rows;
  }
};

/** \brief Most pixels of an image, and most columns and rows. */
constexpr std::uint32_t most_image_pixels = 1u << 24;
constexpr std::uint32_t most_image_side = 1u << 16;

/** \brief Depths are below it. */
constexpr std::uint32_t depth_end = 1u << 22;

/** \brief The order that a sensor has its points in, and rays on which they are. */
struct PointImage {
  std::uint32_t width = 0;  ///< columns; 0: there is no image
  std::uint32_t height = 0; ///< rows
  /** \brief Whether decoded clouds have these columns and rows. Others have only the
   * points, in the order of their voxels. */
  bool is_organised = true;
  /** \brief Whether points in the voxel of the sensor are coded as such: where drivers
   * write missing points as (0, 0, 0). Their depth is 0. */
  bool has_points_at_sensor = false;
  RayModel rays;
  /** \brief Pixel of each point of a frame, row * width + column; ascending within a
   * voxel. */
  std::vector<std::uint32_t> pixels;
  /** \brief Depth of each point, steps on its ray. */
  std::vector<std::uint32_t> depths;

  bool
  hasPixels() const
  {
    return width > 0;
  }

  std::size_t
  pixelCount() const
  {
    return std::size_t{width} * height;
  }
};

/** \brief Position of the voxel of the sensor in the grid, which it may be outside of. */
inline std::array<std::int64_t, 3>
sensorVoxel(const RayPose& pose)
{
  return {pose.origin[0] >> 16, pose.origin[1] >> 16, pose.origin[2] >> 16};
}

/** \brief Bits of the largest number of a column, for RayModel::turns. */
constexpr unsigned int
columnBits(std::uint32_t width)
{
  unsigned int bits = 0;
  while (width > std::uint64_t{1} << bits)
    ++bits;
  return bits;
}

/** \brief Whether the size of an image and its rays are within their ranges. */
PCL_EXT_CODEC_EXPORT bool
isConsistent(const PointImage& image);

} // namespace io
} // namespace pcl_ext
