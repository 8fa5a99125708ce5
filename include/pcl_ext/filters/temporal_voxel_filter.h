#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief Outcomes of a TemporalVoxelFilter. Except for Ok the frame is unchanged, and
 * not part of the history. */
enum class TemporalFilterCode {
  Ok,
  InvalidSettings, ///< the number of frames is outside its range
  HasPointCounts   ///< the frame has numbers of points, which belong to one cloud
};

/** \brief Outcome of filtering a frame. */
struct TemporalFilterStatus : Status<TemporalFilterCode> {
  using Status<TemporalFilterCode>::Status;

  std::size_t hidden = 0; ///< voxels of the frame that are not shown
  std::size_t held = 0;   ///< shown voxels that the frame does not have
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
 * - A voxel is shown if it was occupied in more than half of the last frames, or at
 *   once if its neighbours are occupied, too, and none of them is shown. It is hidden
 *   if it was occupied in less than a quarter of them, or is empty for more frames than
 *   five eighths of `frames`.
 * - From the position of the sensor follows what a shown voxel that is empty hides: if
 *   the sensor sees through it, it is hidden at once.
 * - The intensity and the colour of a shown voxel are held while their running mean is
 *   within the noise of the shown value, and follow at once where the value jumps. The
 *   noise is learned from the stream, so that counts, shares and intensities of a
 *   sensor's own need no setting.
 *
 * One instance serves one stream: frames of one sensor in their order. The history is
 * kept where the grid moves on its lattice, and dropped where resolution, origin,
 * intensity scale, depth model's law or colour bits change. Memory: about 60 bytes for
 * each voxel of the last frames, 100 with colours, and 1.6 MB for the directions of the
 * sensor. The same voxels on all machines: arithmetic of integers, but for single
 * divisions. If memory runs out std::bad_alloc is thrown and the history is dropped.
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
   */
  explicit TemporalVoxelFilter(unsigned int frames = usual_frames);
  ~TemporalVoxelFilter();
  TemporalVoxelFilter(TemporalVoxelFilter&&) noexcept;
  TemporalVoxelFilter&
  operator=(TemporalVoxelFilter&&) noexcept;

  /** \brief Filters the stream's next frame.
   * \param[in,out] frame as isConsistent() demands; has the shown voxels then
   * \param[in] sensor_position of the sensor, metres, in the coordinates of the grid.
   * None, or a position that most voxels cannot be seen from, as another one hides
   * them: what is empty is hidden by the number of frames alone
   */
  [[nodiscard]] TemporalFilterStatus
  filter(io::VoxelFrame& frame,
         const std::optional<std::array<double, 3>>& sensor_position = std::nullopt);

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

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
