// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_ros_common/health_publisher.hpp"

#include <rclcpp/create_publisher.hpp>
#include <rclcpp/create_timer.hpp>
#include <rclcpp/node_interfaces/node_timers.hpp>

#include <chrono>

namespace pcl_ext_ros_common {

diagnostic_msgs::msg::DiagnosticStatus
toMessage(const std::string& node,
          const std::string& name,
          const pcl_ext::nodes::HealthReport& report)
{
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = static_cast<unsigned char>(report.level());
  status.name = node + ": " + name;
  status.message = report.message();
  status.hardware_id = "none"; // as diagnostic_updater has it for software
  for (const auto& [key, value] : report.values()) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  return status;
}

HealthPublisher::HealthPublisher(NodeInterfaces node,
                                 std::function<std::vector<Entry>()> describe,
                                 const rclcpp::Clock::SharedPtr& clock)
{
  const auto base = node.get_node_base_interface();
  auto topics = node.get_node_topics_interface();
  auto parameters = node.get_node_parameters_interface();
  const auto publisher =
      rclcpp::create_publisher<diagnostic_msgs::msg::DiagnosticArray>(
          parameters, topics, "/diagnostics", rclcpp::QoS(10));
  const std::string name = std::string(base->get_fully_qualified_name()).substr(1);
  // The interfaces have no timers; those of a node are stateless.
  rclcpp::node_interfaces::NodeTimers timers(base.get());
  // Another thread may call it while the instance and the node end.
  timer_ = rclcpp::create_wall_timer(
      std::chrono::seconds(1),
      [publisher, name, clock, describe = std::move(describe)] {
        diagnostic_msgs::msg::DiagnosticArray message;
        message.header.stamp = clock->now();
        for (const auto& [entry, report] : describe())
          message.status.push_back(toMessage(name, entry, report));
        publisher->publish(message);
      },
      nullptr,
      base.get(),
      &timers);
}

} // namespace pcl_ext_ros_common
