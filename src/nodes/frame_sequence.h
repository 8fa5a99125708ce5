// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Counts the frames of a stream by what became of them, finds those that were
 * lost, and tells when to ask the sender for an I-frame. */
class FrameSequence {
public:
  /** \brief Frames were refused before the next one, which then miss between two
   * decoded ones without being lost. */
  void
  refuse(std::size_t count)
  {
    unnumbered_ += count;
  }

  /** \brief Counts a decoded frame, and those lost before it. */
  void
  addDecoded(std::uint32_t frame_number, StreamHealth& health);

  /** \brief Counts a late or repeated frame.
   * \return whether to request an I-frame
   */
  bool
  addDropped(StreamHealth& health);

  /** \brief Counts a frame that failed.
   * \param[in] status why
   * \param[in] frame_number of a frame that failed after decoding, so that the stream
   * continues; none: it was not decoded
   * \return whether to request an I-frame
   */
  bool
  addFailed(io::CompressionStatus status,
            std::optional<std::uint32_t> frame_number,
            StreamHealth& health);

private:
  void
  follow(std::uint32_t frame_number, StreamHealth& health);

  bool
  wantsIFrame(io::CompressionCode code);

  std::optional<std::uint32_t> last_number_; // of the last decoded frame
  std::size_t unnumbered_ = 0; // frames that failed or were refused since then
  // Since the last frame that was decoded:
  std::size_t failures_in_a_row_ = 0; // frames that need an I-frame to recover
  std::size_t dropped_in_a_row_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
