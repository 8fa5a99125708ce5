#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <cstddef>
#include <memory>

namespace pcl_ext {
namespace io {

/** \brief Points in somebody else's memory: x, y, z as consecutive floats, metres, and
 * an intensity. Points and intensities may lie in one structure or in two. */
struct PointView {
  const float* coordinates = nullptr; ///< x of the first point
  std::size_t coordinate_stride = 0;  ///< floats from one x to the next
  const float* intensities = nullptr; ///< intensity of the first point; null: all are 1
  std::size_t intensity_stride = 0;   ///< floats from one intensity to the next
  std::size_t count = 0;              ///< number of points
};

/** \brief Turns points into the voxels of a grid, each with one intensity.
 *
 * Voxel (i, j, k) covers [i d_v, (i+1) d_v) x ... from the anchor of the grid, computed
 * in double precision from the float coordinates. Points beyond 2^20 voxels of the
 * anchor, outside the fixed box, or not finite are counted and left out; no input makes
 * memory grow by more than the points it holds.
 *
 * Without a fixed box the grid is fitted to the points and grows when later points
 * demand it; it stays as it is otherwise, because a changed grid costs an I-frame. The
 * scale of native intensities follows the values in the same way.
 */
class PCL_EXT_EXPORT Voxelizer {
public:
  /** \brief A voxelizer for the clouds of one stream.
   * \param[in] settings as accepted by checkSettings; those of the grid, the box, the
   * aggregation, the intensity coding and the format are used
   * \param[in] unit unit of the point intensities
   */
  Voxelizer(const IntensityCompressionSettings& settings, IntensityUnit unit);
  ~Voxelizer();
  Voxelizer(Voxelizer&&) noexcept;
  Voxelizer&
  operator=(Voxelizer&&) noexcept;

  /** \brief Voxelizes one cloud.
   * \param[in] points the cloud
   * \param[in] may_refit forget the clouds before this one: fit a grid that is far too
   * large again, and the scale of native intensities; costs an I-frame unless one is due
   * \param[out] frame the occupied voxels; its memory is reused
   * \return what became of the points
   */
  VoxelizationStatistics
  voxelize(const PointView& points, bool may_refit, VoxelFrame& frame);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace io
} // namespace pcl_ext
