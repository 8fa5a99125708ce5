// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/stream_health.h>

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/time.h>

#include <string>

namespace pcl_ext_ros1 {

/** \brief A warning is repeated at most this often. */
constexpr double seconds_between_warnings = 5.0;

/** \brief Exact conversions; a time that ROS cannot represent, before 1970 or after 2106,
 * becomes 0. */
pcl_ext::nodes::Time
toNodeTime(const ros::Time& time);
ros::Time
toRosTime(pcl_ext::nodes::Time time);

/** \brief ROS time, which may be simulated. */
pcl_ext::nodes::Time
rosTimeNow();

/** \brief One entry of /diagnostics.
 * \param[in] name what it is about; the node's name is put before it
 * \param[in] report its content
 */
diagnostic_msgs::DiagnosticStatus
toMessage(const std::string& name, const pcl_ext::nodes::HealthReport& report);

} // namespace pcl_ext_ros1
