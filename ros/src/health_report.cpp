#include "health_report.h"

#include <diagnostic_msgs/KeyValue.h>
#include <ros/this_node.h>

#include <sstream>

namespace pcl_ext_ros {

HealthReport::HealthReport(const std::string& name)
{
  status_.level = diagnostic_msgs::DiagnosticStatus::OK;
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
HealthReport::add(const std::string& key, const std::string& value)
{
  diagnostic_msgs::KeyValue entry;
  entry.key = key;
  entry.value = value;
  status_.values.push_back(entry);
}

void
HealthReport::add(const std::string& key, double value)
{
  std::ostringstream text;
  text << value;
  add(key, text.str());
}

void
HealthReport::add(const std::string& key, std::uint64_t value)
{
  add(key, std::to_string(value));
}

void
HealthReport::add(const pcl_ext::nodes::StreamRates& rates)
{
  constexpr double milliseconds = 1e3; // in a second
  add("frames per second", rates.frames_per_second);
  add("bytes per second", rates.bytes_per_second);
  add("mean cycle time, ms", milliseconds * rates.mean_cycle_seconds);
  add("max cycle time, ms", milliseconds * rates.max_cycle_seconds);
  add("mean latency, ms", milliseconds * rates.mean_latency_seconds);
  add("max latency, ms", milliseconds * rates.max_latency_seconds);
}

} // namespace pcl_ext_ros
