// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/merging_centre.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <point_cloud_transport/point_cloud_transport.hpp>
#include <rclcpp/rclcpp.hpp>

#include <string>

namespace pcl_ext_ros {

/** \brief Publishes merged voxels on ~/merged and by all transports that are installed,
 * and what they are merged of on ~/merged/streams. Thread-safe. */
class MergedOutput {
public:
  /** \param[in] node that publishes; must outlive this
   * \param[in] frame_id of the voxels
   * \param[in] resolution of the merged grid, metres: the default of the transport
   * pcl_ext
   */
  MergedOutput(rclcpp::Node& node, std::string frame_id, double resolution);

  /** \brief Whether anybody wants merged voxels, by any transport, or what they are of.
   */
  bool
  hasSubscribers() const
  {
    return voxels_.getNumSubscribers() != 0 || sources_->get_subscription_count() != 0;
  }

  /** \brief Publishes the sources of a merged frame, and then its voxels. */
  void
  publish(const pcl_ext::nodes::MergedFrame& merged);

private:
  const std::string node_; // its name without the first slash
  const std::string frame_id_;
  const rclcpp::Clock::SharedPtr clock_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr sources_;
  point_cloud_transport::Publisher voxels_;
};

} // namespace pcl_ext_ros
