/** \file
 * \brief Through which voxels a sensor really sees.
 */
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "simulator/labelled_stream.h"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief What a sensor looks at in a frame, without any error of measurement. */
class TrueView {
public:
  /** \brief The view of a camera, with the rays of cell::RayGrid, or of a lidar, with
   * those of cell::LidarRays, as many as the depths are.
   * \param[in] pose sensor -> world
   * \param[in] surfaces of the same frame
   */
  TrueView(const Eigen::Isometry3d& pose, const cell::SurfaceImage& surfaces);

  Eigen::Vector3d
  sensorPosition() const
  {
    return pose_.translation();
  }

  /** \brief Whether rays pass through a voxel's cube, one at least, and each of them
   * ends more than two voxel edges, along the ray, behind its exit from the cube. A ray
   * that hits nothing does not end. */
  bool
  seesThrough(const io::VoxelGrid& grid, std::uint64_t key) const;

private:
  /** \brief Rows and columns of pixels, the last ones included; columns may exceed
   * those of the image, which is a circle then. */
  struct Pixels {
    long first_row = 0;
    long last_row = -1;
    long first_column = 0;
    long last_column = -1;
  };

  Pixels
  cameraPixels(const Eigen::Vector3d& centre, double edge) const;

  Pixels
  lidarPixels(const Eigen::Vector3d& centre, double edge) const;

  Eigen::Isometry3d pose_;
  Eigen::Isometry3d world_to_sensor_;
  bool is_lidar_;
  std::vector<float> depths_;
};

} // namespace noise
} // namespace pcl_ext
