// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace pcl_ext {
namespace nodes {

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

} // namespace nodes
} // namespace pcl_ext
