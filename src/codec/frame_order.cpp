// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/frame_order.h"

namespace pcl_ext::PCL_EXT_ABI::io {

bool
FrameOrder::isOld(std::uint32_t number, std::uint32_t checksum, bool is_i_frame)
{
  if (!last_.is_decoded)
    return false;
  if (number == last_.number + 1)
    return false;
  // Decoding the last I-frame again does no harm, and a file of one frame may be read
  // twice.
  if (is_i_frame && last_.isSame(number, checksum))
    return false;
  const bool is_copy = known_[number % known_frames].isSame(number, checksum) ||
                       first_.isSame(number, checksum);
  const bool is_above = number != last_.number && number - last_.number < (1u << 31);
  if (is_above && !is_copy)
    return false;
  if (is_i_frame && mayBeRestart(number, is_copy))
    return false;
  ++old_in_a_row_;
  return true;
}

/** \brief True if an old I-frame may be the first frame of a restarted sender. */
bool
FrameOrder::mayBeRestart(std::uint32_t number, bool is_copy) const
{
  if (number == 1 && has_input_ended_)
    return true;
  if (is_copy)
    return old_in_a_row_ >= most_copies_in_a_row;
  return number == 1 || !are_numbers_sure_ || old_in_a_row_ >= most_unknown_in_a_row;
}

void
FrameOrder::decoded(std::uint32_t number,
                    std::uint32_t checksum,
                    bool is_identifiable) noexcept
{
  last_ = {number, checksum, true};
  old_in_a_row_ = 0;
  has_input_ended_ = false;
  const FrameIdentity known = is_identifiable ? last_ : FrameIdentity();
  known_[number % known_frames] = known;
  if (number == 1)
    first_ = known;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
