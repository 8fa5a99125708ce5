// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <chrono>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Seconds from one time to another, which may be any two. */
inline double
secondsBetween(Time from, Time to)
{
  using Seconds = std::chrono::duration<double>;
  // The difference of two times of different sign may overflow Time.
  if ((from < Time(0)) != (to < Time(0)))
    return Seconds(to).count() - Seconds(from).count();
  return Seconds(to - from).count();
}

/** \brief Seconds from a frame's stamp until it was ready. None if the stamp is of
 * another clock: 0, the default of a cloud without stamp, or more than an hour from
 * `ready`, as those of a recording that is played again. */
inline std::optional<double>
latencySeconds(Time stamp, Time ready)
{
  constexpr double most_seconds = 3600.0;
  const double seconds = secondsBetween(stamp, ready);
  if (stamp == Time(0) || seconds > most_seconds || seconds < -most_seconds)
    return std::nullopt;
  return seconds;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
