/** \file
 * \brief Voxels of the cell's sensors under all laws, with the truth, for the pictures.
 */
#pragma once

#include "simulator/labelled_stream.h"

#include <vector>

namespace pcl_ext {
namespace report {

/** \brief One voxel; what a decoder shows of it, and whether it is real. */
struct LabelledVoxel {
  float x, y, z;   ///< centre, world, metres
  float count;     ///< points, 255 at most
  float quadratic; ///< 255 times the share of a voxel face
  float linear;    ///< the same
  float native;    ///< the sensor's own, of a lidar; else 0
  bool is_noise;   ///< it holds no surface point
};

/** \brief Voxels of a sensor's frame, in the order of their keys. Intensities of laws that
 * the sensor does not have are 0. */
std::vector<LabelledVoxel>
labelledVoxels(const noise::LabelledFrame& frame);

} // namespace report
} // namespace pcl_ext
