// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup filters
 * @{ */

/** \brief Outcomes of a TemporalVoxelFilter. Except for Ok the frame is unchanged, and
 * not part of the history. */
enum class TemporalFilterCode {
  Ok,
  InvalidSettings, ///< the number of frames is outside its range
  HasPointCounts ///< the frame has numbers of points or fields, which are of one cloud
};

/** \brief Outcome of filtering a frame. */
struct TemporalFilterStatus : Status<TemporalFilterCode> {
  using Status<TemporalFilterCode>::Status;

  std::size_t hidden = 0; ///< voxels of the frame that are not shown
  std::size_t held = 0;   ///< shown voxels that the frame does not have
  /** \brief If it is Moving, all voxels of the frame are shown, and no others. */
  io::SensorMotion sensor_motion = io::SensorMotion::Unknown;
};

/** \brief From where and when a sensor saw a frame. */
struct SensorView {
  /** \brief Of the sensor, metres, in the coordinates of the grid. */
  std::optional<std::array<double, 3>> position;
  /** \brief Of the cloud, by any clock. */
  std::optional<std::chrono::nanoseconds> time;
};

/** \brief Tells the voxels of surfaces from noise over time: what a still scene shows
 * does not change from frame to frame.
 *
 * A surface near a face between two voxels is seen now in the one and now in the other,
 * a flying pixel here and there, and each count varies as its square root. The filter
 * keeps the voxels of the last frames, and shows those that are likely surfaces, in
 * place of those that the sensor happened to hit. It is lossy: see
 * doc/temporal_filter.md for the rules, figures, and when not to use it.
 *
 * - A voxel is shown at once if as many of its neighbours are occupied as a surface
 *   has at this distance, and none of them is shown; else when it is occupied in most
 *   frames. It is hidden when it is empty in most, or for 5/8 of `frames`; far away,
 *   where a frame does not hit all voxels of a surface, for `frames`. Where a frame has
 *   nothing within one voxel of it, time counts, not frames: 5/8 of `frames` twentieths
 *   of a second.
 * - From the position of the sensor follows whether it sees through an empty voxel that
 *   is shown: then the voxel is hidden as soon as that was so for 1/15 second.
 * - A sensor that moves is recognised by its positions, or by what comes and goes; its
 *   frames stay as they are.
 * - The intensity and the colour of a shown voxel are held while their running mean is
 *   within the noise of the shown value, and follow at once where the value jumps. The
 *   noise is learned from the stream, so that counts, shares and a sensor's own
 *   intensities need no setting.
 *
 * One instance serves one stream: frames of one sensor in their order. The history
 * follows a grid that moves on its lattice, less what is outside of it, and a scale of
 * intensities, whose values are then learned anew. It is dropped where resolution,
 * origin or colour bits change, where a depth model begins or ends, and before a frame
 * that has less than an eighth of the voxels that were shown. It has at most eight
 * voxels for each voxel of the frame, and 65,536. Memory: some 90 bytes for each,
 * 200 with colours, up to four times as much where they are far apart, and up to 3.2 MB
 * for the directions of the sensor; much that is not needed any more is released. The
 * voxels are the same on all machines. If memory runs out std::bad_alloc is thrown and
 * the history is dropped.
 *
 * Instances are independent; calls of one instance must not overlap. A moved-from
 * instance may only be assigned to or destroyed.
 */
class PCL_EXT_CODEC_EXPORT TemporalVoxelFilter {
public:
  /** \brief Range of the number of frames. */
  static constexpr unsigned int least_frames = 2;
  static constexpr unsigned int most_frames = 64;

  /** \brief A number of frames for sensors of 10 to 30 frames a second. */
  static constexpr unsigned int usual_frames = 8;

  /** \brief A filter at the start of a stream.
   * \param[in] frames strength: how many frames a voxel's occupancy is averaged over,
   * least_frames to most_frames. More frames remove more noise, and a voxel that not
   * enough neighbours confirm is shown later
   * \param[in] holds whether a shown voxel may stay for a while where the frame has
   * nothing within one voxel of it
   */
  explicit TemporalVoxelFilter(unsigned int frames = usual_frames, bool holds = true);
  ~TemporalVoxelFilter();
  TemporalVoxelFilter(TemporalVoxelFilter&&) noexcept;
  TemporalVoxelFilter&
  operator=(TemporalVoxelFilter&&) noexcept;

  /** \brief Tells where rays end that the next frame has no points of, as these are
   * outside of a crop box: what such a ray passes is empty.
   * \param[in] points of the cloud before it is cropped, metres, in the coordinates of
   * the grid
   * \param[in] box in which the frame has its points
   * \param[in] position of the sensor, finite, as the next call of filter() gets it
   */
  void
  seeBeyond(io::PointBatches& points,
            const io::BoundingBox& box,
            const std::array<double, 3>& position);

  /** \brief Filters the stream's next frame.
   * \param[in,out] frame as isConsistent() demands; has the shown voxels then
   * \param[in] view from where and when it was seen. Without a position, or with one
   * from which more than a quarter of the voxels are behind others, what is empty is
   * hidden by the time alone. Without a time, or with one that is not later than the
   * last, a frame counts as long after the last one as the one before it, at first as
   * at 20 frames a second
   */
  [[nodiscard]] TemporalFilterStatus
  filter(io::VoxelFrame& frame, const SensorView& view = {});

  /** \brief Drops the history, as at the start of a stream. */
  void
  reset();

  /** \brief Number of voxels in the history. */
  std::size_t
  rememberedVoxels() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI
