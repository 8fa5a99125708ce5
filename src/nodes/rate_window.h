// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <deque>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief The frames of the last StreamRates::window, and their rates. */
class RateWindow {
public:
  /** \brief A frame that has just been coded. */
  struct CodedFrame {
    Time ready{0}; ///< when it was ready
    std::size_t bytes = 0;
    double cycle_seconds = 0.0;
    double latency_seconds = 0.0;
  };

  /** \brief Adds a frame and removes those that are older than the window. */
  void
  add(const CodedFrame& frame);

  /** \brief The rates at a time, which may be before the last frame. */
  StreamRates
  rates(Time now) const;

private:
  // Limits the memory if the clock does not advance.
  static constexpr std::size_t most_frames = 4096;

  std::deque<CodedFrame> frames_; // by time
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
