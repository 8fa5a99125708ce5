// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rclcpp/node.hpp>

#include <memory>

namespace pcl_ext_ros {

/** \brief Sends the clouds of the simulated robot cell in real time. doc/nodes.md has
 * the topics and parameters. */
class SimulatedCell : public rclcpp::Node {
public:
  explicit SimulatedCell(const rclcpp::NodeOptions& options);
  ~SimulatedCell() override;

private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_; // callbacks may outlive the node
};

} // namespace pcl_ext_ros
