#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/stream_health.h>

#include "nodes/rate_window.h"
#include "voxels/memory_rule.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <new>
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

  /** \brief What became of a frame that arrived. */
  enum class Admission {
    Waits,
    TooManyWait, ///< refused
    OutOfMemory  ///< refused: there was no memory for it
  };

  /** \brief Takes a frame that arrived, or refuses it, and counts it.
   * \param[in] bytes the frame
   * \param[in] stamp when it was taken; none: what it carries
   * \param[in] max_waiting frames that may wait
   * \param[in] ask_for_turn called if the stream needs a turn and has none; a frame that it
   * has no memory for is refused
   */
  template <typename AskT>
  Admission
  admit(std::vector<std::uint8_t> bytes,
        std::optional<Time> stamp,
        std::size_t max_waiting,
        const AskT& ask_for_turn)
  {
    // Locked until the turn is asked for: a frame behind this one relies on it.
    const std::lock_guard<std::mutex> lock(mutex_);
    ++health_.frames_received;
    health_.bytes += bytes.size();
    Admission admission = Admission::TooManyWait;
    if (waiting_.size() < max_waiting)
      admission = queue({std::move(bytes), stamp, refused_behind_}, ask_for_turn);
    if (admission == Admission::Waits) {
      refused_behind_ = 0;
      return admission;
    }
    ++health_.frames_refused;
    ++refused_behind_;
    return admission;
  }

  /** \brief Decodes and denoises the frame that has waited longest; there must be one.
   * Whatever is thrown meanwhile becomes the status of the frame, which then shows nothing.
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

  /** \brief Has a frame wait, unless memory runs out; mutex_ is locked. */
  template <typename AskT>
  Admission
  queue(WaitingFrame frame, const AskT& ask_for_turn)
  {
    try {
      waiting_.push_back(std::move(frame));
    }
    catch (const std::bad_alloc&) {
      return Admission::OutOfMemory;
    }
    if (has_turn_)
      return Admission::Waits;
    try {
      ask_for_turn();
    }
    catch (const std::bad_alloc&) {
      waiting_.pop_back();
      return Admission::OutOfMemory;
    }
    has_turn_ = true;
    return Admission::Waits;
  }

  WaitingFrame
  takeNext();

  /** \brief Decodes a frame and shows it, or throws.
   * \param[out] is_decoded as soon as it is
   */
  io::CompressionStatus
  decode(const WaitingFrame& frame,
         std::chrono::steady_clock::time_point start,
         const Clock& clock,
         bool& is_decoded);

  /** \brief Denoises a frame that was decoded and makes it the latest one, or throws and
   * leaves the latest one as it is. */
  void
  show(io::VoxelFrame& decoded,
       const WaitingFrame& frame,
       std::chrono::steady_clock::time_point start,
       const Clock& clock);

  /** \brief Removes the outliers of a frame that was decoded, if that is wanted. A filter
   * that throws is replaced by a new one, as it may remember half a frame.
   * \return number of voxels removed
   */
  std::size_t
  removeOutliers(io::VoxelFrame& frame);

  void
  makeOutlierRemoval();

  bool
  wantsIFrame(io::CompressionCode code);

  /** \brief Takes note of a frame that was decoded, and of those lost before it. */
  void
  follow(std::uint32_t frame_number);

  /** \brief Counts a frame that came late or twice, of which none is missing.
   * \return whether an I-frame is wanted
   */
  bool
  countDropped();

  /** \brief Counts a frame that shows nothing.
   * \param[in] status why
   * \param[in] is_decoded it was decoded, and failed behind that: the stream goes on
   * \return whether an I-frame is wanted
   */
  bool
  countFailed(io::CompressionStatus status, bool is_decoded);

  // Of decodeNext() alone.
  io::FrameDecoder decoder_;
  std::optional<VoxelOutlierRemoval> outlier_removal_;
  io::VoxelFrame kept_;                  // its memory and that of latest_ take turns
  io::MemoryRule memory_rule_;           // for both
  unsigned int frames_to_give_back_ = 0; // of them
  // Since the last frame that was decoded.
  std::size_t failures_in_a_row_ = 0; // of frames that need an I-frame behind them
  std::size_t dropped_in_a_row_ = 0;

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
