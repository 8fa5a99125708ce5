#include "pcl_ext_point_cloud_transport/health_publisher.hpp"

#include <rclcpp/create_timer.hpp>

#include <chrono>

namespace pcl_ext_point_cloud_transport {

diagnostic_msgs::msg::DiagnosticStatus
toMessage(const std::string& node,
          const std::string& name,
          const pcl_ext::nodes::HealthReport& report)
{
  diagnostic_msgs::msg::DiagnosticStatus status;
  status.level = static_cast<unsigned char>(report.level());
  status.name = node + ": " + name;
  status.message = report.message();
  status.hardware_id = name;
  for (const auto& [key, value] : report.values()) {
    diagnostic_msgs::msg::KeyValue pair;
    pair.key = key;
    pair.value = value;
    status.values.push_back(pair);
  }
  return status;
}

HealthPublisher::HealthPublisher(rclcpp::Node& node,
                                 std::function<std::vector<Entry>()> describe)
{
  const auto publisher =
      node.create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10);
  const std::string name = std::string(node.get_fully_qualified_name()).substr(1);
  // Another thread may call it while the instance and the node end.
  timer_ = node.create_wall_timer(
      std::chrono::seconds(1),
      [publisher, name, clock = node.get_clock(), describe = std::move(describe)] {
        diagnostic_msgs::msg::DiagnosticArray message;
        message.header.stamp = clock->now();
        for (const auto& [entry, report] : describe())
          message.status.push_back(toMessage(name, entry, report));
        publisher->publish(message);
      });
}

} // namespace pcl_ext_point_cloud_transport
