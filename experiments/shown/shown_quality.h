// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief How well a receiver shows the surfaces of the robot cell, with voxels of any
 * edge.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "simulator/robot_cell.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace shown {

/** \brief Voxels of the finest edge in the cell's crop box. */
class CellVoxels {
public:
  using Index = std::array<int, 3>;

  explicit CellVoxels(double edge);

  double
  edge() const
  {
    return edge_;
  }

  /** \brief Its number, or that of a voxel which is none of the box. */
  std::size_t
  numberOf(const Index& index) const;

  std::size_t
  count() const
  {
    return count_ + 1;
  }

private:
  double edge_;
  Index first_{};
  Index size_{};
  std::size_t count_ = 0;
};

/** \brief A point that was measured at a surface. */
struct SurfacePoint {
  Eigen::Vector3d position; ///< world, metres
  bool is_person = false;
};

/** \brief The points of a frame of the robot cell that were measured at surfaces.
 * \param[in] is_person whether a point, by its number, is the person's
 */
template <typename FrameT, typename IsPersonT>
std::vector<SurfacePoint>
surfacePoints(const FrameT& frame, const IsPersonT& is_person)
{
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < frame.cloud.size(); ++i)
    if (frame.truth[i] == cell::PointTruth::Surface)
      points.push_back(
          {frame.pose * frame.cloud[i].getVector3fMap().template cast<double>(),
           is_person(i)});
  return points;
}

/** \brief Percent of the true surfaces that are shown, and of what is shown that is
 * none. */
struct ShownQuality {
  double surface_percent = 0.0;
  double noise_percent = 0.0;
  /** \brief Of the voxels with points of the person alone; none if there are fewer than
   * 20. */
  std::optional<double> person_percent;
};

/** \brief Judges decoded frames, whose voxels have the finest edge or a multiple of two
 * of it, against the true surfaces of a stream.
 *
 * A surface's voxel is shown if a decoded voxel's centre is within one finest edge of its
 * own on each axis: also by the voxels of twice the edge around it, but by larger ones
 * only near their centres. A decoded voxel is noise if no surface was in it or within
 * one finest edge around it in the last ten frames. */
class QualityJudge {
public:
  /** \param[in] edge the finest one, metres */
  explicit QualityJudge(double edge)
  : voxels_(edge), last_frames_(voxels_.count(), never), is_shown_(voxels_.count(), 0)
  {}

  /** \brief Adds the next frame of the truth. */
  void
  add(const std::vector<SurfacePoint>& points);

  /** \brief Judges what is shown against the last frame. */
  ShownQuality
  judge(const io::VoxelFrame& shown);

private:
  static constexpr int never = -1'000'000;

  /** \brief Adds the voxels of some of the points that are in none so far. */
  void
  addVoxels(const std::vector<SurfacePoint>& points, bool of_person);

  bool
  isNoise(const CellVoxels::Index& first, int edge) const;

  CellVoxels voxels_;
  int frame_ = -1;
  std::vector<CellVoxels::Index> surfaces_; // of the last frame, the person's last
  std::size_t others_ = 0;                  // how many are not the person's
  std::vector<int> last_frames_;            // in which a voxel was one, by number
  std::vector<std::uint8_t> is_shown_;
  std::vector<std::size_t> marked_;
};

} // namespace shown
} // namespace pcl_ext
