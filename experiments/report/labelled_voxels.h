/** \file
 * \brief Voxels of a cell's sensor under all laws, with the truth, for the pictures.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <cell/robot_cell.h>

#include <cstddef>
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

/** \brief Voxels of a Kinect's frame within a box, in the order of their keys.
 * \param[in] frame one per point
 * \param[in] pose sensor -> world
 */
std::vector<LabelledVoxel>
kinectVoxels(const cell::CellFrame& frame,
             const Eigen::Isometry3d& pose,
             const io::BoundingBox& box,
             double resolution);

/** \brief Voxels of a lidar's revolution. */
std::vector<LabelledVoxel>
lidarVoxels(const cell::LidarFrame& frame,
            const Eigen::Isometry3d& pose,
            const io::BoundingBox& box,
            double resolution);

} // namespace report
} // namespace pcl_ext
