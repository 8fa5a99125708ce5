// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/status.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \addtogroup nodes
 * @{ */

/** \brief A time, since the epoch of the clock that stamps the clouds. */
using Time = std::chrono::nanoseconds;

/** \brief Returns the current time. May be called by several threads at once. */
using Clock = std::function<Time()>;

/** \brief The system clock, since 1970. */
PCL_EXT_EXPORT Time
systemTime();

/** \brief Time of a clock that is never set, from any beginning. */
PCL_EXT_EXPORT Time
steadyTime();

/** \brief How often something took how long, from the beginning on. */
struct DurationHistogram {
  /** \brief The longest duration of each bucket but the last, seconds; ascending. */
  static constexpr std::array<double, 13> upper_bounds{0.0001,
                                                       0.00025,
                                                       0.0005,
                                                       0.001,
                                                       0.0025,
                                                       0.005,
                                                       0.01,
                                                       0.025,
                                                       0.05,
                                                       0.1,
                                                       0.25,
                                                       0.5,
                                                       1.0};

  /** \brief Durations above the bound before and up to that of the bucket; the last one
   * has those above all bounds. */
  std::array<std::uint64_t, upper_bounds.size() + 1> counts{};
  double sum_seconds = 0.0; ///< of all durations

  /** \param[in] seconds finite */
  void
  add(double seconds)
  {
    const auto bound =
        std::lower_bound(upper_bounds.begin(), upper_bounds.end(), seconds);
    ++counts[static_cast<std::size_t>(bound - upper_bounds.begin())];
    sum_seconds += seconds;
  }

  /** \brief Number of durations. */
  std::uint64_t
  count() const
  {
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  }
};

/** \brief Rates of one stream over the last seconds. */
struct StreamRates {
  /** \brief Length of the time window. */
  static constexpr Time window = std::chrono::seconds(2);

  double frames_per_second =
      0.0; ///< from the intervals between frames; 0 for fewer than two
  double bytes_per_second = 0.0;   ///< of the coded frames
  double mean_cycle_seconds = 0.0; ///< computing time of one frame
  double max_cycle_seconds = 0.0;
  /** \brief From a frame's stamp until it was ready; 0 without a stamp, or if it is more
   * than an hour from the clock. */
  double mean_latency_seconds = 0.0;
  double max_latency_seconds = 0.0;
};

/** \brief Health of a stream of a CentralNode. Counts are since the stream was added.
 * Every received frame is counted as decoded, failed, dropped or refused, or still
 * waits. */
struct StreamHealth {
  std::string name;
  std::size_t frames_received = 0; ///< handed to CentralNode::receive
  std::size_t frames_decoded = 0;
  std::size_t frames_failed = 0;  ///< could not be decoded or denoised
  std::size_t frames_dropped = 0; ///< late or repeated; the stream continued
  std::size_t frames_refused = 0; ///< too many waited, or memory ran out
  std::size_t frames_lost =
      0; ///< gaps in the sender's numbers that were not filled in time
  std::size_t memory_drops = 0; ///< its voxels were dropped to keep the memory limit
  bool lacks_voxels = false;    ///< no frame was decoded since the last drop
  std::size_t i_frame_requests = 0; ///< frames whose wants_i_frame was set
  std::uint64_t bytes = 0;          ///< of all frames received
  /** \brief Of the last decoded frame, before denoising; points, if it has no voxels. */
  std::size_t voxels = 0;
  std::size_t kept_voxels = 0; ///< of these: after denoising
  double resolution = 0.0;     ///< edge of these, metres; 0: no frame was decoded
  bool has_intensities = true; ///< the last decoded frame; else no threshold has effect
  std::size_t outliers_removed = 0; ///< of `voxels`: by setOutlierRemoval()
  /** \brief Of the last decoded frame: whether its outliers could be judged; Ok without
   * setOutlierRemoval(). */
  OutlierRemovalStatus outlier_removal;
  /** \brief Points of scans that were left out when they got voxels, as they are outside
   * the grid; see io::FramePoints::outside_grid. */
  std::size_t points_outside_grid = 0;
  /** \brief Of the voxels that the last CentralNode::merge took from the stream: left
   * out, as they are more than 2^20 voxels from the origin of the common grid. */
  std::size_t voxels_outside_grid = 0;
  /** \brief Of the same voxels: merged with a smaller intensity than they have, as it
   * is too far above those of other streams. */
  std::size_t intensities_reduced = 0;
  std::size_t merges_outside_grid = 0; ///< calls of merge() that left voxels of it out
  std::size_t merges_reduced = 0;      ///< calls of merge() that reduced intensities
  bool in_sync = false; ///< the last frame was decoded, even if denoising failed
  Time last_decoded{0}; ///< when the last frame was ready; 0: never
  io::CompressionStatus last_failure; ///< status of the last frame that failed
  StreamRates rates;                  ///< of the frames that were decoded
  DurationHistogram decode_times;     ///< computing times of these
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::nodes
