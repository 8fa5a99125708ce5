#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/health_report.h>
#include <pcl_ext/nodes/node_parameters.h>

#include <pcl_ext_ros_common/node_parameters.hpp>
#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_msgs/msg/empty.hpp>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief One stream of the central node: its topics, what is noise in it, and what is known
 * of it. Thread-safe after connect() and
 * subscribe(). */
class Stream : public std::enable_shared_from_this<Stream> {
public:
  using FrameMessage = point_cloud_interfaces::msg::CompressedPointCloud2;

  /** \brief Creates the publishers of the stream.
   * \param[in] node that publishes
   * \param[in] topic resolved; the stream's name in the central node
   * \param[in] number in the order of `streams`
   * \param[in] central_node that decodes the stream
   */
  Stream(rclcpp::Node& node,
         const std::string& topic,
         std::size_t number,
         std::shared_ptr<pcl_ext::nodes::CentralNode> central_node);

  /** \brief Declares the parameters of noise in the stream. */
  void
  connect(rclcpp::Node& node);

  /** \brief Subscribes to the stream.
   * \param[in] node that subscribes
   * \param[in] callback takes a std::unique_ptr<FrameMessage>
   */
  template <typename CallbackT>
  void
  subscribe(rclcpp::Node& node, const CallbackT& callback)
  {
    constexpr std::size_t frame_queue_size = 40;
    rclcpp::SubscriptionOptions options;
    options.qos_overriding_options =
        rclcpp::QosOverridingOptions::with_default_policies();
    // Frames of one stream stay in their order; those of others do not wait for them.
    options.callback_group = group_;
    frames_ = node.create_subscription<FrameMessage>(
        topic_, rclcpp::QoS(frame_queue_size), callback, options);
  }

  const std::string&
  topic() const
  {
    return topic_;
  }

  std::size_t
  number() const
  {
    return number_;
  }

  /** \brief Empty: the map takes no rays from this stream. */
  const std::string&
  sensorFrame() const
  {
    return sensor_frame_;
  }

  /** \brief Sets what is noise for all streams: it holds for this one as far as it has no
   * parameter of its own. */
  void
  setNoiseOfAll(const pcl_ext::nodes::ParameterValues& values);

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

  /** \brief A frame arrived. */
  void
  countArrival()
  {
    last_arrival_ = pcl_ext::nodes::steadyTime().count();
  }

  /** \brief A frame was not passed on, as it has another frame id or format. */
  void
  countLeftOut()
  {
    ++left_out_;
  }

  /** \brief Describes the stream. Called by one thread at a time, after subscribe().
   * \param[in] health that of the central node
   * \param[in] merged_resolution as of ReceiverHealth
   */
  pcl_ext::nodes::HealthReport
  describeHealth(const pcl_ext::nodes::StreamHealth& health, double merged_resolution);

private:
  void
  setOwnNoise(const pcl_ext::nodes::ParameterValues& values);

  /** \brief Passes what has changed on to the central node. The mutex is locked. */
  void
  updateNoise();

  const std::string topic_;
  const std::size_t number_;
  const std::shared_ptr<pcl_ext::nodes::CentralNode> central_node_;
  std::string sensor_frame_;

  mutable std::mutex mutex_; // guards what is noise
  pcl_ext::nodes::ParameterValues noise_of_all_;
  pcl_ext::nodes::ParameterValues own_noise_;
  pcl_ext::nodes::ParameterValues noise_; // that of the central node; empty at first

  std::atomic<pcl_ext::nodes::Time::rep> last_arrival_{0}; // steady clock; 0: none
  std::atomic<std::size_t> left_out_{0};
  pcl_ext::nodes::ReceiverHealth reported_; // by describeHealth()

  rclcpp::node_interfaces::NodeGraphInterface::SharedPtr graph_;
  std::optional<pcl_ext_ros_common::NodeParameters> constants_;
  std::optional<pcl_ext_ros_common::NodeParameters> parameters_;
  rclcpp::Publisher<sensor_msgs::msg::PointCloud2>::SharedPtr voxels_;
  rclcpp::Publisher<std_msgs::msg::Empty>::SharedPtr i_frame_requests_;
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Subscription<FrameMessage>::SharedPtr frames_;
};

} // namespace pcl_ext_ros
