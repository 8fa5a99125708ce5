// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rclcpp/node.hpp>

#include <memory>

namespace pcl_ext_ros {

/** \brief The node of the central computer: compressed frames of many streams in; voxels
 * without noise of each stream, merged voxels and a map out. doc/nodes.md has its topics,
 * services and parameters. */
class MergingCentreNode : public rclcpp::Node {
public:
  /** \brief A wrong value of `streams` is reported, and the node then has no stream. */
  explicit MergingCentreNode(const rclcpp::NodeOptions& options);

  /** \brief Waits until all frames are decoded, and writes the map, if it is to be. */
  ~MergingCentreNode() override;

private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_; // callbacks may outlive the node
};

} // namespace pcl_ext_ros
