// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/transform_search.h>

#include <rclcpp/node.hpp>
#include <std_msgs/msg/header.hpp>
#include <tf2_ros/buffer.hpp>
#include <tf2_ros/transform_listener.hpp>

#include <string>

namespace pcl_ext_ros {

/** \brief Looks up transforms to the global frame. TF messages are received by a
 * separate thread; no lookup waits. */
class TransformLookup {
public:
  /** \brief Starts to listen.
   * \param[in] global_frame without a leading slash
   */
  TransformLookup(rclcpp::Node& node, std::string global_frame);

  /** \brief True if find() has a transform at the stamp. */
  bool
  isKnown(const std_msgs::msg::Header& header) const;

  /** \brief The transform at a stamp, else the latest, else none. That of the global
   * frame is the identity.
   * \param[in] header stamp and frame
   */
  pcl_ext::nodes::FoundTransform
  find(const std_msgs::msg::Header& header) const;

private:
  std::string global_frame_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

} // namespace pcl_ext_ros
