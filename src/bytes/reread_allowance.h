// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Limits how many bytes are read again after failed frames, so that the time to
 * search n bytes is O(n) for any content.
 *
 * After a failed frame the search continues at its second byte, as its size may be
 * forged and include valid frames. Without a limit, bytes with many forged sizes would
 * be read many times.
 */
class RereadAllowance {
public:
  /** \param[in] most the initial and the highest allowance, bytes */
  explicit RereadAllowance(std::size_t most) : most_(most), left_(most) {}

  /** \brief Takes bytes that are to be read again from the allowance.
   * \return false if there is not enough; the allowance is unchanged then
   */
  bool
  take(std::size_t bytes)
  {
    if (bytes > left_)
      return false;
    left_ -= bytes;
    return true;
  }

  /** \brief Reports bytes that were searched and will not be read again; increases the
   * allowance. */
  void
  pass(std::size_t bytes)
  {
    left_ += std::min((most_ - left_) / times_read, bytes) * times_read;
  }

private:
  static constexpr std::size_t times_read = 16;

  std::size_t most_;
  std::size_t left_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
