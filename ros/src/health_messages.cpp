#include "health_messages.h"

#include <diagnostic_msgs/KeyValue.h>
#include <ros/this_node.h>

namespace pcl_ext_ros1 {

diagnostic_msgs::DiagnosticStatus
toMessage(const std::string& name, const pcl_ext::nodes::HealthReport& report)
{
  diagnostic_msgs::DiagnosticStatus status;
  status.level = static_cast<std::uint8_t>(report.level());
  status.name = ros::this_node::getName().substr(1) + ": " + name;
  status.message = report.message();
  status.hardware_id = name;
  for (const auto& [key, value] : report.values()) {
    diagnostic_msgs::KeyValue entry;
    entry.key = key;
    entry.value = value;
    status.values.push_back(entry);
  }
  return status;
}

} // namespace pcl_ext_ros1
