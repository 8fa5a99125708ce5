// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <atomic>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief Decides when requests for I-frames are passed on to an encoder. A request
 * that arrives right after an I-frame on request may be older than that frame: it waits
 * until one more frame is sent, so that requests never cause two I-frames in a row,
 * however many come. Members other than add() are for one thread at a time. */
class IFrameRequests {
public:
  /** \brief A receiver requests an I-frame. Called by any thread. */
  void
  add()
  {
    is_due_ = true;
  }

  /** \brief There is a new receiver. It has not got the last frame, so that the next
   * one has to be an I-frame in any case. */
  void
  addReceiver()
  {
    is_due_ = true;
    frames_since_ = frames_to_wait;
  }

  /** \brief True if the frame that comes next has to be an I-frame; the request is
   * done. */
  bool
  take()
  {
    if (!is_due_ || frames_since_ < frames_to_wait)
      return false;
    is_due_ = false;
    frames_since_ = 0;
    return true;
  }

  /** \brief A frame was sent. */
  void
  countFrame()
  {
    ++frames_since_;
  }

private:
  static constexpr std::size_t frames_to_wait = 2;

  std::atomic<bool> is_due_{false};
  std::size_t frames_since_ = frames_to_wait; // since a request was passed on
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
