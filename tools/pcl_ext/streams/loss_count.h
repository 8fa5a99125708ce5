// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_description.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace pcl_ext::tools {

/** \brief Finds frames of a stream that are missing, by the numbers that the encoder
 * gave. */
class LossCount {
public:
  /** \brief How many frames are missing between the last frame and this one. Those that
   * were there and unreadable are not missing.
   *
   * An I-frame of a lower or much higher number begins a stream anew, as after a
   * restart of the encoder.
   * \param[in] frame the next frame of the stream; its status tells if it is readable
   */
  std::size_t
  missingBefore(const io::FrameDescription& frame)
  {
    if (!frame.status.ok()) {
      ++unreadable_;
      return 0;
    }
    const std::size_t unreadable = std::exchange(unreadable_, 0);
    const std::optional<std::uint32_t> last = last_;
    last_ = frame.frame_number;
    if (!last)
      return 0;
    constexpr std::uint32_t most_missing = 1u << 16;
    const std::uint32_t step = frame.frame_number - *last; // modulo 2^32
    return step == 0 || step > most_missing || step - 1 < unreadable
               ? 0
               : step - 1 - unreadable;
  }

private:
  std::optional<std::uint32_t> last_;
  std::size_t unreadable_ = 0; // frames since then
};

} // namespace pcl_ext::tools
