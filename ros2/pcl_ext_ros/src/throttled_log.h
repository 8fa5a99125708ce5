#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <rclcpp/logging.hpp>

#include <atomic>
#include <chrono>
#include <string>

namespace pcl_ext_ros {

/** \brief Warnings of one kind of one node, of which few are logged. The macros of rclcpp
 * would share the time of the last one with the other nodes of a container. Thread-safe. */
class ThrottledLog {
public:
  explicit ThrottledLog(const rclcpp::Logger& logger) : logger_(logger) {}

  /** \brief Logs a warning, unless there was one within the last seconds. */
  void
  warn(const std::string& warning)
  {
    constexpr pcl_ext::nodes::Time between_warnings = std::chrono::seconds(5);
    const auto now = pcl_ext::nodes::steadyTime().count();
    auto next = next_.load();
    if (now >= next &&
        next_.compare_exchange_strong(next, now + between_warnings.count()))
      RCLCPP_WARN(logger_, "%s", warning.c_str());
  }

private:
  rclcpp::Logger logger_;
  std::atomic<pcl_ext::nodes::Time::rep> next_{0}; // earliest time of the next one
};

} // namespace pcl_ext_ros
