// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pcl_ext_point_cloud_transport/transport_interface.hpp"

#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <point_cloud_transport/simple_subscriber_plugin.hpp>

#include <cstdint>
#include <memory>
#include <string>

namespace pcl_ext_point_cloud_transport {

/** \brief Decompresses the voxels of `<base topic>/pcl_ext` to clouds of their centres.
 * doc/nodes.md has the parameters.
 *
 * Each publisher of the topic has a decoder of its own. Where a frame was lost no cloud
 * is delivered until the next I-frame, which is requested on `<base
 * topic>/pcl_ext/request_i_frame`.
 */
class Subscriber : public point_cloud_transport::SimpleSubscriberPlugin<
                       point_cloud_interfaces::msg::CompressedPointCloud2> {
public:
  Subscriber();
  ~Subscriber() override;

  std::string
  getTransportName() const override;

  std::string
  getDataType() const override;

  std::string
  getTopic() const override;

  std::uint32_t
  getNumPublishers() const override;

  // Not marked as an override, as only version 4.0.7 and later have it to override.
  virtual rclcpp::SubscriptionBase::SharedPtr
  getSubscription() const;

  void
  shutdown() override;

  /** \brief Nothing to do: subscribeImpl() declares the parameters. */
  void
  declareParameters() override;

  /** \brief Decodes the next frame of one stream; also without a node, with the
   * defaults. */
  DecodeResult
  decodeTyped(const point_cloud_interfaces::msg::CompressedPointCloud2& compressed)
      const override;

protected:
  void
  subscribeImpl(TransportNode node,
                const std::string& base_topic,
                const Callback& callback,
                TransportQos custom_qos) override;

  void
  subscribeImpl(TransportNode node,
                const std::string& base_topic,
                const Callback& callback,
                TransportQos custom_qos,
                rclcpp::SubscriptionOptions options) override;

private:
  class Streams;
  std::shared_ptr<Streams> streams_; // callbacks of the node may outlive the instance
};

} // namespace pcl_ext_point_cloud_transport
