#pragma once

#include <pcl_ext/nodes/health_report.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <rclcpp/node.hpp>
#include <rclcpp/timer.hpp>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext_point_cloud_transport {

/** \brief A report as an entry of /diagnostics.
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
   */
  HealthPublisher(rclcpp::Node& node, std::function<std::vector<Entry>()> describe);

private:
  rclcpp::TimerBase::SharedPtr timer_;
};

} // namespace pcl_ext_point_cloud_transport
