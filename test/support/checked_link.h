// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A link that checks what is sent over it, computed otherwise than LinkBudget.
 */
#pragma once

#include <pcl_ext/version.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

/** \brief Expects that no second takes more than its bits, and that no more waits than
 * the buffer holds. */
class CheckedLink {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  CheckedLink(double bits_per_second, double buffer_seconds)
  : rate_(bits_per_second), buffer_(buffer_seconds)
  {}

  void
  setRate(double bits_per_second)
  {
    rate_ = bits_per_second;
  }

  void
  advance(Nanoseconds elapsed)
  {
    time_ += elapsed;
    const long double seconds = std::chrono::duration<long double>(elapsed).count();
    waiting_bits_ = std::max(0.0L, waiting_bits_ - seconds * rate_);
  }

  void
  add(std::size_t bytes)
  {
    if (bytes == 0)
      return;
    const long double bits = 8.0L * static_cast<long double>(bytes);
    frames_.push_back({time_, bits / rate_});
    waiting_bits_ += bits;
    // Of windows that end with this frame; others have less.
    long double seconds = 0.0L;
    for (auto frame = frames_.rbegin();
         frame != frames_.rend() && frame->time > time_ - std::chrono::seconds(1);
         ++frame)
      seconds += frame->seconds;
    EXPECT_LE(seconds, 1.0L + rounding);
    EXPECT_LE(waiting_bits_ - rate_ * buffer_, rate_ * rounding);
  }

  std::size_t
  frames() const
  {
    return frames_.size();
  }

private:
  // Far below a bit of the highest rate.
  static constexpr long double rounding = 1e-15L;

  struct SentFrame {
    Nanoseconds time;
    long double seconds; // at the rate at which it was sent
  };

  long double rate_;
  long double buffer_;
  Nanoseconds time_{0};
  std::vector<SentFrame> frames_;
  long double waiting_bits_ = 0.0L;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::test
