#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <ros/time.h>

#include <cstdint>
#include <sstream>
#include <string>

namespace pcl_ext_ros {

/** \brief A warning is repeated at most this often. */
constexpr double seconds_between_warnings = 5.0;

/** \brief One entry of /diagnostics. */
class HealthReport {
public:
  /** \brief An entry of level OK.
   * \param[in] name what the entry is about; the node's name is put before it
   */
  explicit HealthReport(const std::string& name);

  /** \brief Sets level and message, unless the level is as high already.
   * \param[in] level of diagnostic_msgs::DiagnosticStatus
   * \param[in] message one sentence
   */
  void
  raise(std::uint8_t level, const std::string& message);

  /** \brief Raises the level if nothing arrived, or nothing within the last two seconds.
   * \param[in] what arrives, in the plural
   * \param[in] last_arrival zero: nothing arrived yet
   */
  void
  checkArrival(const std::string& what, const ros::WallTime& last_arrival);

  template <typename ValueT>
  void
  add(const std::string& key, const ValueT& value)
  {
    std::ostringstream text;
    text << value;
    addText(key, text.str());
  }

  /** \brief Adds rate, bandwidth, cycle time and latency. */
  void
  addRates(const pcl_ext::nodes::StreamRates& rates);

  const diagnostic_msgs::DiagnosticStatus&
  status() const
  {
    return status_;
  }

private:
  void
  addText(const std::string& key, const std::string& value);

  diagnostic_msgs::DiagnosticStatus status_;
};

} // namespace pcl_ext_ros
