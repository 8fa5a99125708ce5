// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/transform_search.h>

#include <std_msgs/Header.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <string>

namespace pcl_ext_ros1 {

/** \brief Looks up transforms to the global frame. TF messages are received by a
 * separate thread. */
class TransformLookup {
public:
  /** \brief Starts to listen.
   * \param[in] global_frame without a leading slash
   * \param[in] timeout seconds after its stamp for which a transform is waited for
   */
  TransformLookup(std::string global_frame, double timeout);

  /** \brief The transform at a stamp, else the latest, else none. That of the global
   * frame is the identity.
   * \param[in] header stamp and frame
   */
  pcl_ext::nodes::FoundTransform
  toGlobalFrame(const std_msgs::Header& header) const;

private:
  std::string global_frame_;
  pcl_ext::nodes::Time timeout_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_{buffer_};
};

} // namespace pcl_ext_ros1
