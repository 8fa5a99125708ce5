// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The plugins in nodes that are no rclcpp::Node.
 */
#include "plugin_test.h"

#include <rclcpp_lifecycle/lifecycle_node.hpp>

namespace pcl_ext_point_cloud_transport::test {

namespace {

TEST(LifecycleNodes, PublishAndSubscribe)
{
  const auto node = std::make_shared<rclcpp_lifecycle::LifecycleNode>(
      "both",
      spaceOfThisTest(),
      rclcpp::NodeOptions().parameter_overrides(
          {{"points.enable_pub_plugins",
            std::vector<std::string>{"point_cloud_transport/pcl_ext"}},
           {points("resolution"), 0.05}}));
  Recorder<Cloud> clouds;
  point_cloud_transport::PointCloudTransport transport{NodeInterfaces(*node)};
  const auto hints = hintsOfPlugin();
  const auto subscriber = transport.subscribe(
      "points",
      reliable(),
      [&clouds](const Cloud::ConstSharedPtr& cloud) { clouds.add(cloud); },
      {},
      &hints);
  const auto publisher = transport.advertise("points", reliable());
  SpunNode observer("observer");
  const Diagnostics health(*observer.node, "both");
  rclcpp::executors::SingleThreadedExecutor executor;
  executor.add_node(node->get_node_base_interface());
  const auto spin_until = [&executor](const std::function<bool()>& condition) {
    return waitFor([&] {
      executor.spin_some();
      return condition();
    });
  };
  ASSERT_TRUE(spin_until([&] {
    return publisher.getNumSubscribers() == 1 && subscriber.getNumPublishers() == 1;
  }));
  const Cloud cloud = makeCloud(0);
  publisher.publish(cloud);
  ASSERT_TRUE(spin_until([&] { return clouds.count() == 1; }));
  auto settings = defaultSettings();
  settings.crop_box.reset();
  settings.compression.resolution = 0.05;
  EXPECT_TRUE(voxelsIn(*clouds.messages().front()) == directVoxels(cloud, settings));
  EXPECT_TRUE(spin_until([&] { return !health.entries().empty(); }));
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
