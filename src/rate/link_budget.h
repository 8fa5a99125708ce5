// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief How many bytes a link of a given rate takes now: of any window of one second
 * not more than a second's, and no more than what its buffer holds until it is sent.
 *
 * Computed in nanoseconds of the link's time, so that both hold exactly, also where the
 * rate changes: a frame counts at the rate at which it was sent. */
class LinkBudget {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  static constexpr Nanoseconds window = std::chrono::seconds(1);

  /** \param[in] buffer_seconds how long the last byte of a frame may wait, 0.01 to 1 */
  explicit LinkBudget(double buffer_seconds);

  /** \brief Sets the rate, bits a second, from now on; what waits is sent at it. */
  void
  setRate(double bits_per_second);

  /** \brief Lets time pass, 0 or more. */
  void
  advance(Nanoseconds elapsed);

  /** \brief Most bytes of a frame now. */
  std::size_t
  room() const;

  /** \brief Whether a frame would find as much room as there ever is. */
  bool
  isEmpty() const
  {
    return frames_.empty() && backlog_ == Nanoseconds::zero();
  }

  /** \brief How long what waits takes. */
  Nanoseconds
  backlog() const
  {
    return backlog_;
  }

  /** \brief Adds a frame of at most room() bytes. */
  void
  add(std::size_t bytes);

  /** \brief Share of a second that the frames of the last one take, 0 to 1. */
  double
  load() const
  {
    return static_cast<double>(sum_.count()) / static_cast<double>(window.count());
  }

private:
  struct SentFrame {
    Nanoseconds time{0};
    Nanoseconds link_time{0};
  };

  std::size_t
  bytesIn(Nanoseconds link_time) const;

  Nanoseconds buffer_;
  double nanoseconds_per_byte_ = 1.0;
  Nanoseconds time_{0};
  std::deque<SentFrame> frames_; // of the window, by time
  Nanoseconds sum_{0};           // of their link times
  Nanoseconds backlog_{0};       // link time of what waits
};

} // namespace pcl_ext::PCL_EXT_ABI::io
