#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxelizer.h>

#include "voxelizing/block_place.h"
#include "voxelizing/lattice.h"
#include "voxelizing/quad_locator.h"
#include "voxels/grid_fit.h"

#include <array>
#include <cstddef>
#include <optional>

namespace pcl_ext {
namespace io {

/** \brief Finds out which points of a cloud can be used and where in the grid they are. */
class PlaceFinder {
public:
  /** \brief A finder that knows no grid yet.
   * \param[in] settings as accepted by checkSettings; with a fixed box the grid is the
   * one that belongs to it, else any part of the lattice can be used
   */
  explicit PlaceFinder(const IntensityCompressionSettings& settings);

  /** \brief The grid in which points are to be found. */
  const VoxelGrid&
  grid() const
  {
    return grid_;
  }

  /** \brief Sets the grid; not with a fixed box. */
  void
  setGrid(const VoxelGrid& grid);

  /** \brief The range of the points that can be used; not with a fixed box.
   * \return false if there are none
   */
  bool
  measureRange(const PointView& points, LatticeRange& range) const;

  /** \brief Finds the places of the next points of a cloud.
   * \param[in] points the cloud
   * \param[in] begin first point
   * \param[out] placed the points from there that can be used; PlacedPoints::capacity are
   * looked at
   * \param[in,out] statistics those that cannot be used are counted
   * \return false if a point could be used, but is outside the grid
   */
  bool
  find(const PointView& points,
       std::size_t begin,
       PlacedPoints& placed,
       VoxelizationStatistics& statistics) const;

private:
  bool
  isInBox(const float* point) const;

  bool
  findVoxel(const float* point, LatticeIndex& index) const;

  void
  countUnused(const float* point, VoxelizationStatistics& statistics) const;

  bool
  findOne(const PointView& points,
          std::size_t point,
          PlacedPoints& placed,
          VoxelizationStatistics& statistics) const;

  std::optional<BoundingBox> box_;
  bool has_pcl_grid_;
  VoxelGrid grid_;
  Lattice lattice_;
  QuadLocator<NativeLanes> locator_;
  std::array<float, 3> usable_min_{}; // lowest and highest coordinates within the
  std::array<float, 3> usable_max_{}; // lattice, metres; not used with a fixed box
};

} // namespace io
} // namespace pcl_ext
