// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>

namespace pcl_ext_ros_common {

/** \brief Whether a class of tf2_ros takes the interfaces of a node, as since ROS 2
 * Lyrical. */
template <typename TfT, typename = void>
struct TakesInterfaces : std::false_type {};

template <typename TfT>
struct TakesInterfaces<TfT, std::void_t<typename TfT::RequiredInterfaces>>
: std::true_type {};

/** \brief A node as a class of tf2_ros takes it: itself, from which interfaces are
 * made, or a pointer.
 * \tparam TfT tf2_ros::TransformListener or a broadcaster
 */
template <typename TfT, typename NodeT>
decltype(auto)
tfNode(NodeT& node)
{
  if constexpr (TakesInterfaces<TfT>::value)
    return (node);
  else
    return &node;
}

} // namespace pcl_ext_ros_common
