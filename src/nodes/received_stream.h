// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/stream_health.h>

#include "codec/memory_share.h"
#include "nodes/denoising_decoder.h"
#include "nodes/frame_sequence.h"
#include "nodes/pending_changes.h"
#include "nodes/rate_window.h"
#include "nodes/taken_changes.h"
#include "voxels/memory_rule.h"

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

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief One stream of a CentralNode: the frames that wait, its decoder, its last
 * voxels and its health.
 *
 * A stream with waiting frames has one turn at a time, in which a thread calls
 * decodeNext() or refuseNext() and then endTurn(). These are for one thread at a time;
 * all other members are thread-safe.
 */
class ReceivedStream {
public:
  ReceivedStream(const std::string& name,
                 float min_intensity,
                 const io::DecoderLimits& limits);

  /** \brief Frames that have their points get voxels only where these are filtered; to
   * be called before the first frame. */
  void
  leaveVoxelsOut()
  {
    decoder_.leaveVoxelsOut();
  }

  void
  setMinIntensity(float min_intensity)
  {
    decoder_.setMinIntensity(min_intensity);
  }

  /** \brief Whether frames come without the layout of messages. */
  void
  setPacked(bool is_packed)
  {
    decoder_.setPacked(is_packed);
  }

  /** \brief Replaces the outlier filter from the next frame on.
   * \param[in] settings as checkSettings() accepts; none: no filter
   */
  void
  setOutlierRemoval(const std::optional<VoxelOutlierRemovalSettings>& settings)
  {
    decoder_.setOutlierRemoval(settings);
  }

  /** \brief Outcome of a frame that arrived. */
  enum class Admission {
    Waits,
    TooManyWait, ///< refused
    OutOfMemory  ///< refused: there was no memory for it
  };

  /** \brief Takes a frame that arrived, or refuses it, and counts it.
   * \param[in] bytes the frame
   * \param[in] stamp time of the cloud; none: that in the frame
   * \param[in] max_waiting most frames that may wait
   * \param[in] queue_turn called if the stream needs a turn and has none; the frame is
   * refused if that throws std::bad_alloc
   */
  template <typename AskT>
  Admission
  admit(std::vector<std::uint8_t> bytes,
        std::optional<Time> stamp,
        std::size_t max_waiting,
        const AskT& queue_turn)
  {
    // Locked until the turn is queued, as the next frame requires it.
    const std::lock_guard<std::mutex> lock(mutex_);
    ++health_.frames_received;
    health_.bytes += bytes.size();
    Admission admission = Admission::TooManyWait;
    if (waiting_.size() < max_waiting)
      admission = queue({std::move(bytes), stamp, refused_behind_}, queue_turn);
    if (admission == Admission::Waits) {
      refused_behind_ = 0;
      return admission;
    }
    ++health_.frames_refused;
    ++refused_behind_;
    return admission;
  }

  /** \brief Decodes and denoises the first waiting frame; there must be one. An
   * exception becomes the status of the frame, which then has no voxels.
   * \param[in] clock returns the current time
   * \param[in] listener called with the frame; may be empty
   */
  void
  decodeNext(const Clock& clock, const FrameListener& listener);

  /** \brief Refuses the first waiting frame; there must be one. */
  void
  refuseNext();

  /** \brief Ends the stream's turn.
   * \return true if another frame waits: the caller has to continue or to queue a turn
   */
  bool
  endTurn();

  /** \brief Copies the latest voxels, of any age.
   * \return nothing if there are none; `voxels` is unspecified then
   */
  std::optional<LatestFrame>
  latestVoxels(io::VoxelFrame& voxels);

  /** \brief Takes what has changed since the last time, if the latest frame is of a
   * selection; else what was taken is gone. For one that takes.
   * \param[in] known number of the frame that was taken the last time; 0: none, so that
   * all voxels come
   * \return the frame that is taken; none: the latest one is not of the selection
   */
  std::optional<LatestFrame>
  take(const FrameSelection& selection, std::size_t known, TakenChanges& taken);

  /** \brief Sets how many of the latest voxels could not be merged, and how many with a
   * smaller intensity only. */
  void
  setMergedVoxels(std::size_t outside_grid, std::size_t intensities_reduced);

  StreamHealth
  health(Time now) const;

private:
  struct WaitingFrame {
    std::vector<std::uint8_t> bytes;
    std::optional<Time> stamp; ///< none: that in the frame
    /** \brief Frames that were refused since the previous frame; they are counted as
     * lost when this one is decoded. */
    std::size_t refused_before;
  };

  /** \brief Appends a frame to the queue, or throws; mutex_ is locked. */
  template <typename AskT>
  Admission
  queue(WaitingFrame frame, const AskT& queue_turn)
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
      queue_turn();
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

  /** \brief Decodes a frame and makes it the latest one, or throws.
   * \param[out] is_decoded set once the decoder has accepted the frame
   */
  io::CompressionStatus
  decode(const WaitingFrame& frame,
         std::chrono::steady_clock::time_point start,
         const Clock& clock,
         bool& is_decoded);

  void
  makeLatest(const DenoisedFrame& denoised,
             const WaitingFrame& frame,
             std::chrono::steady_clock::time_point start,
             const Clock& clock);

  const io::VoxelFrame&
  listVoxels();

  void
  makeLatestWhole();

  std::optional<LatestFrame>
  listLatest(io::VoxelFrame& voxels);

  bool
  areChangesKept() const;

  bool
  isSelected(const FrameSelection& selection) const;

  /** \brief The latest frame; mutex_ is locked. */
  LatestFrame
  latestFrame() const
  {
    return {latest_stamp_, health_.frames_decoded};
  }

  bool
  takePending(std::size_t known, TakenChanges& taken);

  std::optional<LatestFrame>
  takeAll(const FrameSelection& selection, std::size_t known, TakenChanges& taken);

  std::size_t
  keptBytes() const;

  void
  dropVoxels() noexcept;

  /** \brief Locked while the decoder is used. Before mutex_ and not within it, as the
   * decoder may drop voxels of any stream. */
  std::mutex decode_mutex_;
  DenoisingDecoder decoder_;
  bool is_whole_ = true; // latest_ has the voxels; else the decoder lists them.
                         // Changed with mutex_ locked, too

  // Used by decodeNext() only, and between two calls by dropVoxels().
  io::VoxelFrame kept_;                // swapped with latest_, to reuse memory
  io::MemoryRule memory_rule_;         // for both
  unsigned int frames_to_release_ = 0; // of kept_ and latest_
  std::size_t frames_by_changes_ = 0;  // in a row, without whole voxels
  bool are_voxels_wanted_ = false;     // the listener has asked for the last ones

  mutable std::mutex mutex_; // guards everything below
  io::VoxelFrame latest_;    // if is_whole_
  bool has_latest_ = false;
  PendingChanges pending_;
  Time latest_stamp_{0};
  StreamHealth health_;
  RateWindow window_;
  std::deque<WaitingFrame> waiting_; // the first one is decoded next
  bool has_turn_ = false;
  std::size_t refused_behind_ = 0; // since the last frame that waited
  FrameSequence sequence_;

  io::MemoryShare share_; // beside that of the decoder; last, as it uses the others
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
