// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <builtin_interfaces/msg/time.hpp>

#include <chrono>
#include <cstdint>

namespace pcl_ext_ros_common {

/** \brief A stamp as a time since 1970. */
inline pcl_ext::nodes::Time
toTime(const builtin_interfaces::msg::Time& stamp)
{
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

/** \brief A stamp for a header of PCL, microseconds; 0 for times before 1970. */
inline std::uint64_t
toMicroseconds(const builtin_interfaces::msg::Time& stamp)
{
  const auto time =
      std::chrono::duration_cast<std::chrono::microseconds>(toTime(stamp)).count();
  return time < 0 ? 0 : static_cast<std::uint64_t>(time);
}

} // namespace pcl_ext_ros_common
