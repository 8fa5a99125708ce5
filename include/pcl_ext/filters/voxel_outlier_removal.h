// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/impl/named_value.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/status.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup filters
 * @{ */

/** \brief Removes voxels of low intensity as noise (section 2.7 of the paper), as a
 * PassThrough on `intensity` does with decoded clouds.
 * \param[in,out] frame as isConsistent() demands; the voxels that stay keep their order.
 * One that has its points only gets voxels, where any may be removed; points outside its
 * grid are left out then, see FramePoints::outside_grid
 * \param[in] min_intensity voxels below it are removed, in the unit of the frame's
 * intensities
 * \return number of voxels removed
 */
PCL_EXT_CODEC_EXPORT std::size_t
removeVoxelsBelow(io::VoxelFrame& frame, float min_intensity);

/** \brief The names of what a VoxelOutlierRemoval derives the densities of a stream's
 * voxels from: AutomaticUnit, FacesUnit, PointsUnit, VoxelsUnit and RaysUnit. */
enum class DensityUnit { Automatic, Faces, Points, Voxels, Rays };

inline constexpr std::array<NamedValue<DensityUnit>, 5> density_units = {
    {{DensityUnit::Automatic, "automatic"},
     {DensityUnit::Faces, "faces"},
     {DensityUnit::Points, "points"},
     {DensityUnit::Voxels, "voxels"},
     {DensityUnit::Rays, "rays"}}};

/** \brief The unit for intensities of a law: Faces for the quadratic one, Points for
 * counts of depth cameras, Voxels for native ones and where there are none, and
 * Automatic for the linear one, which needs a depth model for Faces. Lidars need Rays
 * or Voxels whatever their law. */
PCL_EXT_CODEC_EXPORT DensityUnit
densityUnitOf(IntensityLaw law);

/** \brief What all units but Rays have. */
struct UnitWithHistory {
  /** \brief Also use the voxels of previous frames. Off: each frame is filtered
   * independently; the last depth model or sensor is remembered in any case. */
  bool use_history = true;
};

/** \brief Faces from the first frame with a depth model on; else Rays from the first
 * frame on whose points tell their lidar (FramePoints::sensor); else Voxels,
 * as other frames do not say whether their intensities are counts, nor whether their
 * sensor is a lidar: name Points for counts of depth cameras, Rays for lidars. Frames
 * of the published layout have no depth model: name Faces for their quadratic law. */
struct AutomaticUnit : UnitWithHistory {
  /** \brief As that of RaysUnit, where it chooses Rays. */
  bool intensities_are_counts = false;

  friend bool
  operator==(const AutomaticUnit& a, const AutomaticUnit& b)
  {
    return a.use_history == b.use_history &&
           a.intensities_are_counts == b.intensities_are_counts;
  }
};

/** \brief Shares of a voxel face: the quadratic law, or the linear one in streams
 * with depth models. The most selective. */
struct FacesUnit : UnitWithHistory {
  /** \brief Intensity of a completely covered voxel face, above 0 and finite: 255 in
   * decoded frames of the quadratic and linear laws. Used until a frame has a depth
   * model. */
  float full_intensity = 255.0f;

  friend bool
  operator==(const FacesUnit& a, const FacesUnit& b)
  {
    return a.use_history == b.use_history && a.full_intensity == b.full_intensity;
  }
};

/** \brief Numbers of points, those of the frame or else its intensities, compared
 * with those of the voxels around, as the number that a surface has at that depth is
 * unknown. For counts of depth cameras, and for the linear law without a depth
 * model. */
struct PointsUnit : UnitWithHistory {
  friend bool
  operator==(const PointsUnit& a, const PointsUnit& b)
  {
    return a.use_history == b.use_history;
  }
};

/** \brief Every voxel counts the same, and voxels that were seldom occupied are
 * suspect. For native intensities, which do not depend on the density, for frames
 * without intensities, and for mixed echoes of a lidar that stands still. */
struct VoxelsUnit : UnitWithHistory {
  friend bool
  operator==(const VoxelsUnit& a, const VoxelsUnit& b)
  {
    return a.use_history == b.use_history;
  }
};

/** \brief Numbers of points, compared with those that a surface would have at that
 * distance from a lidar, whose position and steps between rays are known. For snow
 * and what else floats alone, of moving lidars, too; without history. */
struct RaysUnit {
  static constexpr bool use_history = false; ///< so that a lidar may move

  /** \brief Position of the lidar in world coordinates, metres, finite; none: the
   * origin. Used, as the steps are, until the points of a frame tell their lidar
   * (FramePoints::sensor), which has several columns and rows: then its position and
   * steps are used, and those of the last such frame. */
  std::optional<std::array<double, 3>> sensor_position;

  /** \brief Angles from a ray of the lidar to the next one, along a turn and from row to
   * row, radians, 0.0001 to 1: 0.2 and 0.4 degrees. Need be right to 30 % only;
   * where rows are not equally far apart, the median. */
  double azimuth_step = 0.0035;
  double elevation_step = 0.007;

  /** \brief Whether intensities are numbers of points, as those of the law count. Used
   * in frames without point_counts; else every voxel is one point, which tells less of
   * voxels of 20 cm. */
  bool intensities_are_counts = false;

  friend bool
  operator==(const RaysUnit& a, const RaysUnit& b)
  {
    return a.sensor_position == b.sensor_position && a.azimuth_step == b.azimuth_step &&
           a.elevation_step == b.elevation_step &&
           a.intensities_are_counts == b.intensities_are_counts;
  }
};

/** \brief A unit with its settings; in the order of DensityUnit. */
using DensityUnitSettings =
    std::variant<AutomaticUnit, FacesUnit, PointsUnit, VoxelsUnit, RaysUnit>;

/** \brief The name of a unit. */
inline DensityUnit
densityUnitOf(const DensityUnitSettings& settings)
{
  return static_cast<DensityUnit>(settings.index());
}

/** \brief The default settings of a unit, but for what it has in common with those of
 * Automatic. */
PCL_EXT_CODEC_EXPORT DensityUnitSettings
densityUnitSettings(DensityUnit unit, const AutomaticUnit& automatic = AutomaticUnit());

/** \brief All settings of a VoxelOutlierRemoval, with their units, defaults and
 * ranges. */
struct VoxelOutlierRemovalSettings {
  /** \brief What voxels are judged by, with the settings of that:
   * `VoxelOutlierRemoval removal({PointsUnit()})`. */
  DensityUnitSettings unit;

  /** \brief Voxels of lower log-odds are noise. Natural logarithm, finite; voxels have
   * about -12 to 12 at 4 cm.
   *
   * 0 removes most of the noise of depth cameras and about 1 % of the surfaces' voxels;
   * 2.5 more of both. Do not use such a high value where people are. With Rays 0 removes
   * 89 % of simulated snow in voxels of 10 cm, and 0.15 % of the surfaces'. For the
   * shares of noise, surfaces and people that it removes see doc/outlier_removal.md.
   */
  float min_log_odds = 0.0f;

  /** \brief Most blocks of 4 x 4 x 4 voxels to keep between two frames, about 270 bytes
   * each; any number. If there are more, only those of the last frame are kept; if that
   * frame alone has more, all are dropped, and their memory is released. While a frame
   * is filtered, its own blocks take as much in any case: up to 400 bytes per voxel if
   * the voxels are far apart, 660 below min_judged_edge. */
  std::size_t max_blocks = std::size_t{1} << 17;

  friend bool
  operator==(const VoxelOutlierRemovalSettings& a, const VoxelOutlierRemovalSettings& b)
  {
    return a.unit == b.unit && a.min_log_odds == b.min_log_odds &&
           a.max_blocks == b.max_blocks;
  }
};

/** \brief Outcomes of a VoxelOutlierRemoval or a PointOutlierRemoval. Except for Ok
 * nothing was judged and nothing removed. */
enum class OutlierRemovalCode {
  Ok,                    ///< voxels were judged; a message tells if without intensities
  InvalidSettings,       ///< a setting is outside its range
  UnsupportedResolution, ///< the voxel edge is outside the supported range
  NoDensities,           ///< the frame has no intensities, which the unit needs
  DifferentCloud,        ///< the cloud has another number of points than the frame
  InvalidCloud,          ///< fields or sizes of the cloud are invalid
  NoImage                ///< the cloud has no rows, which points are judged by
};

/** \brief Outcome of filtering a frame or a cloud. */
struct OutlierRemovalStatus : Status<OutlierRemovalCode> {
  using Status<OutlierRemovalCode>::Status;

  std::size_t removed = 0; ///< voxels of the frame, or points of the cloud
};

/** \brief Checks the settings against their ranges.
 * \return Ok, or InvalidSettings with the field and its value
 */
PCL_EXT_CODEC_EXPORT OutlierRemovalStatus
checkSettings(const VoxelOutlierRemovalSettings& settings);

/** \brief Removes noise from the voxels of one stream by their neighbourhood in this
 * and previous frames: StatisticalOutlierRemoval and RadiusOutlierRemoval for voxels.
 *
 * For depth cameras and, with the units Rays and Voxels, lidars. Each frame has a status,
 * as what cannot be judged stays.
 *
 * The voxels of a surface have neighbours of the same surface, each about as dense as
 * its face is covered; a flying pixel has few neighbours, with a point or two each. The
 * log-odds of surface against noise follow from the densities around a voxel in three
 * shells, with Rays from the points in it and around it, see doc/outlier_removal.md.
 * Voxels finer than min_judged_edge are judged by the coarse voxels that contain them.
 *
 * One instance serves one stream: frames of one sensor in their order, or those of
 * CentralNode::merge(). The history is kept while the grid moves on its lattice, by up
 * to two million voxels along each axis. All of it, the depth model included, is
 * dropped where the grid moves farther or the resolution or the origin changes; that of
 * densities where the unit changes. Time and memory are proportional to the number of
 * voxels, wherever they are; memory of a large frame is released a few frames later. If
 * memory runs out std::bad_alloc is thrown and the next frame is filtered without a
 * history.
 *
 * Instances are independent; calls of one instance must not overlap. A moved-from
 * instance may only be assigned to or destroyed.
 */
class PCL_EXT_CODEC_EXPORT VoxelOutlierRemoval {
public:
  /** \brief Point density from which a surface counts as covered, if there can be as
   * many points at its depth; 9 on a face of 4 cm. */
  static constexpr double sure_points_per_square_metre = 5625.0;

  /** \brief Supported voxel edges, metres; others were not tested. */
  static constexpr double min_resolution = 0.001;
  static constexpr double max_resolution = 0.2;

  /** \brief Finer voxels are judged by coarse voxels, metres. At 2 cm one pixel of a
   * Kinect V2 covers a voxel's face at a depth of 7 m. */
  static constexpr double min_judged_edge = 0.02;

  /** \brief True if a voxel edge, metres, is supported. */
  static bool
  isMadeFor(double resolution);

  explicit VoxelOutlierRemoval(
      const VoxelOutlierRemovalSettings& settings = VoxelOutlierRemovalSettings());
  ~VoxelOutlierRemoval();
  VoxelOutlierRemoval(VoxelOutlierRemoval&&) noexcept;
  VoxelOutlierRemoval&
  operator=(VoxelOutlierRemoval&&) noexcept;

  /** \brief Filters the stream's next frame.
   * \param[in,out] frame as isConsistent() demands; the voxels that stay keep their
   * order. One that has its points only gets voxels; points outside its grid are left
   * out then
   * \return Ok with the number of voxels removed, and a warning if points are left out;
   * or why none was judged: the frame is then unchanged, and not part of the history
   */
  [[nodiscard]] OutlierRemovalStatus
  filter(io::VoxelFrame& frame);

  /** \brief Computes the log-odds of the voxels of the stream's next frame; to be
   * called in place of filter().
   * \param[in] frame as isConsistent() demands
   * \param[out] log_odds natural logarithm of the odds of surface against noise, for
   * each voxel; plus infinity where none is judged
   * \return as filter(), with no voxel removed
   */
  OutlierRemovalStatus
  score(const io::VoxelFrame& frame, std::vector<float>& log_odds);

  /** \brief Moves the lidar: sets the sensor_position of RaysUnit for the next frames;
   * without effect on other units.
   * \param[in] position in world coordinates, metres; if it is not finite, frames get
   * InvalidSettings until it is
   */
  void
  setSensorPosition(const std::array<double, 3>& position);

  /** \brief Drops the history, as at the start of a stream. */
  void
  reset();

  /** \brief What the last frame was judged by, if the settings' unit is Automatic; that
   * of the settings, else and before the first frame. */
  DensityUnit
  unit() const;

  /** \brief Bytes of memory that it keeps for each voxel of a frame, an estimate that is
   * rather too high. */
  static constexpr std::size_t bytes_of_voxel = 400;

  /** \brief Number of blocks of 4 x 4 x 4 voxels in the history. */
  std::size_t
  rememberedBlocks() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** \brief Removes noise from a decoded cloud: VoxelOutlierRemoval::filter() for users
 * of io::OctreePointCloudIntensityCompression.
 *
 * The frame is filtered, not the cloud, as a cloud of voxel centres has neither a grid
 * nor an intensity law. Call it once for each decoded frame, in order:
 * \code
 * if (decoder.decodePointCloud(stream, cloud).ok()) {
 *   const auto status =
 *       pcl_ext::removeOutliers(*cloud, decoder.voxelFrame(), removal);
 *   if (!status.ok())
 *     std::cerr << status.message() << '\n';
 * }
 * \endcode
 * \tparam CloudT a pcl::PointCloud
 * \param[in,out] cloud as decodePointCloud() filled it; points may have been moved
 * since, and further fields be set. The points that stay keep their order. If any is
 * removed, a cloud of rows and columns keeps these, with x, y and z not a number in the
 * place of the point, and another one becomes one row; else it is not changed
 * \param[in] frame that the cloud was decoded from, as voxelFrame() returns it after
 * decodePointCloud()
 * \param[in,out] removal the filter of this stream
 * \return that of filter() with the number of points removed; DifferentCloud if the
 * cloud has another number of points than the frame: then the filter has not seen the
 * frame
 */
template <typename CloudT>
[[nodiscard]] OutlierRemovalStatus
removeOutliers(CloudT& cloud, const io::VoxelFrame& frame, VoxelOutlierRemoval& removal)
{
  if (cloud.size() != frame.cloudSize())
    return {OutlierRemovalCode::DifferentCloud,
            "no point was judged: the cloud has " + std::to_string(cloud.size()) +
                " points, and its frame " + std::to_string(frame.cloudSize())};
  io::VoxelFrame kept = frame;
  OutlierRemovalStatus status = removal.filter(kept);
  if (status.removed == 0)
    return status;
  std::vector<bool> is_removed(cloud.size());
  std::size_t next = 0;  // of the voxels that stay, which are in the frame's order
  std::size_t point = 0; // of the voxel
  status.removed = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const std::size_t end =
        point + (frame.has_point_counts ? frame.point_counts[i] : 1);
    const bool is_kept = next < kept.size() && frame.keys[i] == kept.keys[next];
    next += is_kept ? 1 : 0;
    status.removed += is_kept ? 0 : end - point;
    for (; point < end; ++point)
      is_removed[frame.cloudIndex(point)] = !is_kept;
  }
  if (frame.isOrganised()) {
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (auto& removed = cloud.points[i]; is_removed[i])
        removed.x = removed.y = removed.z = std::numeric_limits<float>::quiet_NaN();
    cloud.is_dense = false;
    return status;
  }
  std::size_t points_kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (!is_removed[i])
      cloud.points[points_kept++] = cloud.points[i];
  cloud.resize(points_kept);
  cloud.width = static_cast<std::uint32_t>(points_kept);
  cloud.height = 1;
  return status;
}

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI
