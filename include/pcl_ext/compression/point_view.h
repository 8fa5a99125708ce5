// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief A view of a field of points. */
struct FieldView {
  FieldDescription description; ///< name, type and count; its step is not used
  const void* first = nullptr;  ///< value of the first point; need not be aligned
  std::size_t stride = 0;       ///< bytes from one point to the next
};

/** \brief Columns and rows of a cloud or an image; without columns it has none. */
struct ImageSize {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

/** \brief A view of points: x, y, z as consecutive floats or doubles, metres, an
 * intensity and a colour. All may be in the same array or in several. Strides are bytes
 * from one point to the next, those of numbers a multiple of their size. */
struct PointView {
  std::size_t count = 0;              ///< number of points
  const float* coordinates = nullptr; ///< x of the first point
  /** \brief x of the first point in double precision, for coordinates whose size costs
   * floats precision, as those of maps; null: `coordinates` are used. */
  const double* double_coordinates = nullptr;
  std::size_t coordinate_stride = 0;
  const float* intensities = nullptr; ///< intensity of the first point; null: all are 1
  std::size_t intensity_stride = 0;
  /** \brief Colour of the first point: 32 bits in the machine's order, red, green and
   * blue from bit 16, 8 and 0 on, as PCL's field rgba; null: no colours. */
  const void* colours = nullptr;
  std::size_t colour_stride = 0;
  /** \brief Further fields, of which those are kept that StreamSettings::fields
   * names. */
  std::vector<FieldView> fields;
  /** \brief Columns and rows of a sensor's points, if they have any. Points that are
   * kept (StreamSettings::keep_points) come back in these, with missing ones,
   * where the cloud is coded as a scan.
   *
   * Without them rows are those of a field `ring`, or are found where points are at the
   * elevations of a lidar's lasers. Such points come back in the order of the cloud, if
   * that is the one in which the sensor fires its lasers; else row by row. */
  ImageSize image;
  /** \brief Pixel of each point, row * width + column, all different; null: there are
   * as many points as pixels, in their order. */
  const std::uint32_t* pixels = nullptr;
};

/** \brief The points of a cloud, some at a time: for points that are computed while
 * they are voxelized, so that the whole cloud is never in memory. */
class PCL_EXT_CODEC_EXPORT PointBatches {
public:
  virtual ~PointBatches();

  /** \brief Number of points of all batches, at most. */
  virtual std::size_t
  size() const = 0;

  virtual bool
  hasIntensities() const = 0;

  virtual bool
  hasColours() const = 0;

  /** \brief The further fields of the points, in the order of PointView::fields; none
   * without an override. */
  virtual std::vector<FieldDescription>
  fields() const;

  /** \brief Columns and rows of the points, if they have any; then PointView::pixels
   * says which, or they are all pixels, in their order. None without an override. */
  virtual ImageSize
  imageSize() const;

  /** \brief Begins with the first points again: some clouds are read more than once, as
   * those that the grid has to be fitted to, and the first one far from the world's
   * origin about ten times, unless the settings have an origin. Called before each
   * reading. */
  virtual void
  restart() = 0;

  /** \brief The next points, after restart() the first ones.
   * \param[out] points valid until the next call
   * \return false if there are none left
   */
  virtual bool
  next(PointView& points) = 0;

  /** \brief Points read since restart() whose depth is negative, for the statistics. */
  virtual std::size_t
  pointsBehindSensor() const;

  /** \brief Splits the cloud for several threads.
   * \param[in] parts how many, at least 1
   * \return that many batches, which may be read at the same time and together have the
   * points in their order; valid until the next call of a member. Empty, as without an
   * override: the cloud is not split.
   */
  virtual std::vector<PointBatches*>
  split(std::size_t parts);
};

namespace detail {

/** \brief The number at an offset in bytes. */
template <typename NumberT>
const NumberT*
atOffset(const NumberT* first, std::size_t bytes)
{
  return reinterpret_cast<const NumberT*>(
      reinterpret_cast<const unsigned char*>(first) + bytes);
}

} // namespace detail

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
