// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pcl_ext_ros_common/node_interfaces.hpp"

#include <rclcpp/expand_topic_or_service_name.hpp>

#include <algorithm>
#include <string>

namespace pcl_ext_ros_common {

/** \brief Name of the transport, at the end of its topics. */
inline constexpr const char* transport_name = "pcl_ext";

/** \brief Topic on which receivers request I-frames. */
inline std::string
requestTopic(const std::string& topic)
{
  return topic + "/request_i_frame";
}

/** \brief What goes before the names of a topic's parameters: the topic within the
 * node's namespace, with dots, as point_cloud_transport has it. It does not change where
 * the topic is remapped.
 * \param[in] node whose parameters they are
 * \param[in] name of the topic as the program has it, as "input" or "/camera/points"
 */
inline std::string
parameterPrefix(NodeInterfaces node, const std::string& name)
{
  const auto base = node.get_node_base_interface();
  const std::string space = base->get_namespace();
  const std::string topic = rclcpp::expand_topic_or_service_name(
      name, base->get_name(), base->get_namespace());
  const bool is_within = topic.compare(0, space.size(), space) == 0 &&
                         (space.back() == '/' || topic[space.size()] == '/');
  std::string prefix = topic.substr(is_within ? space.size() : 0);
  prefix.erase(0, prefix.find_first_not_of('/'));
  std::replace(prefix.begin(), prefix.end(), '/', '.');
  return prefix + ".";
}

} // namespace pcl_ext_ros_common
