#include "pcl_ext_ros/simulated_cell.hpp"

#include "parameter_tables.h"
#include "simulator/robot_cell.h"
#include "weak_callback.h"

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <pcl_ext_point_cloud_transport/node_parameters.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <sensor_msgs/point_cloud2_iterator.hpp>
#include <tf2_eigen/tf2_eigen.hpp>
#include <tf2_ros/static_transform_broadcaster.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace pcl_ext_ros {

using pcl_ext_point_cloud_transport::NodeParameters;
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
               cellParameters(),
               NodeParameters::Check(),
               NodeParameters::Listener(),
               NodeParameters::Kind::ReadOnly)
  , frames_(count("frames"))
  , captured_frames_(count("captured_frames"))
  , waits_(valueOf<bool>(constants_.values(), "wait_for_subscribers"))
  , cell_(count("seed"))
  , broadcaster_(node)
  {
    const pcl_ext::nodes::ParameterValues values = constants_.values();
    for (const double sensor : valueOf<std::vector<double>>(values, "sensors"))
      sensors_.push_back(static_cast<unsigned int>(std::lround(sensor)));
    rclcpp::PublisherOptions options;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    for (const unsigned int sensor : sensors_)
      clouds_.push_back(node.create_publisher<PointCloud2>(
          frameOf(sensor) + "/points", rclcpp::SensorDataQoS(), options));
    sendTransforms();
    for (std::uint32_t frame = 0; frame < captured_frames_; ++frame)
      for (const unsigned int sensor : sensors_)
        captured_.push_back(capture(sensor, frame));
  }

  void
  connect(rclcpp::Node& node)
  {
    timer_ =
        node.create_wall_timer(std::chrono::duration<double>(
                                   1.0 / valueOf<double>(constants_.values(), "rate")),
                               weakCallback(weak_from_this(), &Implementation::send));
  }

private:
  std::uint32_t
  count(const std::string& name) const
  {
    return static_cast<std::uint32_t>(valueOf<std::int64_t>(constants_.values(), name));
  }

  void
  sendTransforms()
  {
    std::vector<geometry_msgs::msg::TransformStamped> transforms;
    for (const unsigned int sensor : sensors_) {
      geometry_msgs::msg::TransformStamped transform =
          tf2::eigenToTransform(cell_.sensorPose(sensor));
      transform.header.stamp = clock_->now();
      transform.header.frame_id = withoutLeadingSlash(
          valueOf<std::string>(constants_.values(), "global_frame"));
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
    if (waits_ && !allHaveSubscribers())
      return;
    waits_ = false;
    if (frames_ != 0 && frame_ == frames_) {
      timer_->cancel();
      return;
    }
    const rclcpp::Time stamp = clock_->now();
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
      // Capturing takes milliseconds, and a cloud has megabytes.
      if (clouds_[i]->get_subscription_count() == 0)
        continue;
      auto cloud = std::make_unique<PointCloud2>(
          captured_frames_ == 0
              ? capture(sensors_[i], frame_)
              : captured_[frame_ % captured_frames_ * clouds_.size() + i]);
      cloud->header.stamp = stamp;
      clouds_[i]->publish(std::move(cloud));
    }
    ++frame_;
  }

  rclcpp::Clock::SharedPtr clock_;
  NodeParameters constants_;
  const std::uint32_t frames_;          // 0: no limit
  const std::uint32_t captured_frames_; // 0: each frame is captured when it is sent
  bool waits_;                          // for subscribers
  std::vector<unsigned int> sensors_;
  pcl_ext::cell::RobotCell cell_;
  pcl_ext::cell::CellFrame captured_frame_;
  std::vector<PointCloud2> captured_; // by frame, then by sensor
  std::uint32_t frame_ = 0;           // that comes next
  std::vector<rclcpp::Publisher<PointCloud2>::SharedPtr> clouds_; // as sensors_
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
