// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Detects late and repeated frames of a stream. They are dropped, as the
 * successors of the last frame would lack their reference if a late I-frame were
 * decoded.
 *
 * Frames are numbered modulo 2^32. A sender begins with an I-frame of number 1 each
 * time it starts. doc/bitstream.md has the rules ("Old frames").
 */
class PCL_EXT_CODEC_EXPORT FrameOrder {
public:
  /** \param[in] are_numbers_sure true if a checksum protects the frame number; else the
   * number may be damaged, and only copies of I-frames count as old
   */
  explicit FrameOrder(bool are_numbers_sure) : are_numbers_sure_(are_numbers_sure) {}

  /** \brief Checks a frame.
   * \param[in] number of the frame
   * \param[in] checksum of the frame, which distinguishes frames of the same number
   * \param[in] is_i_frame whether it is an I-frame
   * \return true if it must be dropped: it or a later frame was decoded, and there is
   * no sign that the sender was restarted
   */
  bool
  isOld(std::uint32_t number, std::uint32_t checksum, bool is_i_frame);

  /** \brief Reports a decoded frame, which becomes the last one.
   * \param[in] is_identifiable true if its checksum identifies it, false for a frame
   * without voxels and stamp
   */
  void
  decoded(std::uint32_t number, std::uint32_t checksum, bool is_identifiable) noexcept;

  /** \brief Reports the end of the input, which may be read again from its
   * beginning. */
  void
  inputEnded() noexcept
  {
    has_input_ended_ = true;
  }

private:
  struct FrameIdentity {
    std::uint32_t number = 0;
    std::uint32_t checksum = 0;
    bool is_decoded = false;

    bool
    isSame(std::uint32_t other_number, std::uint32_t other_checksum) const
    {
      return is_decoded && number == other_number && checksum == other_checksum;
    }
  };

  bool
  mayBeRestart(std::uint32_t number, bool is_copy) const;

  /** \brief Number of frames whose copies are detected. */
  static constexpr std::size_t known_frames = 256;

  /** \brief After this many consecutive old frames an I-frame counts as the first one
   * of a restarted sender: few if the I-frame is unknown, as single frames are late;
   * many if it is a copy, as sequences of frames are repeated. */
  static constexpr unsigned int most_unknown_in_a_row = 2;
  static constexpr unsigned int most_copies_in_a_row = 24;

  bool are_numbers_sure_;
  std::array<FrameIdentity, known_frames> known_{}; // by number
  FrameIdentity first_;                             // the last frame with number 1
  FrameIdentity last_;
  unsigned int old_in_a_row_ = 0;
  bool has_input_ended_ = false; // since the last decoded frame
};

} // namespace pcl_ext::PCL_EXT_ABI::io
