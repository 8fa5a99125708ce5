#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief The voxels of a frame with regions in grids of their edges, so that each edge
 * is judged as a frame of voxels of that edge.
 *
 * The frame of some levels has the coarse voxels of these levels and, as what lies
 * around them, the voxels that finer ones are in.
 */
class LevelFrames {
public:
  /** \brief Makes the frames of all levels that there may be.
   * \param[in] frame with regions, as isConsistent() demands
   * \param[in] share_exponent by which shares of a face fall with the edge: 0 for other
   * intensities, of which those of finer voxels add up
   */
  void
  assign(const io::VoxelFrame& frame, unsigned int share_exponent);

  /** \brief One frame for each number of levels, from 0 on. */
  std::vector<io::VoxelFrame>&
  frames()
  {
    return frames_;
  }

  /** \brief The levels of a voxel of the assigned frame. */
  unsigned int
  levelsOf(std::size_t voxel) const
  {
    return levels_[voxel];
  }

  /** \brief Index of a voxel of the assigned frame in the frame of its levels. */
  std::size_t
  indexOf(std::size_t voxel) const
  {
    return indices_[voxel];
  }

  /** \brief Replaces the voxels of a frame by those of the frames that are in a region of
   * their levels.
   * \param[in,out] frame the assigned one
   */
  void
  unite(io::VoxelFrame& frame) const;

private:
  void
  assignLevel(const io::VoxelFrame& frame,
              unsigned int levels,
              unsigned int share_exponent);

  std::vector<io::VoxelFrame> frames_;
  std::vector<std::uint8_t> levels_; // of each voxel
  std::vector<std::size_t> indices_; // of each voxel
};

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
