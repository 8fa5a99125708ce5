#pragma once

#include <rclcpp/node.hpp>

#include <algorithm>
#include <string>

namespace pcl_ext_point_cloud_transport {

/** \brief Name of the transport, at the end of its topics. */
inline constexpr const char* transport_name = "pcl_ext";

/** \brief Topic on which receivers request I-frames. */
inline std::string
requestTopic(const std::string& topic)
{
  return topic + "/request_i_frame";
}

/** \brief What goes before the names of a topic's parameters: the topic within the
 * node's namespace, with dots, as point_cloud_transport has it. */
inline std::string
parameterPrefix(const rclcpp::Node& node, const std::string& topic)
{
  const std::string space = node.get_effective_namespace();
  const bool is_within = topic.compare(0, space.size(), space) == 0 &&
                         (space.back() == '/' || topic[space.size()] == '/');
  std::string prefix = topic.substr(is_within ? space.size() : 0);
  prefix.erase(0, prefix.find_first_not_of('/'));
  std::replace(prefix.begin(), prefix.end(), '/', '.');
  return prefix + ".";
}

} // namespace pcl_ext_point_cloud_transport
