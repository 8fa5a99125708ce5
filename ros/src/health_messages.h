#pragma once

#include <pcl_ext/nodes/health_report.h>

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <string>

namespace pcl_ext_ros1 {

/** \brief A warning is repeated at most this often. */
constexpr double seconds_between_warnings = 5.0;

/** \brief One entry of /diagnostics.
 * \param[in] name what it is about; the node's name is put before it
 * \param[in] report its content
 */
diagnostic_msgs::DiagnosticStatus
toMessage(const std::string& name, const pcl_ext::nodes::HealthReport& report);

} // namespace pcl_ext_ros1
