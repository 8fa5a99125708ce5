#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief A view of points: x, y, z as consecutive floats or doubles, metres, an intensity
 * and a colour. All may be in the same array or in several. */
struct PointView {
  const float* coordinates = nullptr; ///< x of the first point
  /** \brief x of the first point in double precision, for coordinates whose size costs
   * floats precision, as those of maps; null: `coordinates` are used. */
  const double* double_coordinates = nullptr;
  std::size_t coordinate_stride = 0;  ///< numbers from one x to the next
  const float* intensities = nullptr; ///< intensity of the first point; null: all are 1
  std::size_t intensity_stride = 0;   ///< floats from one intensity to the next
  std::size_t count = 0;              ///< number of points
  /** \brief Colour of the first point: 32 bits in the machine's order, red, green and
   * blue from bit 16, 8 and 0 on, as PCL's field rgba; null: no colours. */
  const void* colours = nullptr;
  std::size_t colour_stride = 0; ///< bytes from one colour to the next
  /** \brief Points of negative depth, whose intensity is therefore 0; for the statistics. */
  std::size_t count_behind_sensor = 0;
};

/** \brief The points of a cloud, some at a time: for points that are computed while they are
 * voxelized, so that the whole cloud is never in memory. */
class PCL_EXT_EXPORT PointBatches {
public:
  virtual ~PointBatches();

  /** \brief Number of points of all batches, at most. */
  virtual std::size_t
  size() const = 0;

  virtual bool
  hasIntensities() const = 0;

  virtual bool
  hasColours() const = 0;

  /** \brief Begins with the first points again: some clouds are read more than once, as
   * those that the grid has to be fitted to. */
  virtual void
  restart() = 0;

  /** \brief The next points, at the beginning and after restart() the first ones.
   * \param[out] points valid until the next call
   * \return false if there are none left
   */
  virtual bool
  next(PointView& points) = 0;

  /** \brief Splits the cloud for several threads.
   * \param[in] parts how many, at least 1
   * \return that many batches, which may be read at the same time and together have the
   * points in their order; valid until the next call of a member. Empty, as without an
   * override: the cloud is not split.
   */
  virtual std::vector<PointBatches*>
  split(std::size_t parts);
};

/** \brief Converts clouds to the occupied voxels of a grid, each with an intensity, the mean
 * colour of its points and their number, as the settings say.
 *
 * Voxel (i, j, k) covers [i d_v, (i+1) d_v) x ... from the origin of the grid, computed
 * in double precision from the coordinates. Points more than 2^20 voxels from the
 * origin, outside the fixed box, or not finite are counted and left out. Memory and time
 * are at most proportional to the number of points, for any coordinates.
 *
 * The origin is the world's, unless the settings have another one or clouds lie
 * further out: then it is a corner of a voxel of the world's origin amid the points.
 *
 * Without a fixed box the grid is fitted to the points. It grows if later points require
 * it and does not change otherwise, as a changed grid requires an I-frame. The scale of
 * native intensities is adapted in the same way.
 */
class PCL_EXT_EXPORT Voxelizer {
public:
  /** \brief A voxelizer for the clouds of one stream.
   * \param[in] settings as accepted by checkSettings; those of the grid, the box, the
   * aggregation, the coding of intensities, colours and points, the format, and the
   * number of threads are used
   * \param[in] unit unit of the point intensities
   */
  Voxelizer(const IntensityCompressionSettings& settings, IntensityUnit unit);
  ~Voxelizer();
  Voxelizer(Voxelizer&&) noexcept;
  Voxelizer&
  operator=(Voxelizer&&) noexcept;

  /** \brief Voxelizes one cloud.
   * \param[in] points the cloud
   * \param[in] may_refit ignore the previous clouds: a grid that is far too large and the
   * scale of native intensities are fitted again; requires an I-frame unless one is due
   * \param[out] frame the occupied voxels; its memory is reused
   * \return counts of the points
   */
  VoxelizationStatistics
  voxelize(const PointView& points, bool may_refit, VoxelFrame& frame);

  /** \brief The same for a cloud in batches. What their functions throw is passed on. */
  VoxelizationStatistics
  voxelize(PointBatches& points, bool may_refit, VoxelFrame& frame);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace io
} // namespace pcl_ext
