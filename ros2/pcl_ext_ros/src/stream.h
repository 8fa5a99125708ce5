// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/impl/merging_centre.h>
#include <pcl_ext/nodes/impl/node_parameters.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <pcl_ext_ros_common/node_parameters.hpp>
#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_msgs/msg/empty.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief One stream of the central node: its topics and its parameters. Thread-safe
 * after connect(). */
class Stream : public std::enable_shared_from_this<Stream> {
public:
  using FrameMessage = point_cloud_interfaces::msg::CompressedPointCloud2;
  using Receive = std::function<void(Stream&, FrameMessage)>;

  /** \brief Creates the publishers of the stream.
   * \param[in] node that publishes
   * \param[in] name of the stream as `streams` has it, from which its parameters have
   * their names
   * \param[in] topic the resolved name; that of the stream in the centre
   * \param[in] centre that decodes the stream
   */
  Stream(rclcpp::Node& node,
         const std::string& name,
         const std::string& topic,
         std::shared_ptr<pcl_ext::nodes::MergingCentre> centre);

  /** \brief Declares the parameters of noise in the stream and subscribes to it.
   * \param[in] node as above
   * \param[in] receive called with each frame, while the stream exists
   */
  void
  connect(rclcpp::Node& node, Receive receive);

  /** \brief Subscribes to what the stream is merged of, once another centre publishes
   * that. */
  void
  findSources(rclcpp::Node& node);

  const std::string&
  topic() const
  {
    return topic_;
  }

  /** \brief Empty: the map takes no rays from this stream. */
  const std::string&
  sensorFrame() const
  {
    return sensor_frame_;
  }

  void
  requestIFrame()
  {
    i_frame_requests_->publish(std_msgs::msg::Empty());
  }

  rclcpp::Publisher<sensor_msgs::msg::PointCloud2>&
  voxels()
  {
    return *voxels_;
  }

  /** \brief How many nodes publish the stream. */
  std::size_t
  publishers() const
  {
    return frames_->get_publisher_count();
  }

private:
  void
  setNoise(const pcl_ext::nodes::ParameterValues& values);

  void
  receiveSources(std::unique_ptr<diagnostic_msgs::msg::DiagnosticArray> message);

  const std::string name_;
  const std::string topic_;
  const std::shared_ptr<pcl_ext::nodes::MergingCentre> centre_;
  std::string sensor_frame_;

  std::optional<pcl_ext_ros_common::NodeParameters> constants_;
  std::optional<pcl_ext_ros_common::NodeParameters> noise_;
  rclcpp::Publisher<sensor_msgs::msg::PointCloud2>::SharedPtr voxels_;
  rclcpp::Publisher<std_msgs::msg::Empty>::SharedPtr i_frame_requests_;
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Subscription<FrameMessage>::SharedPtr frames_;
  rclcpp::Subscription<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr sources_;
};

} // namespace pcl_ext_ros
