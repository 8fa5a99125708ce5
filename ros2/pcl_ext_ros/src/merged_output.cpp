// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "merged_output.h"

#include <pcl_ext/nodes/impl/cloud_messages.h>
#include <pcl_ext/nodes/impl/merged_source.h>

#include <pcl_ext_ros_common/health_publisher.hpp>
#include <pcl_ext_ros_common/transport_topic.hpp>

#include <memory>
#include <type_traits>
#include <utility>

namespace pcl_ext_ros {

using diagnostic_msgs::msg::DiagnosticArray;
using sensor_msgs::msg::PointCloud2;

namespace {

const char* const topic = "~/merged";
constexpr std::size_t queue_size = 10;

/** \brief Declares parameters of the transport pcl_ext before it does, so that by
 * default it keeps voxels and colours as they are; users may set others. */
void
declareTransportParameters(rclcpp::Node& node, double resolution)
{
  const std::string prefix = pcl_ext_ros_common::parameterPrefix(
      node, std::string(topic) + "/" + pcl_ext_ros_common::transport_name);
  rcl_interfaces::msg::ParameterDescriptor descriptor; // the transport describes them
  descriptor.dynamic_typing = true;
  constexpr std::int64_t all_bits = 8;
  node.declare_parameter(
      prefix + "resolution", rclcpp::ParameterValue(resolution), descriptor);
  node.declare_parameter(
      prefix + "colour_bits", rclcpp::ParameterValue(all_bits), descriptor);
}

/** \brief Until ROS 2 Kilted point_cloud_transport takes a shared node and the
 * middleware's QoS.
 * \tparam NodeT rclcpp::Node: of both ways only that which there is is compiled
 */
template <typename NodeT>
point_cloud_transport::Publisher
createPublisher(NodeT& node)
{
  const rclcpp::QoS qos(queue_size);
  rclcpp::PublisherOptions options;
  options.qos_overriding_options =
      rclcpp::QosOverridingOptions::with_default_policies();
  if constexpr (std::is_constructible_v<point_cloud_transport::PointCloudTransport,
                                        pcl_ext_ros_common::NodeInterfaces>) {
    return point_cloud_transport::create_publisher(node, topic, qos, options);
  }
  else {
    // It does not outlive the node, whose constructor calls this.
    const std::shared_ptr<NodeT> not_owned(&node, [](NodeT*) {});
    return point_cloud_transport::create_publisher(
        not_owned, topic, qos.get_rmw_qos_profile(), options);
  }
}

} // namespace

MergedOutput::MergedOutput(rclcpp::Node& node, std::string frame_id, double resolution)
: node_(std::string(node.get_fully_qualified_name()).substr(1))
, frame_id_(std::move(frame_id))
, clock_(node.get_clock())
, sources_(node.create_publisher<DiagnosticArray>(std::string(topic) + "/streams",
                                                  queue_size))
{
  declareTransportParameters(node, resolution);
  voxels_ = createPublisher(node);
}

void
MergedOutput::publish(const pcl_ext::nodes::MergedFrame& merged)
{
  const rclcpp::Time stamp(merged.time.count());
  DiagnosticArray sources;
  sources.header.stamp = stamp;
  sources.header.frame_id = frame_id_;
  const pcl_ext::nodes::Time now(clock_->now().nanoseconds());
  for (const auto& [source, report] :
       pcl_ext::nodes::describeMerged(merged.sources, now))
    sources.status.push_back(pcl_ext_ros_common::toMessage(node_, source, report));
  sources_->publish(sources);
  if (voxels_.getNumSubscribers() == 0)
    return;
  auto message = std::make_shared<PointCloud2>();
  message->header.stamp = stamp;
  message->header.frame_id = frame_id_;
  pcl_ext::nodes::writeVoxels(merged.voxels(), *message);
  voxels_.publish(PointCloud2::ConstSharedPtr(std::move(message)));
}

} // namespace pcl_ext_ros
