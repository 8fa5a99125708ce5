// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Messages and clouds that are invalid.
 */
#include "plugin_test.h"

namespace pcl_ext_point_cloud_transport::test {

namespace {

/** \brief The first frame of a stream, as the plugin sends it. */
Compressed
makeFrame()
{
  pcl_ext::nodes::SensorNode node(defaultSettings());
  const Cloud cloud = makeCloud(0);
  Compressed frame;
  frame.header = cloud.header;
  frame.format = "pcl_ext/version1";
  EXPECT_TRUE(node.encode(toPcl(cloud),
                          pcl_ext::WorldPose(pcl_ext::WorldPose::Identity()),
                          frame.compressed_data)
                  .ok());
  return frame;
}

TEST(Garbage, WhatIsNoFrameOfThisFormatIsCountedAndGivesNoCloud)
{
  Receiver receiver;
  SpunNode attacker("attacker");
  const auto publisher =
      attacker.node->create_publisher<Compressed>("points/pcl_ext", rclcpp::QoS(100));
  ASSERT_TRUE(waitFor([&] { return publisher->get_subscription_count() == 1; }));
  receiver.expectPublishers(1);
  Diagnostics health(*attacker.node, "receiver");
  const Compressed good = makeFrame();
  for (const std::size_t size : {0u, 1u, 3000u}) {
    Compressed frame = good;
    frame.compressed_data.assign(size, 'P');
    publisher->publish(frame);
  }
  for (const char* const format : {"", "draco", "pcl_ext", "pcl_ext/version2"}) {
    Compressed frame = good;
    frame.format = format;
    publisher->publish(frame);
  }
  publisher->publish(good);
  const auto cloud = receiver.clouds.waitForStamp(good.header.stamp);
  ASSERT_TRUE(cloud);
  EXPECT_TRUE(voxelsIn(*cloud) == directVoxels(makeCloud(0), defaultSettings()));
  EXPECT_EQ(receiver.clouds.count(), 1u);
  EXPECT_TRUE(health.waitForEntry([](const Diagnostics::Status& status) {
    return valueOf(status, "frames failed") == 3 &&
           valueOf(status, "frames decoded") == 1 &&
           valueOf(status, "frames of other frame id or format") == 4;
  }));
}

TEST(Garbage, WrongLayoutInTheMessageHasNoEffect)
{
  Receiver receiver;
  SpunNode other("other");
  const auto publisher =
      other.node->create_publisher<Compressed>("points/pcl_ext", rclcpp::QoS(100));
  ASSERT_TRUE(waitFor([&] { return publisher->get_subscription_count() == 1; }));
  receiver.expectPublishers(1);
  Compressed frame = makeFrame();
  frame.width = 4000000000u;
  frame.height = 7;
  frame.point_step = 0;
  frame.row_step = 1;
  frame.is_bigendian = true;
  publisher->publish(frame);
  const auto decoded = receiver.clouds.waitForStamp(frame.header.stamp);
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(voxelsIn(*decoded) == directVoxels(makeCloud(0), defaultSettings()));
}

TEST(Garbage, BrokenCloudsAreRefusedAndReported)
{
  Sender sender;
  Receiver receiver;
  Diagnostics health(receiver.node(), "sender");
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  std::vector<Cloud> broken{makeCloud(0), makeCloud(1)};
  broken[0].data.resize(broken[0].data.size() / 2);
  broken[1].width = broken[1].height = 1u << 31;
  for (const Cloud& cloud : broken)
    sender.publisher.publish(cloud);
  const Cloud good = makeCloud(2);
  expectVoxels(sender, receiver, good, directVoxels(good, defaultSettings()));
  EXPECT_EQ(receiver.clouds.count(), 1u);
  EXPECT_TRUE(health.waitForEntry([](const Diagnostics::Status& status) {
    return valueOf(status, "clouds refused") == 2 &&
           status.level == Diagnostics::Status::ERROR &&
           status.message == "Clouds are refused";
  }));
}

TEST(Garbage, CloudsWithoutPointsGiveCloudsWithoutPoints)
{
  Sender sender;
  Receiver receiver;
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  for (std::uint32_t i = 0; i < 3; ++i) {
    Cloud cloud = makeCloud(i);
    if (i == 0)
      std::fill(cloud.data.begin(), cloud.data.end(), std::uint8_t{0xff}); // all NaN
    if (i == 1) {
      cloud.data.clear();
      cloud.width = 0;
      cloud.row_step = 0;
    }
    sender.publisher.publish(cloud);
    const auto decoded = receiver.clouds.waitForStamp(cloud.header.stamp);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(voxelsIn(*decoded).empty(), i < 2);
  }
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
