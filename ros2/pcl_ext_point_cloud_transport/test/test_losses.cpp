/** \file
 * \brief Frames that are lost between publisher and subscriber.
 */
#include "plugin_test.h"

#include <atomic>
#include <random>

namespace pcl_ext_point_cloud_transport {
namespace test {

namespace {

/** \brief Passes the frames of "points" on to "link", and the requests back. Both can be
 * lost. */
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
          if (passes_requests)
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
  std::atomic<bool> passes_requests{true};
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
  start(int i_frame_rate)
  {
    sender.emplace(Parameters{{points("i_frame_rate"), i_frame_rate}});
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
    // A frame that is not decoded is counted, or requests an I-frame: the first one does.
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

TEST_F(Losses, RandomLossesGiveNoWrongCloudAndEndWithTheNextIFrame)
{
  constexpr int i_frame_rate = 8;
  start(i_frame_rate);
  relay->passes_requests = false;
  std::mt19937 random(5);
  std::size_t lost = 0;
  bool is_in_step = true;
  EXPECT_TRUE(send(false));
  while (number < 80) {
    const bool is_i_frame = number % i_frame_rate == 0;
    const bool is_lost = random() % 100 < 20;
    lost += is_lost;
    is_in_step = !is_lost && (is_in_step || is_i_frame);
    EXPECT_EQ(send(is_lost), is_in_step) << number;
  }
  while (number % i_frame_rate != 0)
    send(false);
  EXPECT_TRUE(send(false));
  EXPECT_GT(lost, 8u);
  EXPECT_EQ(receiver->clouds.count(), passed - failed);
  EXPECT_TRUE(health->waitForEntry([&](const Diagnostics::Status& status) {
    return valueOf(status, "frames lost") == static_cast<double>(lost);
  }));
  EXPECT_TRUE(health->waitForEntry([](const Diagnostics::Status& status) {
    return status.level == Diagnostics::Status::WARN &&
           valueOf(status, "frames failed") > 0;
  }));
  // Once nothing is lost any more.
  const std::size_t before = health->entries().size();
  EXPECT_TRUE(waitFor([&] {
    send(false);
    const auto entries = health->entries();
    return entries.size() > before && entries.back().level == Diagnostics::Status::OK;
  }));
}

TEST_F(Losses, WithRequestsTheStreamIsInStepWithinThreeFrames)
{
  start(1000000);
  std::mt19937 random(6);
  EXPECT_TRUE(send(false));
  for (int i = 0; i < 15; ++i) {
    for (auto rest = random() % 4; rest > 0; --rest)
      send(false);
    EXPECT_FALSE(send(true));
    EXPECT_FALSE(send(false)) << "the frame before was lost"; // requests an I-frame
    const bool is_second = send(false);
    const bool is_third = send(false);
    EXPECT_TRUE(is_second || is_third);
    EXPECT_TRUE(send(false));
  }
  EXPECT_GE(relay->requests, 15u);
}

TEST_F(Losses, ALossAloneIsAWarning)
{
  start(1); // I-frames only: nothing fails
  EXPECT_TRUE(send(false));
  send(true);
  EXPECT_TRUE(send(false));
  EXPECT_TRUE(health->waitForEntry([](const Diagnostics::Status& status) {
    return status.level == Diagnostics::Status::WARN &&
           status.message == "Frames are lost" && valueOf(status, "frames lost") == 1;
  }));
  EXPECT_EQ(relay->requests, 0u);
}

} // namespace

} // namespace test
} // namespace pcl_ext_point_cloud_transport
