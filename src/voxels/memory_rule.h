// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Decides when to release memory that is reused from frame to frame: the memory
 * of a large frame is not kept for the rest of a stream, and alternating sizes do not
 * cause an allocation for each frame.
 *
 * Sizes and the floor have the same unit, bytes or elements.
 */
class MemoryRule {
public:
  /** \brief Number of frames that must need less before memory is released. */
  static constexpr std::size_t frames = 8;

  /** \brief Memory of up to this multiple of what these frames needed is kept. */
  static constexpr std::size_t factor = 4;

  /** \brief Default of the floor, bytes. */
  static constexpr std::size_t default_floor = std::size_t{1} << 16;

  /** \param[in] floor memory up to this size is never released */
  explicit MemoryRule(std::size_t floor = default_floor) : floor_(floor) {}

  /** \brief To be called once for each frame, also for one that failed.
   * \param[in] needed size that the current frame needed
   * \param[in] taken size that was allocated for it, if that may be more, as for a
   * frame that failed
   * \return true if memory is allocated for more than `factor` times what each of the
   * last `frames` frames needed, this one included, and should be released now
   */
  bool
  shouldRelease(std::size_t needed, std::size_t taken = 0)
  {
    last_[next_] = needed;
    next_ = (next_ + 1) % frames;
    most_ = std::max({most_, needed, taken});
    const std::size_t most_of_last = *std::max_element(last_.begin(), last_.end());
    // A division, as the product might overflow.
    if (most_ <= floor_ || (most_ - 1) / factor < most_of_last)
      return false;
    most_ = most_of_last;
    return true;
  }

  /** \brief The largest size since memory was released, which may still be allocated. */
  std::size_t
  most() const
  {
    return most_;
  }

private:
  std::size_t floor_;
  std::array<std::size_t, frames> last_{}; // sizes that the last frames needed
  std::size_t next_ = 0;                   // the oldest of them
  std::size_t most_ = 0;                   // needed or taken since the last release
};

} // namespace pcl_ext::PCL_EXT_ABI::io
