#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace pcl_ext {
namespace nodes {

/** \brief The stamp of a header of PCL as a moment; the last there is for one beyond it,
 * as stamps come from anywhere. */
inline Time
timeOfStamp(std::uint64_t microseconds)
{
  constexpr auto latest =
      std::chrono::duration_cast<std::chrono::microseconds>(Time::max());
  return std::chrono::microseconds(
      std::min(microseconds, static_cast<std::uint64_t>(latest.count())));
}

/** \brief Seconds from a frame's stamp until it was ready; 0 for a stamp of 0, which is
 * what clouds have that were never stamped. */
inline double
latencySeconds(Time stamp, Time ready)
{
  if (stamp == Time(0))
    return 0.0;
  using Seconds = std::chrono::duration<double>;
  // The difference of moments on both sides of 0 may be more than Time holds.
  if ((stamp < Time(0)) != (ready < Time(0)))
    return Seconds(ready).count() - Seconds(stamp).count();
  return Seconds(ready - stamp).count();
}

} // namespace nodes
} // namespace pcl_ext
