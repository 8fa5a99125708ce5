// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Checks of decoded clouds, independent of the library: a naive voxelization,
 * and the nearest neighbour of each point.
 */
#pragma once

#include "measuring/workload.h"

#include <array>
#include <cstddef>

namespace pcl_ext {
namespace measuring {

/** \brief Voxel (i, j, k) covers [origin + i d_v, origin + (i + 1) d_v) x ... */
struct Lattice {
  std::array<double, 3> origin{}; ///< metres
  double resolution = 0.0;        ///< metres
};

/** \brief Whether a voxel may be decoded more than once. */
enum class Repeats { Forbidden, Allowed };

/** \brief Checks that the decoded points are the voxels that hold points.
 * \param[in] points what was encoded
 * \param[in] decoded centres of voxels
 * \param[in] lattice whose voxels they are
 * \param[in] face_tolerance voxels; a point this close to a face may be in either voxel
 * \param[in] repeats forbidden where decoded points are voxels
 * \throws std::runtime_error if they are not
 */
void
checkVoxels(const PositionCloud& points,
            const PositionCloud& decoded,
            const Lattice& lattice,
            double face_tolerance,
            Repeats repeats = Repeats::Forbidden);

/** \brief Checks exactly that each voxel has as many decoded points as points, which are
 * then at most half an edge from one of them in each coordinate.
 * \param[in] points what was encoded
 * \param[in] decoded centres of voxels, one for each point
 * \param[in] lattice whose voxels they are
 * \throws std::runtime_error if it has not
 */
void
checkPoints(const PositionCloud& points,
            const PositionCloud& decoded,
            const Lattice& lattice);

/** \brief Checks that each coordinate is at most half an edge from that of the same
 * point, but for the rounding of floats.
 * \param[in] points what was encoded
 * \param[in] decoded in the same order
 * \param[in] edge metres
 * \throws std::runtime_error if one is further
 */
void
checkPointsInOrder(const PositionCloud& points,
                   const PositionCloud& decoded,
                   double edge);

/** \brief Checks exactly that each decoded voxel has the sum of its points'
 * intensities.
 * \param[in] points what was encoded
 * \param[in] decoded centres of voxels; all of them, see checkVoxels
 * \param[in] lattice whose voxels they are
 * \param[in] top larger sums are clamped to it
 * \param[in] tolerance largest error allowed
 * \throws std::runtime_error if an error is larger
 */
void
checkIntensities(const IntensityCloud& points,
                 const IntensityCloud& decoded,
                 const Lattice& lattice,
                 double top,
                 double tolerance);

/** \brief Distances from each point of one cloud to the nearest of another. */
struct NearestDistances {
  std::size_t points = 0;
  double sum_of_squares = 0.0; ///< square metres
  double largest = 0.0;        ///< metres
  /** \brief Largest difference of a coordinate from the point that is nearest in it,
   * metres. */
  double largest_of_axis = 0.0;

  NearestDistances&
  operator+=(const NearestDistances& other);

  /** \brief Root mean square, metres. */
  double
  rms() const;
};

/** \brief Searches with pcl::KdTreeFLANN. Neither cloud is empty. */
NearestDistances
nearestDistances(const PositionCloud::ConstPtr& from,
                 const PositionCloud::ConstPtr& to);

} // namespace measuring
} // namespace pcl_ext
