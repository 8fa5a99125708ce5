#pragma once

#include <pcl_ext/compression/symbol_intensities.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <array>
#include <cstddef>

namespace pcl_ext {
namespace io {

/** \brief Some voxels of a frame as points. */
struct VoxelCentres {
  static constexpr std::size_t most = 64;

  std::array<float, most> x; ///< of the voxels' centres, metres
  std::array<float, most> y;
  std::array<float, most> z;
  std::array<float, most> intensity; ///< in the unit of the frame's scale
};

/** \brief Computes voxels as points: VoxelGrid::centre and IntensityScale::value for many
 * voxels at a time.
 * \param[in] frame as isConsistent() asks
 * \param[in,out] symbol_intensities memory for what is computed once for each scale, of any
 * frames before; one for each thread
 * \param[in] begin the first voxel, at most frame.size()
 * \param[out] centres the voxels from there
 * \return how many there are: VoxelCentres::most, or what the frame has left
 */
PCL_EXT_EXPORT std::size_t
voxelCentres(const VoxelFrame& frame,
             SymbolIntensities& symbol_intensities,
             std::size_t begin,
             VoxelCentres& centres);

/** \brief What to add to a centre's coordinates, metres, to find its voxel in another grid.
 * Centres of one grid may lie on faces of the other, as where voxels have twice the size;
 * such a centre belongs to the voxel above, but as a float it may be just below.
 * \param[in] resolution voxel edge of the other grid, metres
 */
constexpr float
faceMargin(double resolution)
{
  return static_cast<float>(resolution / 1024.0);
}

} // namespace io
} // namespace pcl_ext
