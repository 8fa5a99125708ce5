// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/health_report.h>

#include "pcl_ext_ros_common/node_interfaces.hpp"

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <rclcpp/clock.hpp>
#include <rclcpp/timer.hpp>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext_ros_common {

/** \brief A report as an entry of /diagnostics, of no hardware.
 * \param[in] node its name without the first slash
 * \param[in] name of what is described
 * \param[in] report on it
 */
diagnostic_msgs::msg::DiagnosticStatus
toMessage(const std::string& node,
          const std::string& name,
          const pcl_ext::nodes::HealthReport& report);

/** \brief Publishes the health of streams on /diagnostics, once a second of wall
 * time. */
class HealthPublisher {
public:
  /** \brief An entry's name, to which that of the node is added, and its report. */
  using Entry = std::pair<std::string, pcl_ext::nodes::HealthReport>;

  /** \param[in] node that publishes
   * \param[in] describe called once a second
   * \param[in] clock for the stamps
   */
  HealthPublisher(NodeInterfaces node,
                  std::function<std::vector<Entry>()> describe,
                  const rclcpp::Clock::SharedPtr& clock);

private:
  rclcpp::TimerBase::SharedPtr timer_;
};

} // namespace pcl_ext_ros_common
