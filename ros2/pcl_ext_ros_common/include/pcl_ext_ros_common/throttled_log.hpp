// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <rclcpp/logging.hpp>

#include <atomic>
#include <chrono>
#include <string>

namespace pcl_ext_ros_common {

/** \brief Messages of one kind of one node or topic, of which few are logged. The
 * macros of rclcpp would share the time of the last one with all others of the process,
 * and would stop where simulated time does. Thread-safe. */
class ThrottledLog {
public:
  explicit ThrottledLog(const rclcpp::Logger& logger) : logger_(logger) {}

  /** \brief Logs a warning, unless there was a message within the last seconds. */
  void
  warn(const std::string& warning)
  {
    if (isDue())
      RCLCPP_WARN(logger_, "%s", warning.c_str());
  }

  /** \brief The same for an error. */
  void
  error(const std::string& error)
  {
    if (isDue())
      RCLCPP_ERROR(logger_, "%s", error.c_str());
  }

private:
  bool
  isDue()
  {
    constexpr pcl_ext::nodes::Time between_messages = std::chrono::seconds(5);
    const auto now = pcl_ext::nodes::steadyTime().count();
    auto next = next_.load();
    return now >= next &&
           next_.compare_exchange_strong(next, now + between_messages.count());
  }

  rclcpp::Logger logger_;
  std::atomic<pcl_ext::nodes::Time::rep> next_{0}; // earliest time of the next one
};

} // namespace pcl_ext_ros_common
