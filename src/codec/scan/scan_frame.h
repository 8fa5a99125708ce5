// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxel_grid.h>

#include "codec/scan/scan_rays.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Depths are below it. */
constexpr std::uint32_t depth_end = std::uint32_t{1} << 24;

/** \brief A point is fewer edges than this from the place of its depth, so that no place
 * overflows. */
constexpr std::int32_t most_steps = 1 << 28;

/** \brief In the place of a depth: a point at the sensor, as drivers write missing
 * ones. */
constexpr std::uint32_t at_sensor = ~std::uint32_t{0} - 1;

/** \brief A point that is beside the ray of its pixel. */
struct PointBesideRay {
  std::uint32_t pixel;
  /** \brief Edges along x, y and z from the place of its depth, fewer than
   * most_steps. */
  std::array<std::int32_t, 3> steps;
};

/** \brief Most pixels of a scan, and most columns and rows of one that has rays. */
constexpr std::uint32_t most_pixels = 1u << 24;
constexpr std::uint32_t most_side = 1u << 16;

/** \brief In which order the points of a cloud are. */
enum class PointOrder : std::uint8_t {
  Organised = 0,     ///< in rows and columns, with missing points
  RowByRow = 1,      ///< without missing points
  ColumnByColumn = 2 ///< likewise
};

/** \brief What the points of a scan have in common, and most scans of a stream. */
struct ScanLayout {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  PointOrder order = PointOrder::Organised;
  /** \brief Whether points are in the centres of voxels, as coordinates were multiples of
   * an edge. */
  bool is_on_lattice = false;
  /** \brief With ColumnByColumn all rows, as their points come in each column. */
  std::vector<std::uint16_t> firing_order;
  /** \brief With ColumnByColumn how many columns each row is moved to the right, so that
   * points that are side by side in the world are so in the scan; empty: none is. */
  std::vector<std::uint16_t> row_shifts;
  ScanRays rays; ///< without columns

  std::uint32_t
  shiftOf(std::uint32_t row) const
  {
    return row_shifts.empty() ? 0 : row_shifts[row];
  }

  /** \brief Number of the columns of rays: without those that only moved rows have. */
  std::uint32_t
  rayColumns() const
  {
    return row_shifts.empty()
               ? width
               : width - *std::max_element(row_shifts.begin(), row_shifts.end());
  }

  std::size_t
  pixelCount() const
  {
    return std::size_t{width} * height;
  }

  /** \brief Whether points are a sequence without rays: they are in the first pixels, and
   * none is missing before the last row. */
  bool
  isSequence() const
  {
    return rays.shape == RayShape::Free && order == PointOrder::RowByRow;
  }

  /** \brief Whether a P-frame may have one layout after an I-frame with the other: the
   * sensor moves, spinning ones have other columns, and sequences any size. */
  bool
  mayFollow(const ScanLayout& other) const
  {
    return (width == other.width || rays.shape == RayShape::Spinning || isSequence()) &&
           (height == other.height || isSequence()) && order == other.order &&
           is_on_lattice == other.is_on_lattice && firing_order == other.firing_order &&
           row_shifts == other.row_shifts && rays.shape == other.rays.shape &&
           rays.has_half_depths == other.rays.has_half_depths &&
           rays.turns == other.rays.turns && rays.rows == other.rays.rows;
  }
};

/** \brief Whether all numbers of a layout are within their ranges, so that no place of a
 * point overflows. */
bool
isConsistent(const ScanLayout& layout);

/** \brief The points of a sensor, in its order, without voxels: each is on the ray of its
 * pixel, or a number of edges beside it. */
struct ScanFrame : ScanLayout {
  VoxelGrid grid; ///< from whose lowest corner places are counted, in its edges

  std::vector<std::uint32_t> pixels; ///< of each point, row * width + column, ascending
  std::vector<std::uint32_t> depths; ///< likewise, or at_sensor
  /** \brief Of each point of a spinning sensor how far its ray is turned from that of its
   * pixel, see ScanRays::turns; empty: none is. */
  std::vector<std::int32_t> turns;
  /** \brief Points that are not at the places of their depths, by pixel; none at_sensor.
   * Without rays all depths are 0, at the origin. */
  std::vector<PointBesideRay> beside;

  IntensityScale intensity_scale;         ///< bits 0: no intensities
  std::vector<std::uint16_t> intensities; ///< symbols of intensity_scale
  unsigned int colour_bits = 0;           ///< of a channel, 1..8; 0: no colours
  std::vector<VoxelColour> colours;
  std::vector<FrameField> fields; ///< their numbers in the order of the pixels
  std::shared_ptr<const MessageLayout> layout; ///< see VoxelFrame

  void
  clearPoints()
  {
    pixels.clear();
    depths.clear();
    turns.clear();
    beside.clear();
    rays.columns.clear();
    intensities.clear();
    colours.clear();
    for (FrameField& field : fields)
      field.numbers.clear();
  }
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
