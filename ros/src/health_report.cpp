#include "health_report.h"

#include <diagnostic_msgs/KeyValue.h>
#include <ros/this_node.h>

namespace pcl_ext_ros {

using diagnostic_msgs::DiagnosticStatus;

HealthReport::HealthReport(const std::string& name)
{
  status_.level = DiagnosticStatus::OK;
  status_.name = ros::this_node::getName().substr(1) + ": " + name;
  status_.message = "OK";
  status_.hardware_id = name;
}

void
HealthReport::raise(std::uint8_t level, const std::string& message)
{
  if (level <= status_.level)
    return;
  status_.level = level;
  status_.message = message;
}

void
HealthReport::checkArrival(const std::string& what, const ros::WallTime& last_arrival)
{
  const ros::WallDuration silence(2.0);
  if (last_arrival.isZero())
    raise(DiagnosticStatus::STALE, "No " + what + " have arrived yet");
  else if (ros::WallTime::now() - last_arrival > silence)
    raise(DiagnosticStatus::ERROR, "No " + what + " arrive");
}

void
HealthReport::addRates(const pcl_ext::nodes::StreamRates& rates)
{
  constexpr double milliseconds = 1e3; // per second
  add("frames per second", rates.frames_per_second);
  add("bytes per second", rates.bytes_per_second);
  add("mean cycle time, ms", milliseconds * rates.mean_cycle_seconds);
  add("max cycle time, ms", milliseconds * rates.max_cycle_seconds);
  add("mean latency, ms", milliseconds * rates.mean_latency_seconds);
  add("max latency, ms", milliseconds * rates.max_latency_seconds);
}

void
HealthReport::addText(const std::string& key, const std::string& value)
{
  diagnostic_msgs::KeyValue entry;
  entry.key = key;
  entry.value = value;
  status_.values.push_back(entry);
}

} // namespace pcl_ext_ros
