// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>

#include "voxelizing/lattice.h"
#include "voxelizing/locate_points.h"
#include "voxelizing/located_points.h"
#include "voxels/grid_fit.h"

#include <array>
#include <cstddef>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Computes the voxels of the points of a cloud, and counts the points that
 * cannot be used. */
class VoxelLocator {
public:
  /** \param[in] settings as accepted by checkSettings; with a fixed box the grid is
   * that of the box, else it has to be set, and the whole lattice is usable
   */
  explicit VoxelLocator(const EncoderSettings& settings);

  /** \brief The grid. */
  const VoxelGrid&
  grid() const
  {
    return grid_;
  }

  /** \brief Sets the grid; not with a fixed box. */
  void
  setGrid(const VoxelGrid& grid);

  /** \brief Finds an origin with clearly more points on its lattice than with the
   * present one, or with all points if an I-frame is due; not with a fixed box.
   * \param[in] points the cloud
   * \param[in] is_i_frame_due moving the origin costs no I-frame
   * \param[out] origin a corner of a voxel of the world's origin amid the points
   * \return false if there is none
   */
  bool
  findBetterOrigin(PointBatches& points,
                   bool is_i_frame_due,
                   std::array<double, 3>& origin) const;

  /** \brief Lattice range of the usable points; not with a fixed box.
   * \return false if there are none
   */
  bool
  measureRange(PointBatches& points, LatticeRange& range) const;

  /** \brief Computes the voxels of the next LocatedPoints::capacity points of a batch.
   * \param[in] points the batch
   * \param[in] begin first point
   * \param[out] located the usable ones of these points
   * \param[in,out] statistics counts the others
   * \return false if a usable point is outside the grid
   */
  bool
  find(const PointView& points,
       std::size_t begin,
       LocatedPoints& located,
       VoxelizationStatistics& statistics) const;

private:
  void
  setLattice();

  std::size_t
  countPointsOnLattice(PointBatches& points) const;

  bool
  locate(const PointView& points,
         std::size_t begin,
         std::size_t end,
         LocatedPoints& located,
         CertainPoints& certain) const;

  template <typename NumberT>
  bool
  findVoxel(const NumberT* point,
            LatticeIndex& index,
            VoxelizationStatistics& statistics) const;

  bool
  findOne(const PointView& points,
          std::size_t point,
          LocatedPoints& located,
          VoxelizationStatistics& statistics) const;

  std::optional<BoundingBox> box_;
  bool has_pcl_grid_;
  VoxelGrid grid_;
  Lattice lattice_;
  LocatorGrid locator_grid_;
  LocatorGrid rounded_locator_grid_;  // for double coordinates
  std::array<float, 3> usable_min_{}; // lowest and highest coordinates on the lattice,
  std::array<float, 3> usable_max_{}; // metres; not used with a fixed box
};

} // namespace pcl_ext::PCL_EXT_ABI::io
