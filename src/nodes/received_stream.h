#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/stream_health.h>

#include "rate_window.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief One stream of a CentralNode: its decoder, its last voxels and its health.
 *
 * decode() is for one thread at a time; everything else for any number of threads.
 */
class ReceivedStream {
public:
  ReceivedStream(const std::string& name,
                 float min_intensity,
                 const io::DecoderLimits& limits);

  void
  setMinIntensity(float min_intensity)
  {
    min_intensity_ = min_intensity;
  }

  /** \brief Has a new filter take the place of that in use, from the next frame on.
   * \param[in] settings as checkSettings() accepts; none: no filter
   */
  void
  setOutlierRemoval(const std::optional<VoxelOutlierRemovalSettings>& settings);

  /** \brief Counts a frame that arrived.
   * \param[in] bytes its size
   * \param[in] max_waiting frames that may wait
   * \return false if too many wait; the frame is then not to be decoded
   */
  bool
  admit(std::size_t bytes, std::size_t max_waiting);

  /** \brief Decodes and denoises a frame that was admitted.
   * \param[in] bytes the frame
   * \param[in] stamp when it was taken; none: what it carries
   * \param[in] clock tells the time
   * \param[in] listener told of the frame; may be empty
   */
  void
  decode(const std::vector<std::uint8_t>& bytes,
         std::optional<Time> stamp,
         const Clock& clock,
         const FrameListener& listener);

  /** \brief Copies the last voxels, if they were decoded between two moments. A clock that
   * was set back leaves voxels of its future.
   * \return nothing if they were not; `voxels` is untouched then
   */
  std::optional<LatestFrame>
  latestVoxels(Time oldest, Time newest, io::VoxelFrame& voxels) const;

  StreamHealth
  health(Time now) const;

private:
  /** \brief Removes the outliers of a frame that was decoded, if that is wanted.
   * \return number of voxels removed
   */
  std::size_t
  removeOutliers(io::VoxelFrame& frame);

  bool
  wantsIFrame(io::CompressionCode code);

  void
  countDecoded(std::uint32_t frame_number);

  void
  countFailed(const io::CompressionStatus& status);

  // Of decode() alone.
  io::FrameDecoder decoder_;
  std::optional<VoxelOutlierRemoval> outlier_removal_;
  io::VoxelFrame kept_;               // its memory and that of latest_ take turns
  std::size_t failures_in_a_row_ = 0; // of frames that need an I-frame behind them

  std::atomic<float> min_intensity_;

  mutable std::mutex mutex_; // of everything below
  // Of the filter that is to come; the filter itself is made where it is used.
  std::optional<VoxelOutlierRemovalSettings> outlier_settings_;
  bool are_outlier_settings_new_ = false;
  io::VoxelFrame latest_;
  Time latest_stamp_{0};
  StreamHealth health_;
  RateWindow window_;
  // Of each frame that waits: how many were refused since the one before it. They are
  // missing behind that one, which is decoded later than they were refused.
  std::deque<std::size_t> refused_before_;
  std::size_t refused_behind_ = 0;           // since the last frame that waits
  std::optional<std::uint32_t> last_number_; // of the last decoded frame
  std::size_t unnumbered_ = 0; // sender's frames since then that failed or were refused
};

} // namespace nodes
} // namespace pcl_ext
