// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief The time between clouds, by times that may be out of order. */
class CloudClock {
public:
  using Nanoseconds = std::chrono::nanoseconds;

  /** \brief Takes the time of a cloud. One up to a second earlier than the latest counts
   * as that; one earlier still begins again, as a recording that is repeated does.
   * \return time since the latest cloud, at most an hour, so that sums are in range; none
   * for the first cloud
   */
  std::optional<Nanoseconds>
  take(Nanoseconds time)
  {
    constexpr std::uint64_t second = 1000000000;
    constexpr std::uint64_t hour = 3600 * second;
    if (!latest_) {
      latest_ = time;
      return std::nullopt;
    }
    if (time < *latest_) {
      if (difference(*latest_, time) > second)
        latest_ = time;
      return Nanoseconds(0);
    }
    const std::uint64_t elapsed = std::min(difference(time, *latest_), hour);
    latest_ = time;
    return Nanoseconds(static_cast<std::int64_t>(elapsed));
  }

private:
  /** \brief Unsigned, as it may be outside the range of Nanoseconds. */
  static std::uint64_t
  difference(Nanoseconds later, Nanoseconds earlier)
  {
    return static_cast<std::uint64_t>(later.count()) -
           static_cast<std::uint64_t>(earlier.count());
  }

  std::optional<Nanoseconds> latest_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
