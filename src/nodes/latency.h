#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace pcl_ext {
namespace nodes {

/** \brief The stamp of a PCL header as a time; any stamp is valid and clamped to the
 * largest time. */
inline Time
timeOfStamp(std::uint64_t microseconds)
{
  constexpr auto latest =
      std::chrono::duration_cast<std::chrono::microseconds>(Time::max());
  return std::chrono::microseconds(
      std::min(microseconds, static_cast<std::uint64_t>(latest.count())));
}

/** \brief Seconds from a frame's stamp until it was ready; 0 for a stamp of 0, the
 * default of a cloud without stamp. */
inline double
latencySeconds(Time stamp, Time ready)
{
  if (stamp == Time(0))
    return 0.0;
  using Seconds = std::chrono::duration<double>;
  // The difference of two times of different sign may overflow Time.
  if ((stamp < Time(0)) != (ready < Time(0)))
    return Seconds(ready).count() - Seconds(stamp).count();
  return Seconds(ready - stamp).count();
}

} // namespace nodes
} // namespace pcl_ext
