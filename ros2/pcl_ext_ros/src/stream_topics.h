// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rclcpp/rclcpp.hpp>

#include <functional>
#include <map>
#include <string>

namespace pcl_ext_ros {

/** \brief The parameter `streams`: topics, which may be changed while the node runs. */
class StreamTopics {
public:
  /** \brief Resolved topics, and what they are called in `streams`. */
  using Topics = std::map<std::string, std::string>;

  /** \brief Declares the parameter. A value that is wrong at the start is that of
   * fault(), and there are no topics; one that is set later is refused with the reason.
   * \param[in] node whose parameter it is; must outlive this
   * \param[in] on_change called with other topics than before, after they were set
   */
  StreamTopics(rclcpp::Node& node, std::function<void(Topics)> on_change);

  const Topics&
  initial() const
  {
    return initial_;
  }

  /** \brief What is wrong with the value at the start; empty if nothing. */
  const std::string&
  fault() const
  {
    return fault_;
  }

private:
  Topics initial_;
  std::string fault_;
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr on_set_;
  rclcpp::node_interfaces::PostSetParametersCallbackHandle::SharedPtr post_set_;
};

} // namespace pcl_ext_ros
