// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_ros/simulated_cell.hpp"

#include "simulator/cell_parameters.h"
#include "simulator/robot_cell.h"
#include "weak_callback.h"

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <pcl_ext_ros_common/node_parameters.hpp>
#include <pcl_ext_ros_common/tf_node.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <sensor_msgs/point_cloud2_iterator.hpp>
#include <tf2_eigen/tf2_eigen.hpp>
#include <tf2_ros/static_transform_broadcaster.hpp>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>
#include <vector>

namespace pcl_ext_ros {

using pcl_ext_ros_common::NodeParameters;
using sensor_msgs::msg::PointCloud2;

namespace {

std::string
frameOf(unsigned int sensor)
{
  return "kinect_" + std::to_string(sensor);
}

} // namespace

/** \brief Sends the clouds of all sensors of a frame with the same stamp. */
class SimulatedCell::Implementation
: public std::enable_shared_from_this<SimulatedCell::Implementation> {
public:
  explicit Implementation(rclcpp::Node& node)
  : clock_(node.get_clock())
  , constants_(node,
               "",
               pcl_ext::cell::cellParameters(),
               NodeParameters::Check(),
               NodeParameters::Listener(),
               NodeParameters::Kind::ReadOnly)
  , settings_(pcl_ext::cell::readCellParameters(constants_.values()))
  , cell_(settings_.seed)
  , broadcaster_(pcl_ext_ros_common::tfNode<tf2_ros::StaticTransformBroadcaster>(node))
  {
    rclcpp::PublisherOptions options;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    for (const unsigned int sensor : settings_.sensors)
      clouds_.push_back(node.create_publisher<PointCloud2>(
          frameOf(sensor) + "/points", rclcpp::SensorDataQoS(), options));
    sendTransforms();
    for (std::uint32_t frame = 0; frame < settings_.captured_frames; ++frame)
      for (const unsigned int sensor : settings_.sensors)
        captured_.push_back(capture(sensor, frame));
  }

  void
  connect(rclcpp::Node& node)
  {
    timer_ =
        node.create_wall_timer(std::chrono::duration<double>(1.0 / settings_.rate),
                               weakCallback(weak_from_this(), &Implementation::send));
  }

private:
  void
  sendTransforms()
  {
    std::vector<geometry_msgs::msg::TransformStamped> transforms;
    for (const unsigned int sensor : settings_.sensors) {
      geometry_msgs::msg::TransformStamped transform =
          tf2::eigenToTransform(cell_.sensorPose(sensor));
      transform.header.stamp = clock_->now();
      transform.header.frame_id = settings_.global_frame;
      transform.child_frame_id = frameOf(sensor);
      transforms.push_back(transform);
    }
    broadcaster_.sendTransform(transforms);
  }

  bool
  allHaveSubscribers() const
  {
    return std::all_of(clouds_.begin(), clouds_.end(), [](const auto& publisher) {
      return publisher->get_subscription_count() != 0;
    });
  }

  PointCloud2
  capture(unsigned int sensor, std::uint32_t frame)
  {
    cell_.capture(sensor, frame, captured_frame_);
    const auto& points = captured_frame_.cloud;
    PointCloud2 message;
    message.height = points.height;
    message.width = points.width;
    sensor_msgs::PointCloud2Modifier(message).setPointCloud2FieldsByString(1, "xyz");
    message.row_step = message.width * message.point_step;
    static_assert(sizeof(pcl::PointXYZ) == 16, "the layout of the message");
    message.data.resize(std::size_t{message.height} * message.row_step);
    std::memcpy(message.data.data(), points.points.data(), message.data.size());
    message.is_dense = false;
    message.header.frame_id = frameOf(sensor);
    return message;
  }

  void
  send()
  {
    if (settings_.waits_for_subscribers && !allHaveSubscribers())
      return;
    settings_.waits_for_subscribers = false;
    if (settings_.frames != 0 && frame_ == settings_.frames) {
      timer_->cancel();
      return;
    }
    const rclcpp::Time stamp = clock_->now();
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
      // Capturing takes milliseconds, and a cloud has megabytes.
      if (clouds_[i]->get_subscription_count() == 0)
        continue;
      auto cloud = std::make_unique<PointCloud2>(
          settings_.captured_frames == 0
              ? capture(settings_.sensors[i], frame_)
              : captured_[frame_ % settings_.captured_frames * clouds_.size() + i]);
      cloud->header.stamp = stamp;
      clouds_[i]->publish(std::move(cloud));
    }
    ++frame_;
  }

  rclcpp::Clock::SharedPtr clock_;
  NodeParameters constants_;
  pcl_ext::cell::CellSettings settings_;
  pcl_ext::cell::RobotCell cell_;
  pcl_ext::cell::CellFrame captured_frame_;
  std::vector<PointCloud2> captured_; // by frame, then by sensor
  std::uint32_t frame_ = 0;           // that comes next
  std::vector<rclcpp::Publisher<PointCloud2>::SharedPtr>
      clouds_; // as settings_.sensors
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  rclcpp::TimerBase::SharedPtr timer_;
};

SimulatedCell::SimulatedCell(const rclcpp::NodeOptions& options)
: rclcpp::Node("simulated_cell", options)
, implementation_(std::make_shared<Implementation>(*this))
{
  implementation_->connect(*this);
}

SimulatedCell::~SimulatedCell() = default;

} // namespace pcl_ext_ros

RCLCPP_COMPONENTS_REGISTER_NODE(pcl_ext_ros::SimulatedCell)
