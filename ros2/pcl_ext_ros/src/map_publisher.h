// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/header.hpp>

#include <memory>
#include <utility>

#if PCL_EXT_ROS_HAS_OCTOMAP_MSGS
#include <octomap_msgs/conversions.h>
#include <octomap_msgs/msg/octomap.hpp>
#endif

namespace pcl_ext_ros {

#if PCL_EXT_ROS_HAS_OCTOMAP_MSGS

/** \brief Publishes a map with its occupancies on ~/map; those who come late get the
 * last one. */
class MapPublisher {
public:
  explicit MapPublisher(rclcpp::Node& node)
  {
    rclcpp::PublisherOptions options;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    publisher_ = node.create_publisher<octomap_msgs::msg::Octomap>(
        "~/map", rclcpp::QoS(1).transient_local(), options);
  }

  bool
  hasSubscribers() const
  {
    return publisher_->get_subscription_count() != 0;
  }

  void
  publish(const std_msgs::msg::Header& header, const octomap::OcTree& tree)
  {
    auto message = std::make_unique<octomap_msgs::msg::Octomap>();
    message->header = header;
    if (octomap_msgs::fullMapToMsg(tree, *message))
      publisher_->publish(std::move(message));
  }

private:
  rclcpp::Publisher<octomap_msgs::msg::Octomap>::SharedPtr publisher_;
};

#else

/** \brief Where octomap_msgs is not installed, the map is not published. */
class MapPublisher {
public:
  explicit MapPublisher(rclcpp::Node&) {}

  bool
  hasSubscribers() const
  {
    return false;
  }

  void
  publish(const std_msgs::msg::Header&, const octomap::OcTree&)
  {}
};

#endif

} // namespace pcl_ext_ros
