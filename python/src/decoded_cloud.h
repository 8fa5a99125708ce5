// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_field.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <pybind11/numpy.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_ext::python {

namespace py = pybind11;

/** \brief The points of a decoded frame in memory of their own: x, y, z as float32, or
 * as float64 where VoxelFrame::needsDoubles(), and, if the frame has them, intensity as
 * float32, r, g, b as uint8, and further fields, which replace an intensity and a colour
 * of the same name. In rows and columns if the frame has these. */
class DecodedCloud {
public:
  /** \brief Copies the voxels of a frame; does not need the GIL. */
  explicit DecodedCloud(const io::VoxelFrame& frame);

  /** \brief Hands the points over to a structured array of numpy; needs the GIL. */
  py::array
  intoArray();

private:
  struct Column {
    io::FieldDescription description;
    std::size_t offset; // of its first value in a point, bytes
  };

  /** \brief Adds a column to the layout of a point.
   * \return its offset
   */
  std::size_t
  addColumn(const io::FieldDescription& description);

  void
  writeField(const io::VoxelFrame& frame,
             const io::FrameField& field,
             std::size_t offset);

  unsigned char*
  pointAt(const io::VoxelFrame& frame, std::size_t point);

  void
  writeMissingPoints(bool are_doubles);

  std::vector<Column> columns_;
  std::size_t width_;
  std::size_t height_;
  std::size_t point_bytes_ = 0;
  std::unique_ptr<unsigned char[]> points_;
};

} // namespace pcl_ext::python
