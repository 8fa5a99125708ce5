// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "link/linked_streams.h"
#include "support/stalling_nats_server.h"
#include "support/stranger.h"

namespace {

using namespace pcl_ext::link;
using namespace pcl_ext::link::test;
using std::chrono::milliseconds;

TEST(Link, CarriesFramesWithTheirTimesAndMetadata)
{
  const NatsServer server;
  std::string name(300, '.');
  name.replace(10, 20, "a b\nc > * $ \xff \x01 zzzz");
  ASSERT_EQ(name.size(), 300u);
  Receiver receiver(settingsOf(server));
  Sensor sensor(settingsOf(server), name);
  for (int i = 0; i < 20; ++i)
    expectCode(sensor.publish(), LinkCode::Ok);
  for (std::size_t i = 0; i < 20; ++i) {
    ASSERT_TRUE(receiver.take());
    const LinkFrame& frame = receiver.frames[i];
    EXPECT_EQ(frame.stream, name);
    EXPECT_EQ(frame.time, Sensor::timeOf(i));
    EXPECT_EQ(frame.bytes, sensor.frames()[i]);
    EXPECT_EQ(frame.is_i_frame, i == 0);
    EXPECT_EQ(frame.metadata.size(), i == 0 ? 1u : 0u);
  }
  EXPECT_EQ(receiver.frames[0].metadata.at("sensor_pose"), "1,2,3,0,0,0,1");
  LinkFrame none;
  expectCode(receiver.subscriber.next(none, milliseconds(0)), LinkCode::NoFrame);
  const LinkStreamStatistics statistics = receiver.statisticsOf(name);
  EXPECT_EQ(statistics.frames, 20u);
  EXPECT_EQ(statistics.frames_lost + statistics.frames_skipped + statistics.frames_late,
            0u);
  EXPECT_EQ(statistics.publishers, 1u);
  EXPECT_EQ(sensor.publisher().statistics().frames, 20u);
  // What waits when it is stopped is brought, too, and nothing is waited for.
  sensor.publish();
  ASSERT_TRUE(waitFor([&] { return receiver.statisticsOf(name).frames == 21; }));
  receiver.subscriber.stop();
  sensor.publish();
  EXPECT_TRUE(receiver.take());
  expectCode(receiver.subscriber.next(none, std::chrono::hours(1)), LinkCode::NoFrame);
}

TEST(Link, BringsAStreamThatRunsFromItsNextIFrame)
{
  const NatsServer server;
  Sensor sensor(settingsOf(server));
  sensor.publish();
  Receiver receiver(settingsOf(server));
  sensor.publish(); // a P-frame, which makes the receiver ask
  ASSERT_TRUE(waitFor([&] { return sensor.wantsIFrame(); }));
  sensor.publish();
  sensor.publish();
  ASSERT_TRUE(receiver.take());
  ASSERT_TRUE(receiver.take());
  EXPECT_TRUE(receiver.frames[0].is_i_frame);
  EXPECT_EQ(receiver.frames[0].bytes, sensor.frames()[2]);
  EXPECT_EQ(receiver.statisticsOf("/sensor_1").frames_early, 1u);
  EXPECT_EQ(receiver.statisticsOf("/sensor_1").frames_skipped, 0u);
  EXPECT_EQ(receiver.statisticsOf("/sensor_1").frames_lost, 0u);
  EXPECT_EQ(sensor.publisher().statistics().i_frame_requests, 1u);
}

TEST(Link, CountsFramesThatAServerLost)
{
  NatsServer server;
  Receiver receiver(settingsOf(server));
  Sensor sensor(settingsOf(server));
  sensor.publish();
  sensor.publish();
  ASSERT_TRUE(receiver.take());
  ASSERT_TRUE(receiver.take());
  server.stop();
  ASSERT_TRUE(waitFor([&] { return !sensor.publish().ok(); }));
  for (int i = 0; i < 4; ++i)
    expectCode(sensor.publish(), LinkCode::NotConnected);
  EXPECT_GE(sensor.publisher().statistics().frames_not_sent, 5u);
  server.start();
  ASSERT_TRUE(waitFor([&] {
    return sensor.publisher().statistics().reconnections == 1 &&
           receiver.subscriber.statistics().reconnections == 1;
  }));
  // The publisher's own encoder is asked, whether receivers do or not.
  EXPECT_TRUE(waitFor([&] { return sensor.wantsIFrame(); }));
  ASSERT_TRUE(receiver.takesLatest(sensor));
  const LinkStreamStatistics statistics = receiver.statisticsOf("/sensor_1");
  // Frames that were handed to a connection which was gone already are lost, too.
  EXPECT_EQ(statistics.frames + statistics.frames_skipped + statistics.frames_lost,
            sensor.frames().size());
  EXPECT_GE(statistics.frames_lost, 5u);
}

TEST(Link, CountsWhatAHangingServerDoesNotAnswerAndGoesOnAfterIt)
{
  NatsServer server;
  Receiver receiver(settingsOf(server));
  Sensor sensor(settingsOf(server));
  FramePublisher& publisher = sensor.publisher();
  sensor.publish();
  sensor.publish();
  ASSERT_TRUE(receiver.take());
  ASSERT_TRUE(receiver.take());
  server.hang();
  const auto publish = [&] { return sensor.publish(/* flushes */ false); };
  expectCode(publish(), LinkCode::Ok); // it is not known yet
  EXPECT_TRUE(waitFor([&] { return !publisher.statistics().is_connected; }));
  expectCode(publish(), LinkCode::NotConnected);
  const PublisherStatistics hanging = publisher.statistics();
  EXPECT_EQ(hanging.frames, 2u);
  EXPECT_EQ(hanging.frames_under_way + hanging.frames_not_sent, 2u);
  EXPECT_GE(hanging.frames_not_sent, 1u);
  EXPECT_TRUE(waitFor([&] { return !receiver.subscriber.isConnected(); }));
  server.goOn();
  ASSERT_TRUE(waitFor([&] {
    return publisher.statistics().is_connected && receiver.subscriber.isConnected();
  }));
  EXPECT_TRUE(waitFor([&] { return sensor.wantsIFrame(); }));
  EXPECT_TRUE(receiver.takesLatest(sensor));
  const std::size_t published = sensor.frames().size();
  const LinkStreamStatistics received = receiver.statisticsOf("/sensor_1");
  EXPECT_EQ(received.frames + received.frames_skipped + received.frames_lost,
            published);
  EXPECT_GE(received.frames_lost, 1u);
  const PublisherStatistics sent = publisher.statistics();
  EXPECT_EQ(sent.frames + sent.frames_not_sent, published);
  EXPECT_GE(sent.frames_not_sent, 1u);
}

TEST(Link, AsksAServerThatDidNotAnswerUntilItDoes)
{
  NatsServer server;
  Sensor sensor(settingsOf(server));
  server.hang();
  EXPECT_FALSE(sensor.publisher().flush(milliseconds(1)));
  // No answer in time; the connection is given up later.
  ASSERT_TRUE(waitFor([&] { return !sensor.publisher().statistics().is_connected; }));
  server.goOn();
  EXPECT_TRUE(waitFor([&] { return sensor.publisher().statistics().is_connected; }));
  EXPECT_TRUE(waitFor([&] { return sensor.wantsIFrame(); }));
  expectCode(sensor.publish(), LinkCode::Ok);
}

TEST(Link, CountsNoFrameAsSentOfWhichTheServerReadNothing)
{
  const StallingNatsServer server;
  LinkSettings settings;
  settings.servers = server.url();
  settings.site = site;
  FramePublisher publisher(settings);
  ASSERT_TRUE(publisher.connect().ok());
  std::size_t stream = 0;
  ASSERT_TRUE(publisher.addStream("/sensor_1", {}, stream).ok());
  // Until a write fails, after which the library's pings cannot be written.
  LiveSource source(1, 100'000);
  std::uint64_t frames = 0;
  for (LinkStatus status; status.ok(); ++frames) {
    const Bytes frame = source.next();
    status = publisher.publish(stream, Time(frames), frame.data(), frame.size());
    EXPECT_FALSE(publisher.flush(milliseconds(1)));
  }
  ASSERT_TRUE(waitFor([&] { return publisher.statistics().frames_under_way == 0; }));
  EXPECT_EQ(publisher.statistics().frames, 0u);
  EXPECT_EQ(publisher.statistics().frames_not_sent, frames);
}

TEST(Link, RefusesFramesAboveTheServersLimit)
{
  const NatsServer server("max_payload: 100");
  Receiver receiver(settingsOf(server));
  Sensor sensor(settingsOf(server));
  const LinkStatus status = sensor.publish();
  expectCode(status, LinkCode::FrameTooLarge);
  EXPECT_TRUE(hasPart(status.message(), "max_payload, 100 bytes"));
  EXPECT_EQ(sensor.publisher().statistics().frames_not_sent, 1u);
}

TEST(Link, LosesFramesOfASlowReceiverButNeverTheirOrder)
{
  const NatsServer server;
  Sensor sensor(settingsOf(server));
  SubscriberSettings settings;
  settings.link = settingsOf(server);
  Sensor probe(settingsOf(server), "/probe");
  probe.publish();
  settings.max_waiting_bytes = 4 * probe.frames()[0].size();
  settings.i_frame_request_interval = milliseconds(1);
  Receiver receiver(settings);
  constexpr std::size_t all = 60;
  for (std::size_t i = 0; i < all; ++i)
    sensor.publish();
  ASSERT_TRUE(waitFor([&] {
    const auto seen = receiver.statisticsOf("/sensor_1");
    return seen.frames + seen.frames_dropped + seen.frames_skipped == all;
  }));
  const auto before = receiver.statisticsOf("/sensor_1");
  EXPECT_GE(before.frames_dropped, 1u);
  EXPECT_LT(before.frames, all);
  while (receiver.take(milliseconds(0)))
    ;
  // It recovers: the next frame makes it ask, and the I-frame arrives.
  ASSERT_TRUE(receiver.takesLatest(sensor));
  EXPECT_EQ(receiver.statisticsOf("/sensor_1").frames_lost, 0u);
  for (std::size_t i = 1; i < receiver.frames.size(); ++i)
    EXPECT_LT(receiver.frames[i - 1].time, receiver.frames[i].time);
}

TEST(Link, NeverMixesTwoPublishersOfOneStream)
{
  const NatsServer server;
  Receiver receiver(settingsOf(server));
  Sensor one(settingsOf(server), "/same", 7, 1);
  Sensor other(settingsOf(server), "/same", 5, 2);
  for (int i = 0; i < 40; ++i) {
    one.publish();
    other.publish();
  }
  // Which frames can be decoded is checked by the receiver; each is of one of them.
  receiver.takeAll(settingsOf(server));
  const LinkStreamStatistics statistics = receiver.statisticsOf("/same");
  EXPECT_GT(statistics.publishers, 2u);
  EXPECT_EQ(statistics.frames, receiver.frames.size());
  EXPECT_GT(statistics.frames_skipped, 0u);
  bool is_of_one = true;
  for (const LinkFrame& frame : receiver.frames) {
    const bool was_of_one = is_of_one;
    const auto& frames = one.frames();
    is_of_one = std::find(frames.begin(), frames.end(), frame.bytes) != frames.end();
    EXPECT_TRUE(is_of_one == was_of_one || frame.is_i_frame);
  }
}

TEST(Link, LeavesMessagesOutThatAreNoFrames)
{
  const NatsServer server;
  SubscriberSettings settings;
  settings.link = settingsOf(server);
  settings.max_streams = 2;
  Receiver receiver(settings);
  Sensor sensor(settingsOf(server));
  sensor.publish();
  const Bytes frame = sensor.frames()[0];
  Stranger stranger(server);
  const std::string subject = "cell./sensor_1.frames";
  stranger.publish(subject, "", frame);
  stranger.publish(subject, "1 a 1", frame);
  stranger.publish(subject, "1 a 1 5", {});
  stranger.publish(subject, "1 a 1 5", Bytes(1000, 0xa5));
  Bytes longer = frame;
  longer.push_back(0);
  stranger.publish(subject, "1 a 1 5", longer);
  stranger.publish(subject, "1 a 1 5", Bytes(frame.begin(), frame.end() - 1));
  stranger.publish("cell.%zz.frames", "1 a 1 5", frame);
  stranger.publish("cell.a.frames.x", "1 a 1 5", frame);
  stranger.publish("elsewhere./sensor_1.frames", "1 a 1 5", frame);
  stranger.publish("cell.second.frames", "", frame);
  stranger.publish("cell.third.frames", "1 a 1 5", frame);
  sensor.publish();
  ASSERT_TRUE(receiver.take());
  ASSERT_TRUE(receiver.take());
  EXPECT_EQ(receiver.frames[1].bytes, sensor.frames()[1]);
  ASSERT_TRUE(waitFor([&] {
    return receiver.subscriber.statistics().messages_of_too_many == 1 &&
           receiver.subscriber.statistics().messages_of_no_stream == 2;
  }));
  EXPECT_EQ(receiver.statisticsOf("/sensor_1").messages_invalid, 6u);
  EXPECT_EQ(receiver.statisticsOf("/sensor_1").publishers, 1u);
  EXPECT_EQ(receiver.statisticsOf("second").messages_invalid, 1u);
  EXPECT_EQ(receiver.subscriber.statistics().streams.size(), 2u);
}

TEST(Link, DividesStreamsAsTheServerDoes)
{
  const NatsServer server("mappings = { \"cell.*.frames\": "
                          "\"cell.{{wildcard(1)}}.frames.{{partition(3,1)}}\" }");
  std::vector<std::unique_ptr<Receiver>> parts;
  for (unsigned int part = 0; part < 3; ++part) {
    SubscriberSettings settings;
    settings.link = settingsOf(server);
    settings.partition = part;
    parts.push_back(std::make_unique<Receiver>(settings));
  }
  SubscriberSettings one;
  one.link = settingsOf(server);
  one.streams = {"/sensor_3"};
  Receiver only(one);
  Receiver all(settingsOf(server));
  constexpr std::size_t streams = 12;
  std::vector<std::unique_ptr<Sensor>> sensors;
  for (std::size_t i = 0; i < streams; ++i) {
    sensors.push_back(
        std::make_unique<Sensor>(settingsOf(server), "/sensor_" + std::to_string(i)));
    sensors.back()->publish();
    sensors.back()->publish();
  }
  ASSERT_TRUE(only.take());
  EXPECT_EQ(only.frames[0].stream, "/sensor_3");
  for (std::size_t i = 0; i < 2 * streams; ++i)
    ASSERT_TRUE(all.take());
  std::size_t received = 0;
  EXPECT_TRUE(waitFor([&] {
    for (const auto& part : parts)
      while (part->take(milliseconds(0)))
        ++received;
    return received >= 2 * streams;
  }));
  std::map<std::string, std::size_t> frames;
  for (const auto& part : parts) {
    EXPECT_GT(part->subscriber.statistics().streams.size(), 1u);
    for (const auto& stream : part->subscriber.statistics().streams)
      ++frames[stream.name];
  }
  EXPECT_EQ(received, 2 * streams);
  EXPECT_EQ(frames.size(), streams); // each of one part
  for (const auto& [name, parts_of_it] : frames)
    EXPECT_EQ(parts_of_it, 1u) << name;
}

TEST(Link, ReplaysMessagesOfAnySizeAndGoesOnAfterARestart)
{
  NatsServer server("max_payload: 8MB\njetstream { store_dir: \"FOLDER\" }");
  KeptFrames kept;
  expectCode(keepFrames(settingsOf(server), {}, kept), LinkCode::Ok);
  Sensor sensor(settingsOf(server));
  Stranger stranger(server);
  constexpr std::size_t count = 200;
  constexpr std::size_t large = 4; // messages, which are no frames
  for (std::size_t i = 0; i < count; ++i) {
    sensor.publish();
    if (i % (count / large) == 0)
      stranger.publish("cell./sensor_1.frames", "1 a 1 5", Bytes(7'000'000, 0xa5));
  }
  ASSERT_TRUE(waitFor([&] {
    expectCode(keepFrames(settingsOf(server), {}, kept), LinkCode::Ok);
    return kept.messages == count + large;
  }));
  SubscriberSettings settings;
  settings.link = settingsOf(server);
  settings.replay_from = Time(0);
  Receiver replay(settings);
  EXPECT_EQ(replay.subscriber.statistics().replay_pending, count + large);
  for (std::size_t i = 0; i < count / 2; ++i)
    ASSERT_TRUE(replay.take());
  server.stop();
  server.start();
  // Also for one that has no patience.
  while (replay.take(milliseconds(1)) ||
         replay.subscriber.statistics().replay_pending > 0)
    ;
  EXPECT_EQ(replay.frames.size(), count);
  EXPECT_EQ(replay.statisticsOf("/sensor_1").messages_invalid, large);
  EXPECT_EQ(replay.statisticsOf("/sensor_1").frames_lost, 0u);
  EXPECT_EQ(replay.subscriber.statistics().replay_pending, 0u);
  LinkFrame frame;
  expectCode(replay.subscriber.next(frame, milliseconds(0)), LinkCode::EndOfReplay);
}

TEST(Link, ReplaysWhatTheServerKeeps)
{
  const NatsServer server("jetstream { store_dir: \"FOLDER\" }");
  KeptFrames kept;
  SubscriberSettings settings;
  settings.link = settingsOf(server);
  settings.replay_from = Time(0);
  {
    FrameSubscriber early(settings);
    const LinkStatus status = early.connect();
    expectCode(status, LinkCode::CannotConnect);
    EXPECT_TRUE(hasPart(status.message(), "keeps no frames of the site 'cell'"));
  }
  expectCode(keepFrames(settingsOf(server), {}, kept), LinkCode::Ok);
  EXPECT_EQ(kept.messages, 0u);
  {
    Receiver nothing(settings);
    LinkFrame frame;
    expectCode(nothing.subscriber.next(frame, milliseconds(20000)),
               LinkCode::EndOfReplay);
  }
  Sensor one(settingsOf(server), "/one");
  Sensor two(settingsOf(server), "/two");
  for (int i = 0; i < 30; ++i) {
    one.publish();
    two.publish();
  }
  KeepSettings less;
  less.max_age = std::chrono::hours(1);
  ASSERT_TRUE(waitFor([&] {
    expectCode(keepFrames(settingsOf(server), less, kept), LinkCode::Ok);
    return kept.messages == 60;
  }));
  // A limit that is not named stays.
  KeepSettings size;
  size.max_bytes = 1'000'000'000;
  expectCode(keepFrames(settingsOf(server), size, kept), LinkCode::Ok);
  EXPECT_EQ(kept.max_age, std::chrono::hours(1));
  expectCode(keepFrames(settingsOf(server), less, kept), LinkCode::Ok);
  EXPECT_EQ(kept.max_bytes, 1'000'000'000u);
  EXPECT_EQ(kept.messages_deleted, 0u);
  Receiver replay(settings);
  while (replay.take())
    ;
  ASSERT_EQ(replay.frames.size(), 60u);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_EQ(replay.frames[i].stream, i % 2 == 0 ? "/one" : "/two");
    EXPECT_EQ(replay.frames[i].bytes, (i % 2 == 0 ? one : two).frames()[i / 2]);
  }
  LinkFrame frame;
  expectCode(replay.subscriber.next(frame, milliseconds(0)), LinkCode::EndOfReplay);
  EXPECT_FALSE(one.wantsIFrame()); // a replay asks for nothing
  size.max_bytes = kept.bytes / 2;
  expectCode(keepFrames(settingsOf(server), size, kept), LinkCode::Ok);
  EXPECT_GT(kept.messages_deleted, 0u);
  EXPECT_EQ(kept.messages_deleted, 60 - kept.messages);
  const NatsServer without;
  const LinkStatus off = keepFrames(settingsOf(without), {}, kept);
  expectCode(off, LinkCode::CannotConnect);
  EXPECT_TRUE(hasPart(off.message(), "JetStream is off"));
}

} // namespace
