// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Frames that are lost between publisher and subscriber.
 */
#include "plugin_test.h"

#include <atomic>

namespace pcl_ext_point_cloud_transport::test {

namespace {

/** \brief Passes the frames of "points" on to "link", unless they are to be lost, and
 * the requests back. */
class Relay {
public:
  Relay()
  : spun_("relay")
  , frames_sent_(node().create_publisher<Compressed>("link/pcl_ext", rclcpp::QoS(1000)))
  , requests_sent_(node().create_publisher<std_msgs::msg::Empty>(
        "points/pcl_ext/request_i_frame", rclcpp::QoS(1000)))
  , frames_(node().create_subscription<Compressed>(
        "points/pcl_ext",
        rclcpp::QoS(1000),
        [this](const std::shared_ptr<const Compressed>& frame) {
          if (!loses_frames)
            frames_sent_->publish(*frame);
          ++frames;
        }))
  , requests_(node().create_subscription<std_msgs::msg::Empty>(
        "link/pcl_ext/request_i_frame",
        rclcpp::QoS(1000),
        [this](const std_msgs::msg::Empty& request) {
          ++requests;
          requests_sent_->publish(request);
        }))
  {}

  rclcpp::Node&
  node()
  {
    return *spun_.node;
  }

  void
  expectConnections()
  {
    EXPECT_TRUE(waitFor([this] {
      return frames_sent_->get_subscription_count() == 1 &&
             requests_sent_->get_subscription_count() == 1 &&
             frames_->get_publisher_count() == 1 &&
             requests_->get_publisher_count() == 1;
    }));
  }

  std::atomic<bool> loses_frames{false};
  std::atomic<std::size_t> frames{0};
  std::atomic<std::size_t> requests{0};

private:
  SpunNode spun_;
  rclcpp::Publisher<Compressed>::SharedPtr frames_sent_;
  rclcpp::Publisher<std_msgs::msg::Empty>::SharedPtr requests_sent_;
  rclcpp::Subscription<Compressed>::SharedPtr frames_;
  rclcpp::Subscription<std_msgs::msg::Empty>::SharedPtr requests_;
};

class Losses : public ::testing::Test {
protected:
  void
  start()
  {
    sender.emplace(Parameters{{points("i_frame_rate"), 1000000}});
    relay.emplace();
    receiver.emplace(Parameters(), "receiver", "link");
    marker = receiver->spun.node->create_publisher<Compressed>("unused", 1);
    health.emplace(relay->node(), "receiver");
    sender->expectSubscribers(1);
    receiver->expectPublishers(1);
    relay->expectConnections();
  }

  /** \brief Publishes the next cloud and waits until its fate is known.
   * \return true if it was delivered, and as it must be
   */
  bool
  send(bool is_lost)
  {
    const Cloud cloud = makeCloud(number);
    relay->loses_frames = is_lost;
    const std::size_t requests_before = relay->requests;
    sender->publisher.publish(cloud);
    EXPECT_TRUE(waitFor([&] { return relay->frames == number + 1; })) << number;
    ++number;
    if (is_lost)
      return false;
    ++passed;
    // A frame that is not decoded is counted, or requests an I-frame: the first one
    // does.
    Cloud::ConstSharedPtr decoded;
    EXPECT_TRUE(waitFor([&] {
      decoded = receiver->clouds.find(cloud.header.stamp);
      return decoded || relay->requests > requests_before || failuresReported();
    })) << number;
    if (!decoded) {
      ++failed;
      return false;
    }
    EXPECT_EQ(decoded->header, cloud.header);
    EXPECT_TRUE(voxelsIn(*decoded) == directVoxels(cloud, defaultSettings())) << number;
    return true;
  }

  /** \brief True if the diagnostics know of all frames that were passed on, not all of
   * which were decoded. */
  bool
  failuresReported() const
  {
    const auto entries = health->entries();
    return !entries.empty() &&
           valueOf(entries.back(), "frames received") == static_cast<double>(passed) &&
           valueOf(entries.back(), "frames failed") == static_cast<double>(failed + 1);
  }

  std::optional<Sender> sender;
  std::optional<Relay> relay;
  std::optional<Receiver> receiver;
  std::optional<Diagnostics> health;
  rclcpp::PublisherBase::SharedPtr marker;
  std::uint32_t number = 0; // of the next cloud
  std::size_t passed = 0;   // frames
  std::size_t failed = 0;   // of those passed
};

TEST_F(Losses, WithRequestsTheStreamIsInStepWithinThreeFrames)
{
  start();
  EXPECT_TRUE(send(false));
  for (int i = 0; i < 5; ++i) {
    for (int rest = i % 3; rest > 0; --rest)
      send(false);
    EXPECT_FALSE(send(true));
    EXPECT_FALSE(send(false)) << "the frame before was lost"; // requests an I-frame
    const bool is_second = send(false);
    const bool is_third = send(false);
    EXPECT_TRUE(is_second || is_third);
    EXPECT_TRUE(send(false));
  }
  EXPECT_GE(relay->requests, 5u);
  EXPECT_TRUE(health->waitForEntry([](const Diagnostics::Status& status) {
    return status.level == Diagnostics::Status::WARN &&
           valueOf(status, "frames lost") == 5 && valueOf(status, "frames failed") > 0;
  }));
  // Once nothing is lost any more.
  const std::size_t before = health->entries().size();
  EXPECT_TRUE(waitFor([&] {
    send(false);
    const auto entries = health->entries();
    return entries.size() > before && entries.back().level == Diagnostics::Status::OK;
  }));
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
