// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief From which voxel edge on surfaces have no holes.
 */
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstddef>
#include <vector>

namespace pcl_ext::tools {

using Points = pcl::PointCloud<pcl::PointXYZI>;

/** \brief Edges 1, 2, 3, 5, 10 ... millimetres, up to a kilometre, and between two of
 * them a further one: 1.5, 2.5, 4, 7, 15 ... */
std::vector<double>
roundEdges();

/** \brief How many voxels of an edge, metres, have points in them.
 * \param[in] points with finite coordinates
 */
std::size_t
occupiedVoxels(const Points& points, double edge);

/** \brief At which voxel edge surfaces close, for sampled points.
 *
 * A surface has a hole at a point where a voxel beside the point's one, along the
 * surface, is empty. At an edge a point is closed if for one of the axes, which stands
 * for the normal, all four neighbours across it are occupied: the voxels at one step
 * along another axis, or those next to these along the normal. It stays closed at
 * larger edges, where the end of a surface comes near. Points that close at no edge are
 * no sample of a surface, but of its border, of something thin, or noise.
 */
class SurfaceClosure {
public:
  /** \param[in] edges voxel edges, ascending, metres */
  explicit SurfaceClosure(const std::vector<double>& edges);

  /** \brief Adds some 4,000 of the points of a cloud, all finite; all if it has fewer. */
  void
  add(const Points& points);

  /** \brief Sampled points that close at an edge or at a smaller one.
   * \param[in] number of the edge, from 0
   */
  std::size_t
  closedAt(std::size_t number) const
  {
    return closed_[number];
  }

  /** \brief Share of the surfaces' points that close only at larger edges, 0 to 1; 1 if
   * there is no surface.
   * \param[in] last number of the edge at which the points of surfaces are closed
   */
  double
  holesAt(std::size_t number, std::size_t last) const;

private:
  std::vector<double> edges_;
  std::vector<std::size_t> closed_; ///< for each edge
};

} // namespace pcl_ext::tools
