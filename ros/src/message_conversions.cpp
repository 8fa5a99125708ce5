// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "message_conversions.h"

#include <ros/this_node.h>

#include <limits>

namespace pcl_ext_ros1 {

pcl_ext::nodes::Time
toNodeTime(const ros::Time& time)
{
  return std::chrono::seconds(time.sec) + std::chrono::nanoseconds(time.nsec);
}

ros::Time
toRosTime(pcl_ext::nodes::Time time)
{
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  if (time.count() < 0 || seconds.count() > std::numeric_limits<std::uint32_t>::max())
    return {};
  return {static_cast<std::uint32_t>(seconds.count()),
          static_cast<std::uint32_t>((time - seconds).count())};
}

pcl_ext::nodes::Time
rosTimeNow()
{
  return toNodeTime(ros::Time::now());
}

diagnostic_msgs::DiagnosticStatus
toMessage(const std::string& name, const pcl_ext::nodes::HealthReport& report)
{
  diagnostic_msgs::DiagnosticStatus status;
  status.level = static_cast<std::uint8_t>(report.level());
  status.name = ros::this_node::getName().substr(1) + ": " + name;
  status.message = report.message();
  status.hardware_id = name;
  for (const auto& [key, value] : report.values()) {
    auto& entry = status.values.emplace_back();
    entry.key = key;
    entry.value = value;
  }
  return status;
}

} // namespace pcl_ext_ros1
