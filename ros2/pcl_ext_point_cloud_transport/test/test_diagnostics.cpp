// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What both ends report in /diagnostics besides losses.
 */
#include "plugin_test.h"

namespace pcl_ext_point_cloud_transport::test {

namespace {

using Status = Diagnostics::Status;

/** \brief The name of the last entry that the receiver of this test can have. */
std::string
nameOf(const std::string& node, const std::string& topic)
{
  return (spaceOfThisTest() + "/" + node).substr(1) + ": " + spaceOfThisTest() + "/" +
         topic;
}

TEST(DiagnosticsOf, BothEndsFromTheFirstCloudToTheLast)
{
  Sender sender;
  Receiver receiver;
  Diagnostics of_sender(receiver.node(), "sender");
  Diagnostics of_receiver(receiver.node(), "receiver");
  for (const Diagnostics* const health : {&of_sender, &of_receiver})
    EXPECT_TRUE(health->waitForEntry([](const Status& status) {
      return status.level == Status::STALE &&
             status.message.find("have arrived yet") != std::string::npos;
    }));
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  std::uint32_t number = 0;
  const auto is_ok = [](const Status& status) {
    return status.level == Status::OK && valueOf(status, "voxels") > 1000 &&
           valueOf(status, "frames per second") > 0;
  };
  EXPECT_TRUE(waitFor([&] {
    sender.publisher.publish(makeCloud(number));
    EXPECT_TRUE(receiver.clouds.waitForStamp(stampOf(number++)));
    const auto sent = of_sender.entries();
    const auto received = of_receiver.entries();
    return is_ok(sent.back()) && is_ok(received.back());
  }));
  EXPECT_EQ(of_sender.entries().back().name, nameOf("sender", "points/pcl_ext"));
  EXPECT_EQ(of_receiver.entries().back().name, nameOf("receiver", "points/pcl_ext"));
  for (const Diagnostics* const health : {&of_sender, &of_receiver})
    EXPECT_TRUE(health->waitForEntry([](const Status& status) {
      return status.level == Status::ERROR &&
             status.message.find("arrive") != std::string::npos;
    }));
  EXPECT_EQ(valueOf(of_sender.entries().back(), "frames"), number);
  EXPECT_EQ(valueOf(of_sender.entries().back(), "I-frame requests"), 0);
  EXPECT_EQ(valueOf(of_receiver.entries().back(), "frames decoded"), number);
}

TEST(DiagnosticsOf, EachPublisherOfATopicWhileItExists)
{
  Receiver receiver;
  SpunNode observer("observer");
  Diagnostics health(*observer.node, "receiver");
  const std::string name = nameOf("receiver", "points/pcl_ext");
  const auto has_entry = [&](const std::string& of, double frames) {
    return health.waitForEntry([&](const Status& status) {
      return status.name == of && valueOf(status, "frames decoded") == frames;
    });
  };
  std::optional<Sender> first(std::in_place, Parameters(), "first");
  Sender second({}, "second");
  first->expectSubscribers(1);
  second.expectSubscribers(1);
  receiver.expectPublishers(2);
  std::uint32_t number = 0;
  const auto publish = [&](Sender& sender, int clouds) {
    for (; clouds > 0; --clouds, ++number) {
      sender.publisher.publish(makeCloud(number));
      EXPECT_TRUE(receiver.clouds.waitForStamp(stampOf(number)));
    }
  };
  // The numbers are those of the first frames.
  publish(*first, 1);
  publish(second, 1);
  publish(*first, 1);
  EXPECT_TRUE(has_entry(name, 2));
  EXPECT_TRUE(has_entry(name + " 2", 1));
  first.reset();
  receiver.expectPublishers(1);
  publish(second, 4);
  EXPECT_TRUE(has_entry(name, 5));
  const std::size_t before = health.entries().size();
  EXPECT_TRUE(waitFor([&] { return health.entries().size() >= before + 2; }));
  const auto entries = health.entries();
  for (std::size_t i = before; i < entries.size(); ++i)
    EXPECT_EQ(entries[i].name, name);
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
