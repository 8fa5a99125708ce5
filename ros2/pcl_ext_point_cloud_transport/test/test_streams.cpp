// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Decoded voxels are those that the library makes of the clouds.
 */
#include "plugin_test.h"

#include <point_cloud_transport/subscriber_filter.hpp>

#include <algorithm>
#include <functional>
#include <random>

namespace pcl_ext_point_cloud_transport::test {

namespace {

class OfLayout : public ::testing::TestWithParam<Layout> {};

TEST_P(OfLayout, VoxelsAreThoseOfTheLibrary)
{
  Sender sender;
  Receiver receiver;
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  for (std::uint32_t i = 0; i < 25; ++i) { // more than one I-frame
    const Cloud cloud = makeCloud(i, GetParam());
    expectVoxels(
        sender, receiver, cloud, directVoxels(cloud, defaultSettings(GetParam())));
  }
  EXPECT_EQ(receiver.clouds.count(), 25u);
}

INSTANTIATE_TEST_SUITE_P(Streams, OfLayout, ::testing::ValuesIn(all_layouts));

TEST(Streams, ALayoutThatChangesStartsAnotherStream)
{
  Sender sender;
  Receiver receiver;
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  std::uint32_t number = 0;
  for (int round = 0; round < 2; ++round)
    for (const Layout layout : all_layouts) {
      const Cloud cloud = makeCloud(number++, layout);
      expectVoxels(
          sender, receiver, cloud, directVoxels(cloud, defaultSettings(layout)));
    }
}

TEST(Streams, WithoutACropBoxTheGridIsThatOfTheFirstCloud)
{
  Sender sender({{points("crop_box"), std::vector<double>()}});
  Receiver receiver;
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  auto settings = defaultSettings(Layout::Xyzi);
  settings.crop_box.reset();
  DirectStream direct(settings);
  for (std::uint32_t i = 0; i < 40; ++i) {
    const Cloud cloud = makeCloud(i, Layout::Xyzi);
    expectVoxels(sender, receiver, cloud, direct.voxelsOf(cloud));
  }
}

TEST(Streams, MostFramesAreSmallerThanAnIFrame)
{
  Sender sender({{points("i_frame_rate"), 10}});
  Receiver receiver;
  Listener<Compressed> frames(receiver.node(), spaceOfThisTest() + "/points/pcl_ext");
  sender.expectSubscribers(2);
  receiver.expectPublishers(1);
  for (std::uint32_t i = 0; i < 20; ++i) {
    sender.publisher.publish(makeCloud(i));
    ASSERT_TRUE(receiver.clouds.waitForStamp(stampOf(i)));
    const auto frame = frames.recorder.waitForStamp(stampOf(i));
    ASSERT_TRUE(frame);
    EXPECT_EQ(isIFrame(*frame), i % 10 == 0) << i;
    EXPECT_EQ(frame->format, "pcl_ext/version1");
    const auto decoded = receiver.clouds.find(stampOf(i));
    EXPECT_EQ(frame->width, decoded->width);
    EXPECT_EQ(frame->height, decoded->height);
    EXPECT_EQ(frame->fields, decoded->fields);
    EXPECT_EQ(frame->point_step, decoded->point_step);
    EXPECT_EQ(frame->row_step, decoded->row_step);
    EXPECT_LT(frame->compressed_data.size(), decoded->data.size() / 3);
  }
}

TEST(Streams, AFilterThatSubscribesAgainAndAgainGetsTheVoxels)
{
  Sender sender;
  Recorder<Cloud> clouds;
  point_cloud_transport::SubscriberFilter filter;
  filter.registerCallback(std::function<void(const Cloud::ConstSharedPtr&)>(
      [&clouds](const Cloud::ConstSharedPtr& cloud) { clouds.add(cloud); }));
  const SpunNode viewer("viewer");        // last, as its thread calls the filter
  for (std::uint32_t i = 0; i < 3; ++i) { // as a display of RViz that is reset
    filter.subscribe(toTransport(viewer.node),
                     spaceOfThisTest() + "/points",
                     "pcl_ext",
                     toTransport(reliable()));
    sender.expectSubscribers(1);
    ASSERT_TRUE(waitFor([&] { return filter.getNumPublishers() == 1; }));
    const Cloud cloud = makeCloud(i);
    sender.publisher.publish(cloud);
    const auto decoded = clouds.waitForStamp(cloud.header.stamp);
    ASSERT_TRUE(decoded) << i;
    EXPECT_TRUE(voxelsIn(*decoded) == directVoxels(cloud, defaultSettings()));
    filter.unsubscribe();
    sender.expectSubscribers(0);
  }
}

#ifdef PCL_EXT_SUBSCRIBERS_SHOW_SUBSCRIPTION
TEST(Streams, TheSubscriptionIsThatOfTheFrames)
{
  Receiver receiver;
  const auto subscription = receiver.subscriber.getSubscription();
  ASSERT_TRUE(subscription);
  EXPECT_EQ(subscription->get_topic_name(), spaceOfThisTest() + "/points/pcl_ext");
  receiver.subscriber.shutdown();
  EXPECT_FALSE(receiver.subscriber.getSubscription());
}
#endif

TEST(Streams, PublishedFormat)
{
  Sender sender({{points("format"), "published"}});
  Receiver receiver;
  Listener<Compressed> frames(receiver.node(), spaceOfThisTest() + "/points/pcl_ext");
  sender.expectSubscribers(2);
  receiver.expectPublishers(1);
  auto settings = defaultSettings();
  settings.compression.format = pcl_ext::io::StreamFormat::Published;
  for (std::uint32_t i = 0; i < 3; ++i)
    expectVoxels(sender, receiver, makeCloud(i), directVoxels(makeCloud(i), settings));
  EXPECT_EQ(frames.recorder.waitForStamp(stampOf(2))->format, "pcl_ext/published");
}

/** \brief Publishes until a late receiver has a cloud. */
void
expectCloudsOfLateJoiner(const rclcpp::QoS& qos)
{
  Sender sender({{points("i_frame_rate"), 1000000}}, "sender", qos);
  std::uint32_t number = 0;
  for (int i = 0; i < 3; ++i) {
    Receiver receiver({}, "receiver", "points", qos);
    sender.expectSubscribers(1);
    receiver.expectPublishers(1);
    const std::uint32_t first = number;
    for (; number < first + 5; ++number) {
      const Cloud cloud = makeCloud(number);
      sender.publisher.publish(cloud);
      const bool must_arrive = number >= first + 2;
      const auto decoded = receiver.clouds.waitForStamp(
          cloud.header.stamp, must_arrive ? seconds_to_wait : 0.1);
      EXPECT_TRUE(decoded || !must_arrive) << number - first;
      EXPECT_TRUE(!decoded ||
                  voxelsIn(*decoded) == directVoxels(cloud, defaultSettings()));
    }
    Receiver second({}, "second", "points", qos); // with the first one still there
    sender.expectSubscribers(2);
    second.expectPublishers(1);
    for (const std::uint32_t end = number + 3; number < end; ++number) {
      sender.publisher.publish(makeCloud(number));
      ASSERT_TRUE(receiver.clouds.waitForStamp(stampOf(number)));
    }
    EXPECT_TRUE(second.clouds.waitForStamp(stampOf(number - 1)));
  }
  sender.expectSubscribers(0);
}

TEST(Streams, LateJoinerGetsACloudWithinTwoFurtherFrames)
{
  expectCloudsOfLateJoiner(reliable());
}

TEST(Streams, LateJoinerWithBestEffort)
{
  expectCloudsOfLateJoiner(rclcpp::SensorDataQoS());
}

TEST(Streams, ASubscriberInPlaceOfAnotherGetsAnIFrame)
{
  Sender sender({{points("i_frame_rate"), 1000000}});
  SpunNode observer("observer");
  std::uint32_t number = 0;
  for (int i = 0; i < 5; ++i) {
    // One that requests nothing, as a recorder of bags.
    Listener<Compressed> frames(*observer.node, spaceOfThisTest() + "/points/pcl_ext");
    sender.expectSubscribers(1);
    ASSERT_TRUE(waitFor([&] {
      return observer.node->count_publishers(spaceOfThisTest() + "/points/pcl_ext") ==
             1;
    }));
    EXPECT_TRUE(waitFor([&] {
      sender.publisher.publish(makeCloud(number));
      frames.recorder.waitForStamp(stampOf(number++), 0.2);
      const auto arrived = frames.recorder.messages();
      return std::any_of(arrived.begin(), arrived.end(), [](const auto& frame) {
        return isIFrame(*frame);
      });
    })) << i;
    // Without subscribers clouds do not reach the plugin, which sees as many as before.
  }
}

void
expectCloudsOfTwoPublishers(Sender& first, Sender& second, const Receiver& receiver)
{
  std::mt19937 random(4);
  for (std::uint32_t i = 0; i < 60; ++i) {
    const Layout layout = random() % 2 == 0 ? Layout::Xyzi : Layout::Organized;
    const Cloud cloud = makeCloud(i, layout);
    expectVoxels(layout == Layout::Xyzi ? first : second,
                 receiver,
                 cloud,
                 directVoxels(cloud, defaultSettings(layout)));
  }
}

TEST(Streams, TwoPublishersOfOneTopic)
{
  Sender first({}, "first");
  Sender second({}, "second");
  Receiver receiver;
  first.expectSubscribers(1);
  second.expectSubscribers(1);
  receiver.expectPublishers(2);
  expectCloudsOfTwoPublishers(first, second, receiver);
}

TEST(Streams, TwoPublishersOfOneProcessWithoutMiddleware)
{
  // Their messages come without the publisher's name, so that they are one stream:
  // clouds may be missing, but none is wrong.
  const auto options = rclcpp::NodeOptions().use_intra_process_comms(true);
  const rclcpp::QoS qos(100);
  Sender first({}, "first", qos, options);
  Sender second({}, "second", qos, options);
  Receiver receiver({}, "receiver", "points", qos, options);
  first.expectSubscribers(1);
  second.expectSubscribers(1);
  receiver.expectPublishers(2);
  std::mt19937 random(4);
  std::vector<Layout> layouts;
  for (std::uint32_t i = 0; i < 200; ++i) {
    layouts.push_back(random() % 2 == 0 ? Layout::Xyzi : Layout::Organized);
    (layouts[i] == Layout::Xyzi ? first : second)
        .publisher.publish(makeCloud(i, layouts[i]));
    receiver.clouds.waitForStamp(stampOf(i), 0.005);
  }
  for (std::uint32_t i = 0; i < 200; ++i)
    if (const auto decoded = receiver.clouds.find(stampOf(i))) {
      const Cloud cloud = makeCloud(i, layouts[i]);
      EXPECT_EQ(decoded->header, cloud.header);
      EXPECT_TRUE(voxelsIn(*decoded) ==
                  directVoxels(cloud, defaultSettings(layouts[i])))
          << i;
    }
  EXPECT_GT(receiver.clouds.count(), 10u);
}

TEST(Streams, ANodeThatAdvertisesATopicTwice)
{
  Sender sender({{points("resolution"), 0.08}});
  auto again = point_cloud_transport::PointCloudTransport(toTransport(sender.spun.node))
                   .advertise("points", toTransport(reliable()));
  Receiver receiver;
  sender.expectSubscribers(1);
  ASSERT_TRUE(waitFor([&] { return again.getNumSubscribers() == 1; }));
  receiver.expectPublishers(2);
  auto settings = defaultSettings();
  auto expect_both = [&, number = std::uint32_t{0}]() mutable {
    for (int i = 0; i < 3; ++i) {
      expectVoxels(sender,
                   receiver,
                   makeCloud(number),
                   directVoxels(makeCloud(number), settings));
      again.publish(makeCloud(++number));
      const auto decoded = receiver.clouds.waitForStamp(stampOf(number));
      ASSERT_TRUE(decoded);
      EXPECT_TRUE(voxelsIn(*decoded) == directVoxels(makeCloud(number), settings));
      ++number;
    }
  };
  settings.compression.resolution = 0.08;
  expect_both();
  settings.compression.resolution = 0.05;
  EXPECT_TRUE(sender.node().set_parameter({points("resolution"), 0.05}).successful);
  expect_both();
  again.shutdown();
  settings.compression.resolution = 0.06;
  EXPECT_TRUE(sender.node().set_parameter({points("resolution"), 0.06}).successful);
  expectVoxels(
      sender, receiver, makeCloud(100), directVoxels(makeCloud(100), settings));
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test
