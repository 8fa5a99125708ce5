// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pcl_ext_point_cloud_transport/transport_interface.hpp"

#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <point_cloud_transport/simple_publisher_plugin.hpp>

#include <memory>
#include <string>

namespace pcl_ext_point_cloud_transport {

/** \brief Publishes clouds as compressed voxels with intensity, on `<base
 * topic>/pcl_ext`. doc/nodes.md has the parameters. The stream's history is that of the
 * instance. */
class Publisher : public point_cloud_transport::SimplePublisherPlugin<
                      point_cloud_interfaces::msg::CompressedPointCloud2> {
public:
  using SimplePublisherPlugin::publish;

  Publisher();
  ~Publisher() override;

  std::string
  getTransportName() const override;

  std::string
  getDataType() const override;

  /** \brief Nothing to do: advertiseImpl() declares the parameters. */
  void
  declareParameters(const std::string& base_topic) override;

  /** \brief Encodes the next cloud of the stream; also without a node, with the
   * defaults. */
  TypedEncodeResult
  encodeTyped(const sensor_msgs::msg::PointCloud2& raw) const override;

  void
  shutdown() override;

protected:
  void
  advertiseImpl(TransportNode node,
                const std::string& base_topic,
                TransportQos custom_qos,
                const rclcpp::PublisherOptions& options) override;

  /** \brief Publishes a cloud; a cloud that is refused is logged, but not each time. */
  void
  publish(const sensor_msgs::msg::PointCloud2& message,
          const PublishFn& publish_fn) const override;

private:
  class Stream;
  std::shared_ptr<Stream> stream_; // callbacks of the node may outlive the instance
};

} // namespace pcl_ext_point_cloud_transport
