/** \file
 * \brief How well a receiver shows the surfaces of the robot cell, with voxels of any edge.
 */
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "simulator/robot_cell.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace rate {

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

/** \brief The true surfaces of a stream. */
class TrueSurfaces {
public:
  static constexpr int never = -1'000'000;

  explicit TrueSurfaces(double edge) : voxels(edge), last_frames(voxels.count(), never)
  {}

  /** \brief Adds a frame. */
  void
  add(const cell::CellFrame& frame);

  CellVoxels voxels;
  int frame = -1;
  std::vector<CellVoxels::Index> surfaces; ///< of the last frame
  std::vector<int> last_frames;            ///< in which a voxel was one, by number
};

/** \brief Percent of the true surfaces that are shown, and of what is shown that is none. */
struct ShownQuality {
  double surface_percent = 0.0;
  double noise_percent = 0.0;
};

/** \brief Judges a decoded frame, whose voxels have the finest edge or a multiple of two of
 * it, against the last frame of the truth.
 *
 * A surface's voxel is shown if a decoded voxel's centre is within one finest edge of its
 * own on each axis: also by the voxels of twice the edge around it, but by larger ones only
 * near their centres. A decoded voxel is noise if no surface was in it or within one finest
 * edge around it in the last ten frames. */
class QualityJudge {
public:
  /** \param[in] truth must outlive this */
  explicit QualityJudge(const TrueSurfaces& truth)
  : truth_(truth), is_shown_(truth.voxels.count(), 0)
  {}

  ShownQuality
  judge(const io::VoxelFrame& shown);

private:
  bool
  isNoise(const CellVoxels::Index& first, int edge) const;

  const TrueSurfaces& truth_;
  std::vector<std::uint8_t> is_shown_;
  std::vector<std::size_t> marked_;
};

} // namespace rate
} // namespace pcl_ext
