// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief The time from frame to frame in ticks, sixtieths of a second: 3 at 20 frames a
 * second, 2 at 30. Rounded, so that stamps that jitter count as even ones. */
class FrameTicks {
public:
  /** \brief At 20 frames a second. */
  static constexpr unsigned int usual = 3;
  static constexpr unsigned int most = 255;

  /** \brief Takes the time of a frame.
   * \param[in] time of any clock. Without one, or where it is not later than the last, a
   * frame counts as long after the last one as the one before it, or as at 20 frames a
   * second
   * \return ticks since the frame before, 1 to \ref most
   */
  unsigned int
  take(const std::optional<std::chrono::nanoseconds>& time)
  {
    if (!time)
      return interval_;
    if (last_ && *time > *last_) {
      constexpr std::uint64_t nanoseconds = 1000000000;
      constexpr std::uint64_t ticks = 60;
      // Unsigned, as it may be outside the range of the clock.
      const std::uint64_t elapsed =
          std::min(static_cast<std::uint64_t>(time->count()) -
                       static_cast<std::uint64_t>(last_->count()),
                   most * nanoseconds / ticks);
      interval_ = static_cast<unsigned int>(std::max<std::uint64_t>(
          1, (elapsed * ticks + nanoseconds / 2) / nanoseconds));
    }
    last_ = time;
    return interval_;
  }

private:
  std::optional<std::chrono::nanoseconds> last_;
  unsigned int interval_ = usual;
};

} // namespace pcl_ext::PCL_EXT_ABI
