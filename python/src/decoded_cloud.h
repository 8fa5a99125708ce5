#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <pybind11/numpy.h>

#include <cstddef>
#include <memory>

namespace pcl_ext {
namespace python {

namespace py = pybind11;

/** \brief The points of a decoded frame in memory of their own: x, y, z as float32, or
 * as float64 where VoxelGrid::needsDoubles(), and, if the frame has them, intensity as
 * float32 and r, g, b as uint8. */
class DecodedCloud {
public:
  /** \brief Copies the voxels of a frame; does not need the GIL. */
  explicit DecodedCloud(const io::VoxelFrame& frame);

  /** \brief Hands the points over to a structured array of numpy; needs the GIL. */
  py::array
  intoArray();

private:
  bool has_intensities_;
  bool has_colours_;
  std::size_t coordinate_bytes_;
  std::size_t count_;
  std::size_t point_bytes_;
  std::unique_ptr<unsigned char[]> points_;
};

} // namespace python
} // namespace pcl_ext
