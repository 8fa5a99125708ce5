#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/duration.h>

#include <cstdint>
#include <string>

namespace pcl_ext_ros {

/** \brief A stream of which nothing arrives for longer is reported as an error. */
inline const ros::WallDuration silence(2.0);

/** \brief One entry of /diagnostics while it is written. */
class HealthReport {
public:
  /** \brief An entry that says OK.
   * \param[in] name of what it is about; the node's name is put before it
   */
  explicit HealthReport(const std::string& name);

  /** \brief Makes the entry as bad as this, unless it is worse already.
   * \param[in] level of diagnostic_msgs::DiagnosticStatus
   * \param[in] message one sentence
   */
  void
  raise(std::uint8_t level, const std::string& message);

  void
  add(const std::string& key, const std::string& value);
  void
  add(const std::string& key, double value);
  void
  add(const std::string& key, std::uint64_t value);

  /** \brief Adds rate, bandwidth, cycle time and latency. */
  void
  add(const pcl_ext::nodes::StreamRates& rates);

  const diagnostic_msgs::DiagnosticStatus&
  status() const
  {
    return status_;
  }

private:
  diagnostic_msgs::DiagnosticStatus status_;
};

} // namespace pcl_ext_ros
