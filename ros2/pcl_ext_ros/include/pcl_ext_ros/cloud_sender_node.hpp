// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rclcpp/node.hpp>

#include <memory>

namespace pcl_ext_ros {

/** \brief The node of a sensor: clouds in, compressed frames out. doc/nodes.md has its
 * topics, services and parameters. */
class CloudSenderNode : public rclcpp::Node {
public:
  explicit CloudSenderNode(const rclcpp::NodeOptions& options);
  ~CloudSenderNode() override;

private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_; // callbacks may outlive the node
};

} // namespace pcl_ext_ros
