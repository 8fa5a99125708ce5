// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What plugins get of point_cloud_transport, which differs between releases.
 */
#pragma once

#include <pcl_ext_ros_common/node_interfaces.hpp>
#include <point_cloud_transport/point_cloud_transport.hpp>
#include <rclcpp/clock.hpp>
#include <rclcpp/node.hpp>
#include <rclcpp/qos.hpp>

#include <memory>
#include <type_traits>

namespace pcl_ext_point_cloud_transport {

using pcl_ext_ros_common::NodeInterfaces;

/** \brief False until ROS 2 Kilted: plugins get a node and the middleware's QoS. */
inline constexpr bool has_node_interfaces =
    std::is_constructible_v<point_cloud_transport::PointCloudTransport, NodeInterfaces>;

/** \brief A node and a QoS as plugins get them. */
using TransportNode = std::
    conditional_t<has_node_interfaces, NodeInterfaces, std::shared_ptr<rclcpp::Node>>;
using TransportQos =
    std::conditional_t<has_node_interfaces, rclcpp::QoS, rmw_qos_profile_t>;

inline NodeInterfaces
toInterfaces(const NodeInterfaces& node)
{
  return node;
}

inline NodeInterfaces
toInterfaces(const std::shared_ptr<rclcpp::Node>& node)
{
  return NodeInterfaces(*node);
}

inline rclcpp::QoS
toQos(const rclcpp::QoS& qos)
{
  return qos;
}

inline rclcpp::QoS
toQos(const rmw_qos_profile_t& qos)
{
  return rclcpp::QoS(rclcpp::QoSInitialization::from_rmw(qos), qos);
}

/** \brief A program's node and QoS as point_cloud_transport takes them. */
inline auto
toTransport(const std::shared_ptr<rclcpp::Node>& node)
{
  if constexpr (has_node_interfaces)
    return NodeInterfaces(*node);
  else
    return node;
}

inline auto
toTransport(const rclcpp::QoS& qos)
{
  if constexpr (has_node_interfaces)
    return qos;
  else
    return qos.get_rmw_qos_profile();
}

/** \brief The system's clock, as a node's interfaces have none: stamps in /diagnostics do
 * not follow simulated time. */
inline rclcpp::Clock::SharedPtr
clockOfDiagnostics()
{
  return std::make_shared<rclcpp::Clock>(RCL_SYSTEM_TIME);
}

} // namespace pcl_ext_point_cloud_transport
