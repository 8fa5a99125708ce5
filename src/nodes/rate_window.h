#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <deque>

namespace pcl_ext {
namespace nodes {

/** \brief The frames of the last StreamRates::window, and what they amount to. */
class RateWindow {
public:
  /** \brief A frame that has just been coded. */
  struct Frame {
    Time ready{0}; ///< when it was ready
    std::size_t bytes = 0;
    double cycle_seconds = 0.0;
    double latency_seconds = 0.0;
  };

  /** \brief Adds a frame; forgets what is too old as of then. */
  void
  add(const Frame& frame);

  /** \brief The figures as of a moment, which may be before the last frame's. */
  StreamRates
  rates(Time now) const;

private:
  // A clock that stands still must not make it grow for ever.
  static constexpr std::size_t most_frames = 4096;

  std::deque<Frame> frames_; // in the order of their times
};

} // namespace nodes
} // namespace pcl_ext
