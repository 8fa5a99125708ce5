// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Publishers, subscribers and nodes that end while messages flow. A wrong order
 * shows as a crash, surely so under AddressSanitizer.
 */
#include "plugin_test.h"

#include <point_cloud_transport/simple_subscriber_plugin.hpp>

#include <atomic>
#include <random>

namespace pcl_ext_point_cloud_transport::test {

namespace {

/** \brief Calls a function again and again in a thread of its own. */
class Repeated {
public:
  explicit Repeated(std::function<void()> call)
  : thread_([this, call = std::move(call)] {
    while (!ends_) {
      call();
      ++calls;
    }
  })
  {}

  ~Repeated()
  {
    ends_ = true;
    thread_.join();
  }

  std::atomic<std::size_t> calls{0};

private:
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

/** \brief A node that several threads spin. */
struct BusyNode {
  explicit BusyNode(const std::string& name)
  : node(std::make_shared<rclcpp::Node>(
        name,
        spaceOfThisTest(),
        rclcpp::NodeOptions().parameter_overrides(
            {{"points.enable_pub_plugins",
              std::vector<std::string>{"point_cloud_transport/pcl_ext"}}})))
  , transport(toTransport(node))
  {
    executor.add_node(node);
    thread = std::thread([this] { executor.spin(); });
    waitFor([this] { return executor.is_spinning(); });
  }

  ~BusyNode()
  {
    executor.cancel();
    thread.join();
  }

  rclcpp::Node::SharedPtr node;
  point_cloud_transport::PointCloudTransport transport;
  rclcpp::executors::MultiThreadedExecutor executor{rclcpp::ExecutorOptions(), 3};
  std::thread thread;
};

TEST(Lifetimes, SubscribersThatEndWhileFramesArrive)
{
  Sender sender;
  Repeated publishing([&, number = std::uint32_t{0}]() mutable {
    sender.publisher.publish(makeCloud(number++ % 50));
  });
  BusyNode busy("busy");
  const auto hints = hintsOfPlugin();
  for (int i = 0; i < 30; ++i) {
    // A callback that has begun may end after its subscriber.
    const auto arrived = std::make_shared<std::atomic<std::size_t>>(0);
    const auto count = [arrived](const Cloud::ConstSharedPtr&) { ++*arrived; };
    auto subscriber =
        busy.transport.subscribe("points", toTransport(reliable()), count, {}, &hints);
    EXPECT_TRUE(waitFor([&] { return *arrived > static_cast<std::size_t>(i % 3); }));
    if (i % 2 == 0)
      subscriber.shutdown();
    subscriber = point_cloud_transport::Subscriber();
  }
}

TEST(Lifetimes, ASubscriberThatEndsInItsOwnCallback)
{
  Sender sender;
  SpunNode spun("receiver");
  point_cloud_transport::PointCloudTransport transport(toTransport(spun.node));
  const auto hints = hintsOfPlugin();
  std::uint32_t number = 0;
  for (int i = 0; i < 5; ++i) {
    std::mutex mutex;
    point_cloud_transport::Subscriber subscriber;
    std::atomic<std::size_t> arrived{0};
    {
      const std::lock_guard<std::mutex> lock(mutex);
      subscriber = transport.subscribe(
          "points",
          toTransport(reliable()),
          [&](const Cloud::ConstSharedPtr&) {
            const std::lock_guard<std::mutex> lock_of_callback(mutex);
            subscriber.shutdown();
            ++arrived;
          },
          {},
          &hints);
    }
    EXPECT_TRUE(waitFor([&] {
      sender.publisher.publish(makeCloud(number++ % 50));
      return arrived > 0;
    }));
    sender.expectSubscribers(0);
    EXPECT_EQ(arrived, 1u);
  }
}

TEST(Lifetimes, PublishersThatEndWhileRequestsAndParametersArrive)
{
  SpunNode other("other");
  const auto requests = other.node->create_publisher<std_msgs::msg::Empty>(
      "points/pcl_ext/request_i_frame", rclcpp::QoS(100));
  Receiver receiver;
  Repeated requesting([&] { requests->publish(std_msgs::msg::Empty()); });
  BusyNode busy("busy");
  Repeated setting([&, number = 0]() mutable {
    if (busy.node->has_parameter(points("resolution")))
      busy.node->set_parameter({points("resolution"), 0.03 + 0.001 * (number++ % 10)});
  });
  std::uint32_t number = 0;
  for (int i = 0; i < 30; ++i) {
    auto publisher = busy.transport.advertise("points", toTransport(reliable()));
    EXPECT_TRUE(waitFor([&] { return publisher.getNumSubscribers() == 1; }));
    for (int clouds = 0; clouds < 3; ++clouds)
      publisher.publish(makeCloud(number++));
    if (i % 2 == 0)
      publisher.shutdown();
  }
  EXPECT_GT(receiver.clouds.count(), 0u);
}

TEST(Lifetimes, NodesThatEndInAnyOrder)
{
  std::mt19937 random(8);
  for (int i = 0; i < 12; ++i) {
    auto sender = std::make_unique<BusyNode>("sender");
    auto receiver = std::make_unique<BusyNode>("receiver");
    const auto hints = hintsOfPlugin();
    auto publisher = sender->transport.advertise("points", toTransport(reliable()));
    const auto arrived = std::make_shared<std::atomic<std::size_t>>(0);
    auto subscriber = receiver->transport.subscribe(
        "points",
        toTransport(reliable()),
        [arrived](const Cloud::ConstSharedPtr&) { ++*arrived; },
        {},
        &hints);
    EXPECT_TRUE(waitFor([&, number = std::uint32_t{0}]() mutable {
      publisher.publish(makeCloud(number++));
      return *arrived > 1;
    }));
    std::vector<std::function<void()>> ends{
        [&] { sender.reset(); },
        [&] { receiver.reset(); },
        [&] { publisher = point_cloud_transport::Publisher(); },
        [&] { subscriber = point_cloud_transport::Subscriber(); }};
    for (; !ends.empty(); ends.pop_back()) {
      std::swap(ends[random() % ends.size()], ends.back());
      if (publisher)
        publisher.publish(makeCloud(0));
      ends.back()();
    }
  }
}

TEST(Lifetimes, DiagnosticsOfWhatHasEnded)
{
  SpunNode observer("observer");
  Diagnostics of_sender(*observer.node, "busy");
  BusyNode busy("busy");
  const auto hints = hintsOfPlugin();
  for (int i = 0; i < 2; ++i) {
    const std::size_t before = of_sender.entries().size();
    auto publisher = busy.transport.advertise("points", toTransport(reliable()));
    auto subscriber = busy.transport.subscribe(
        "points",
        toTransport(reliable()),
        [](const Cloud::ConstSharedPtr&) {},
        {},
        &hints);
    EXPECT_TRUE(waitFor([&] { return of_sender.entries().size() >= before + 4; }));
  }
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
