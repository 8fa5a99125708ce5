// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rclcpp/node.hpp>

#include <memory>

namespace pcl_ext_ros {

/** \brief Brings streams of ROS to a site's NATS server, and those of the site into ROS.
 * README.md of this package has the parameters. */
class SiteLink : public rclcpp::Node {
public:
  /** \throws std::invalid_argument if a parameter of the site is wrong, or a topic is of
   * `to_site` and of `from_site` */
  explicit SiteLink(const rclcpp::NodeOptions& options);
  ~SiteLink() override;

private:
  class Implementation;
  std::shared_ptr<Implementation> implementation_; // callbacks may outlive the node
};

} // namespace pcl_ext_ros
