// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The part of the history in a frame. */
enum class HistoryPart {
  Used,    ///< the frame is coded with it; it learns from the frame
  Kept,    ///< the frame is coded without it; it learns from the frame
  Replaced ///< the frame is coded without it, as an I-frame; it begins with the frame
};

/** \brief Codes what a P-frame does with the history.
 * \param[in] code_bit codes a bit and returns it; that of a decoder ignores its argument
 */
template <typename CodeBitT>
HistoryPart
codeHistoryPart(const CodeBitT& code_bit, HistoryPart part)
{
  if (code_bit(part == HistoryPart::Used))
    return HistoryPart::Used;
  return code_bit(part == HistoryPart::Kept) ? HistoryPart::Kept
                                             : HistoryPart::Replaced;
}

/** \brief Decides for an encoder which P-frames use the history, by the sizes of frames:
 * that of a moving sensor costs more bytes than it saves, and that of a noisy sensor
 * saves bytes only after some frames. The history also learns from frames that do
 * without it, so that trying it costs no bytes. Integers only, so that the same frames
 * have the same bytes on every machine. */
class HistoryUse {
public:
  /** \brief A frame was an I-frame. */
  void
  addIFrame()
  {
    // The history of a moving sensor is too long before it has learned. One time may be
    // an exception, as a sensor that was pushed.
    const bool has_lost = state_ == State::Learning && loss_ > 0;
    if (has_lost && was_interrupted_)
      beginPause();
    else if (state_ != State::Paused || --pause_left_ == 0)
      beginLearning();
    was_interrupted_ = has_lost;
  }

  /** \brief Notes what an I-frame takes. */
  void
  measureIFrame(std::size_t voxels, std::size_t bytes)
  {
    // Models that start anew cost some bytes, which frames without the history do not.
    measure(voxels, bytes - bytes / 32);
  }

  /** \brief Encodes a P-frame with or without the history, whichever is smaller.
   * \param[in] voxels of the frame, above 0
   * \param[in] encode encodes the frame and returns its bytes; called with
   * HistoryPart::Used, with another part, or first with the one and then with the other
   * \return the part that the frame should have
   */
  template <typename EncodeT>
  HistoryPart
  choose(std::size_t voxels, const EncodeT& encode)
  {
    const bool is_tried = isTried();
    std::size_t bytes = 0;
    if (is_tried) {
      bytes = encode(HistoryPart::Used);
      if (!isDoubtful(voxels, bytes)) {
        addWith();
        return HistoryPart::Used;
      }
    }
    const HistoryPart part = partWithout();
    const std::size_t bytes_without = encode(part);
    measure(voxels, bytes_without);
    if (is_tried && isWorth(bytes, bytes_without)) {
      addWith();
      return HistoryPart::Used;
    }
    addWithout();
    return part;
  }

private:
  enum class State {
    Learning, ///< from frames that do without it
    Used,
    Paused ///< replaced by each frame, as learning takes time
  };

  struct Size {
    std::size_t voxels = 0;
    std::size_t bytes = 0;
  };

  /** \brief True if the next P-frame should be encoded with the history: at once, as a
   * calm scene's pays at once, and while it learns after some frames, as a trial takes
   * the time of a frame. */
  bool
  isTried() const
  {
    return state_ == State::Used ||
           (state_ == State::Learning &&
            (learned_ == 1 || learned_ == 3 || learned_ >= last_trial));
  }

  /** \brief What the next P-frame should do with the history, where it does without. */
  HistoryPart
  partWithout() const
  {
    return state_ == State::Paused ? HistoryPart::Replaced : HistoryPart::Kept;
  }

  /** \brief True if a frame with the history should be encoded without, too: it takes
   * more bytes a voxel than the last one without, or there was no such comparison for
   * long.
   * \param[in] voxels of the frame
   * \param[in] bytes of the frame
   */
  bool
  isDoubtful(std::size_t voxels, std::size_t bytes) const
  {
    // The headers of small frames say more than their voxels.
    constexpr std::size_t least_voxels = 256;
    return voxels >= least_voxels &&
           (frames_since_comparison_ >= frames_to_comparison_ ||
            std::uint64_t{bytes} * without_history_.voxels >
                std::uint64_t{without_history_.bytes} * voxels);
  }

  /** \brief Notes what a frame takes without the history. */
  void
  measure(std::size_t voxels, std::size_t bytes)
  {
    without_history_ = {voxels, bytes};
  }

  /** \brief True if a frame should use the history.
   * \param[in] bytes of the frame with it, above 0
   * \param[in] bytes_without of the same frame, above 0
   */
  bool
  isWorth(std::size_t bytes, std::size_t bytes_without)
  {
    const auto saves_one_in = [&](std::size_t share) {
      return share * bytes <= (share - 1) * bytes_without;
    };
    frames_since_comparison_ = 0;
    frames_to_comparison_ = saves_one_in(8)    ? longest_without_comparison
                            : saves_one_in(16) ? 16
                            : saves_one_in(32) ? 8
                                               : 2;
    if (bytes <= bytes_without)
      return true;
    // A noisy sensor's shrinks from frame to frame, a moving one's does not.
    const std::uint64_t loss =
        (std::uint64_t{bytes - bytes_without} << 16) / bytes_without;
    is_hopeless_ = loss_ > 0 && 4 * loss > 3 * loss_;
    loss_ = loss;
    return false;
  }

  /** \brief A P-frame used the history. */
  void
  addWith()
  {
    state_ = State::Used;
    has_lost_ = false;
    was_interrupted_ = false;
    ++frames_since_comparison_;
    constexpr unsigned int long_use = 8;
    if (++frames_used_ >= long_use)
      pause_ = 0;
  }

  /** \brief A P-frame did without the history, as partWithout() says. */
  void
  addWithout()
  {
    if (state_ == State::Paused) {
      if (--pause_left_ == 0)
        beginLearning();
    }
    else if (state_ == State::Used) {
      // One frame may be an exception.
      if (has_lost_)
        beginLearning();
      else
        has_lost_ = true;
    }
    else if (is_hopeless_ || learned_ >= last_trial)
      beginPause();
    else
      ++learned_;
  }

  void
  beginLearning()
  {
    state_ = State::Learning;
    learned_ = 1;
    frames_used_ = 0;
    loss_ = 0;
    is_hopeless_ = false;
    has_lost_ = false;
  }

  void
  beginPause()
  {
    constexpr unsigned int first_pause = 15;
    constexpr unsigned int longest_pause = 63;
    state_ = State::Paused;
    pause_ = std::clamp(2 * pause_ + 1, first_pause, longest_pause);
    pause_left_ = pause_;
  }

  // In frames.
  static constexpr unsigned int last_trial = 8;
  static constexpr unsigned int longest_without_comparison = 32;

  State state_ = State::Learning;
  Size without_history_;     // of the last frame that was measured
  unsigned int learned_ = 1; // frames that the history has learned from
  std::uint64_t loss_ = 0;   // of the last trial, 2^16 is all bytes without; 0: none
  bool is_hopeless_ = false; // the loss does not shrink
  bool has_lost_ = false;    // used, but not worth its bytes in the last frame
  bool was_interrupted_ = false; // an I-frame ended what it had learned in vain
  unsigned int frames_used_ = 0; // since it learned
  unsigned int frames_since_comparison_ = longest_without_comparison;
  unsigned int frames_to_comparison_ = longest_without_comparison;
  unsigned int pause_ = 0;      // the last one
  unsigned int pause_left_ = 0; // of it
};

} // namespace pcl_ext::PCL_EXT_ABI::io
