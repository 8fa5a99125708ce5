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
#include <utility>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief One stream of a CentralNode: the frames that wait, its decoder, its last voxels
 * and its health.
 *
 * A stream that frames wait of has one turn at a time, in which somebody calls decodeNext()
 * and then endTurn(). These are for one thread at a time; everything else is for any number
 * of threads.
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

  /** \brief Takes a frame that arrived, or refuses it, and counts it.
   * \param[in] bytes the frame
   * \param[in] stamp when it was taken; none: what it carries
   * \param[in] max_waiting frames that may wait
   * \param[in] ask_for_turn called if the stream needs a turn and has none; may throw
   * \return false if too many wait; the frame is then not decoded
   */
  template <typename AskT>
  bool
  admit(std::vector<std::uint8_t> bytes,
        std::optional<Time> stamp,
        std::size_t max_waiting,
        const AskT& ask_for_turn)
  {
    // Locked until the turn is asked for: a frame behind this one relies on it.
    const std::lock_guard<std::mutex> lock(mutex_);
    ++health_.frames_received;
    health_.bytes += bytes.size();
    if (waiting_.size() >= max_waiting) {
      ++health_.frames_refused;
      ++refused_behind_;
      return false;
    }
    waiting_.push_back({std::move(bytes), stamp, std::exchange(refused_behind_, 0)});
    if (!has_turn_)
      ask_for_turn();
    has_turn_ = true;
    return true;
  }

  /** \brief Decodes and denoises the frame that has waited longest; there must be one.
   * \param[in] clock tells the time
   * \param[in] listener told of the frame; may be empty
   */
  void
  decodeNext(const Clock& clock, const FrameListener& listener);

  /** \brief Ends the stream's turn.
   * \return true if a frame waits: the turn is not over, or another one is to begin
   */
  bool
  endTurn();

  /** \brief Copies the last voxels, if they were decoded between two moments. A clock that
   * was set back leaves voxels of its future.
   * \return nothing if they were not; `voxels` is untouched then
   */
  std::optional<LatestFrame>
  latestVoxels(Time oldest, Time newest, io::VoxelFrame& voxels) const;

  StreamHealth
  health(Time now) const;

private:
  struct WaitingFrame {
    std::vector<std::uint8_t> bytes;
    std::optional<Time> stamp; ///< none: what it carries
    /** \brief Frames that were refused since the one before it. They are missing behind
     * that one, which is decoded later than they were refused. */
    std::size_t refused_before;
  };

  WaitingFrame
  takeNext();

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

  // Of decodeNext() alone.
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
  std::deque<WaitingFrame> waiting_; // the next one is the first
  bool has_turn_ = false;
  std::size_t refused_behind_ = 0;           // since the last frame that was taken
  std::optional<std::uint32_t> last_number_; // of the last decoded frame
  std::size_t unnumbered_ = 0; // sender's frames since then that failed or were refused
};

} // namespace nodes
} // namespace pcl_ext
