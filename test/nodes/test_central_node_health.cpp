// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/forged_frames.h"
#include "support/node_tests.h"
#include "support/scan_frames.h"

namespace {

using namespace pcl_ext::nodes::test;

const Bytes rubbish(40, 0x5a);

/** \brief Frames of a stream, by their indices, as they arrive, and what becomes of each:
 * outcomes as of FrameRecorder. */
struct Arrivals {
  const char* name;
  unsigned int i_frame_rate;
  std::vector<std::size_t> frames;
  std::string outcomes;
  std::size_t frames_lost;
};

class FrameOrder : public OneStream, public ::testing::WithParamInterface<Arrivals> {};

TEST_P(FrameOrder, DecidesWhatIsDecodedRequestedAndLost)
{
  const Arrivals& arrivals = GetParam();
  const CodedStream stream = streamOf(21, arrivals.i_frame_rate);
  sendFrames(stream, arrivals.frames);
  expectCounts(arrivals.outcomes, arrivals.frames_lost);
  const std::vector<RecordedFrame> recorded = recorder.frames("a");
  ASSERT_EQ(recorded.size(), arrivals.frames.size());
  VoxelFrame latest;
  bool in_sync = false;
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    const char outcome = arrivals.outcomes[i];
    if (outcome == '.')
      latest = stream.decoded[arrivals.frames[i]];
    else {
      EXPECT_EQ(recorded[i].voxels.size(), 0u);
      EXPECT_EQ(recorded[i].statistics.voxels, 0u); // not those of the frame before
      EXPECT_EQ(recorded[i].statistics.bytes, 0u);
      EXPECT_EQ(recorded[i].statistics.frame_number, 0u);
    }
    // Frames that are dropped neither resume a stream nor break it.
    if (outcome != 'd')
      in_sync = outcome == '.';
  }
  EXPECT_EQ(latestVoxels(node).keys, latest.keys);
  EXPECT_EQ(latestVoxels(node).intensities, latest.intensities);
  EXPECT_EQ(onlyHealth(node).in_sync, in_sync);
  EXPECT_EQ(onlyHealth(node).decode_times.count(), onlyHealth(node).frames_decoded);
  const bool has_failed = arrivals.outcomes.find('i') != std::string::npos;
  EXPECT_EQ(onlyHealth(node).last_failure.code(),
            has_failed ? CompressionCode::MissingReference : CompressionCode::Ok);
}

// What is lost is not known before the next frame that decodes.
INSTANTIATE_TEST_SUITE_P(
    Of,
    FrameOrder,
    ::testing::Values(
        Arrivals{
            "ALateReceiver", 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, "ixxixxixx..", 0},
        Arrivals{"LossesBetweenIFrames", 4, {0, 2, 3, 4, 6, 7, 8}, ".ix.ix.", 2},
        Arrivals{"AnUnknownLoss", 5, {0, 1, 3, 4, 5, 6, 10, 16, 17}, "..ix...ix", 4},
        Arrivals{
            "ALostIFrame", 5, {0, 1, 3, 4, 5, 6, 10, 16, 17, 20}, "..ix...ix.", 11},
        Arrivals{"AFrameThatIsLate", 30, {0, 2, 1, 2}, ".i..", 0},
        Arrivals{"Copies", 30, {0, 1, 2, 1, 3, 3, 4}, "...d.d.", 0},
        Arrivals{"CopiesBeforeALoss", 4, {0, 1, 0, 1, 4, 5}, "..dd..", 2},
        // Missing frames that come late look like copies, and stay lost.
        Arrivals{"LostOnesLate", 4, {0, 1, 4, 5, 2, 3, 6, 8}, "....dd..", 3},
        Arrivals{"ACopyAfterALoss", 8, {0, 1, 3, 1}, "..id", 0},
        Arrivals{
            "CopiesBetweenFailures", 8, {0, 1, 3, 1, 4, 1, 5, 6, 8}, "..idxdxi.", 2},
        Arrivals{"CopiesBetweenOthers",
                 30,
                 {0, 1, 0, 1, 2, 1, 2, 3, 2, 3, 4, 3, 4, 5},
                 "..dd.dd.dd.dd.",
                 0}),
    [](const auto& arrivals) { return std::string(arrivals.param.name); });

using HealthOfOneStream = OneStream;

TEST_F(HealthOfOneStream, CountsFramesBytesAndVoxels)
{
  const CodedStream stream = streamOf(5);
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    clock.set(Time(1000 + i));
    sendFrames(stream, {i});
    bytes += stream.frames[i].size();
    const StreamHealth health = onlyHealth(node);
    EXPECT_EQ(health.bytes, bytes);
    EXPECT_EQ(health.voxels, stream.decoded[i].size());
    EXPECT_EQ(health.kept_voxels, stream.decoded[i].size());
    EXPECT_EQ(health.last_decoded, Time(1000 + i));
    EXPECT_TRUE(health.in_sync);
  }
  expectCounts(".....", 0);
}

TEST_F(HealthOfOneStream, AFrameThatFailsIsNotLost)
{
  const CodedStream stream = streamOf(8, 4);
  Bytes damaged = stream.frames[1];
  damaged.back() = static_cast<std::uint8_t>(damaged.back() ^ 1);
  Bytes cut = stream.frames[6];
  cut.pop_back();
  sendFrames(stream, {0});
  sendAndWait(node, "a", damaged);
  EXPECT_EQ(onlyHealth(node).last_failure.code(), CompressionCode::Corrupt);
  sendFrames(stream, {2, 3, 4, 5});
  expectCounts(".ixx..", 0);
  sendAndWait(node, "a", cut);
  EXPECT_EQ(onlyHealth(node).last_failure.code(), CompressionCode::Truncated);
  EXPECT_FALSE(onlyHealth(node).in_sync);
  // A frame that is sent again after it failed.
  sendFrames(stream, {6, 7});
  expectCounts(".ixx..i..", 0);
}

TEST_F(HealthOfOneStream, MessagesWithoutAFrameAreNotCountedAsLost)
{
  const CodedStream stream = streamOf(9, 4);
  sendAndWait(node, "a", Bytes());
  EXPECT_EQ(onlyHealth(node).last_failure.code(), CompressionCode::EndOfStream);
  EXPECT_FALSE(onlyHealth(node).in_sync);
  sendFrames(stream, {0});
  sendAndWait(node, "a", rubbish);
  EXPECT_EQ(onlyHealth(node).last_failure.code(), CompressionCode::NoFrame);
  EXPECT_TRUE(onlyHealth(node).in_sync); // the stream has lost nothing
  sendFrames(stream, {1});
  expectCounts("x.x.", 0);
  // They do not stand in for a frame that is lost, nor end what asks for an I-frame.
  sendAndWait(node, "a", rubbish);
  sendFrames(stream, {3});
  sendAndWait(node, "a", rubbish);
  EXPECT_FALSE(onlyHealth(node).in_sync);
  sendAndWait(node, "a", Bytes());
  sendFrames(stream, {4});
  expectCounts("x.x.xixx.", 1);
}

TEST_F(HealthOfOneStream, ARestartedSenderHasLostNoFrames)
{
  const CodedStream first = streamOf(6, 30, 1);
  const CodedStream second = streamOf(9, 4, 2);
  sendFrames(first, {0, 1, 2, 3, 4, 5});
  sendFrames(second, {0, 1, 2});
  expectCounts(".........", 0);
  pcl_ext::io::test::expectSameFrame(latestVoxels(node), second.decoded[2]);
  // From then on its own numbers count.
  sendFrames(second, {/* 3 */ 4});
  expectCounts("..........", 1);
  // What the one before it sent comes late.
  sendFrames(first, {1});
  sendFrames(streamOf(1, 30, 3), {0});
  expectCounts("..........d.", 1);
}

TEST_F(HealthOfOneStream, ThreeDroppedFramesInARowRequestAnIFrame)
{
  const CodedStream first = streamOf(20);
  const CodedStream second = streamOf(13, 10, 2);
  for (const Bytes& frame : first.frames)
    sendAndWait(node, "a", frame);
  for (std::size_t i = 1; i < 13; ++i) // its first I-frame is lost
    sendFrames(second, {i});
  expectCounts(std::string(20, '.') + "ddDddDddD...", 0);
  EXPECT_EQ(recorder.frames("a")[20].code, CompressionCode::OldFrame);
  pcl_ext::io::test::expectSameFrame(recorder.frames("a").back().voxels,
                                     second.decoded[12]);
}

TEST_F(HealthOfOneStream, AnUnknownVersionRequestsNoIFrame)
{
  const CodedStream stream = streamOf(3);
  Bytes newer = stream.frames[1];
  newer[pcl_ext::io::version1_magic_size] = 9;
  sendFrames(stream, {0});
  sendAndWait(node, "a", newer);
  EXPECT_EQ(onlyHealth(node).last_failure.code(), CompressionCode::UnsupportedVersion);
  expectCounts(".x", 0);
}

TEST_F(HealthOfOneStream, RatesAreOfTheFramesThatWereDecoded)
{
  const CodedStream stream = streamOf(4);
  clock.set(20000ms);
  sendFrames(stream, {0});
  clock.set(20100ms);
  sendAndWait(node, "a", rubbish);
  clock.set(20200ms);
  sendFrames(stream, {1});
  clock.set(20400ms);
  sendFrames(stream, {3}); // fails
  clock.set(20500ms);
  sendFrames(stream, {2});
  const StreamRates rates = onlyHealth(node).rates;
  EXPECT_DOUBLE_EQ(rates.frames_per_second, 4.0);
  EXPECT_DOUBLE_EQ(
      rates.bytes_per_second,
      static_cast<double>(stream.frames[1].size() + stream.frames[2].size()) / 0.5);
  EXPECT_GT(rates.mean_cycle_seconds, 0.0);
  EXPECT_GE(rates.max_cycle_seconds, rates.mean_cycle_seconds);
  clock.set(22500ms + 1ns); // silent since
  EXPECT_EQ(onlyHealth(node).rates.frames_per_second, 0.0);
}

TEST_F(HealthOfOneStream, LatenciesAreFromTheStampUntilTheFrameIsDecoded)
{
  const CodedStream stream = stampedStream(3, 50000000); // 50 s, then 1 ms later each
  clock.set(50200ms);
  sendAndWait(node, "a", stream.frames[0]); // carried
  EXPECT_EQ(recorder.frames("a").back().stamp, 50s);
  EXPECT_DOUBLE_EQ(onlyHealth(node).rates.mean_latency_seconds, 0.2);
  sendAndWait(node, "a", stream.frames[1], 49800ms); // given, which goes first
  EXPECT_EQ(recorder.frames("a").back().stamp, 49800ms);
  EXPECT_DOUBLE_EQ(onlyHealth(node).rates.max_latency_seconds, 0.4);
  EXPECT_DOUBLE_EQ(onlyHealth(node).rates.mean_latency_seconds, 0.3);
  clock.set(50402ms);
  sendAndWait(node, "a", stream.frames[2]);
  EXPECT_DOUBLE_EQ(onlyHealth(node).rates.mean_latency_seconds, (0.2 + 0.4 + 0.4) / 3);
}

TEST_F(HealthOfOneStream, StampsOutOfRangeAreSafe)
{
  // Nanoseconds where PCL has microseconds, and the last number there is.
  for (const std::uint64_t stamp :
       std::vector<std::uint64_t>{1700000000000000000, ~std::uint64_t{0}}) {
    clock.set(clock.clock()() + 10s);
    sendFrames(stampedStream(1, stamp), {0});
    EXPECT_GT(recorder.frames("a").back().stamp,
              Time(std::chrono::hours(24 * 365 * 290)));
    EXPECT_EQ(onlyHealth(node).rates.mean_latency_seconds, 0.0);
    clock.set(clock.clock()() + 10s);
  }
  sendAndWait(node, "a", streamOf(1).frames[0], Time::min());
  EXPECT_EQ(onlyHealth(node).rates.max_latency_seconds, 0.0);
  sendAndWait(node, "a", streamOf(1).frames[0], Time::max());
  EXPECT_EQ(recorder.frames("a").back().stamp, Time::max());
}

TEST_F(HealthOfOneStream, WithoutAStampOrWithThatOfARecordingThereIsNoLatency)
{
  clock.set(1700000000s);
  sendFrames(streamOf(1), {0});
  EXPECT_EQ(recorder.frames("a").back().stamp, Time(0));
  // 0 is what clouds have that were never stamped.
  sendAndWait(node, "a", streamOf(1).frames[0], Time(0));
  sendFrames(stampedStream(1, 0), {0});
  sendFrames(stampedStream(3, 50000000), {0, 1, 2}); // from 50 s on
  EXPECT_EQ(onlyHealth(node).frames_decoded, 6u);
  EXPECT_EQ(onlyHealth(node).rates.mean_latency_seconds, 0.0);
  EXPECT_EQ(onlyHealth(node).rates.max_latency_seconds, 0.0);
}

TEST(CentralNodeHealth, IsInTheOrderOfNames)
{
  CentralNode node(centralSettings());
  for (const std::string name : {"b", "a", "c10", "c9", "B"})
    node.addStream(name);
  std::vector<std::string> names;
  for (const StreamHealth& health : node.health())
    names.push_back(health.name);
  EXPECT_EQ(names, (std::vector<std::string>{"B", "a", "b", "c10", "c9"}));
}

/** \brief A stream whose first frame is blocked in the listener. */
class BlockedStream : public ::testing::Test {
protected:
  static CentralNodeSettings
  settingsWithFewWaiting()
  {
    CentralNodeSettings settings = centralSettings();
    settings.max_waiting_frames = 3;
    return settings;
  }

  BlockedStream()
  {
    node.addStream("a");
    send(node, "a", stream.frames[0]);
    gate.waitForArrivals(1);
  }

  ~BlockedStream() override { gate.open(); }

  void
  fillQueue()
  {
    for (const std::size_t index : {1u, 2u, 3u})
      send(node, "a", stream.frames[index]);
  }

  void
  expectRefused(std::size_t index)
  {
    const CentralNodeStatus status = node.receive("a", stream.frames.at(index));
    expectCode(status, CentralNodeCode::TooManyWaiting);
    EXPECT_EQ(status.message(),
              "the frame was refused, as 3 frames of 'a' are waiting");
  }

  CodedStream stream = streamOf(16, 6);
  FrameRecorder recorder;
  Gate gate;
  CentralNode node{settingsWithFewWaiting(), [this](const ReceivedFrame& frame) {
                     recorder.listener()(frame);
                     gate.pass();
                   }};
};

TEST_F(BlockedStream, RefusesFramesWhileTooManyWait)
{
  fillQueue();
  for (const std::size_t index : {4u, 5u})
    expectRefused(index);
  StreamHealth health = onlyHealth(node);
  EXPECT_EQ(health.frames_received, 6u);
  EXPECT_EQ(health.frames_decoded, 1u); // and is blocked in the listener
  EXPECT_EQ(health.frames_refused, 2u);
  EXPECT_EQ(health.frames_failed, 0u); // three wait
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < 6; ++i)
    bytes += stream.frames[i].size();
  EXPECT_EQ(health.bytes, bytes);

  gate.open();
  node.waitUntilDecoded();
  health = onlyHealth(node);
  EXPECT_EQ(health.frames_decoded, 4u);
  EXPECT_EQ(health.frames_refused, 2u);
  // Those that were taken are decoded in their order, and there is room again.
  for (std::size_t i = 0; i < 4; ++i)
    pcl_ext::io::test::expectSameFrame(recorder.frames("a").at(i).voxels,
                                       stream.decoded[i]);
  sendAndWait(node, "a", stream.frames[6]);
  EXPECT_EQ(recorder.outcomes("a"), ".....");
}

TEST_F(BlockedStream, ARefusedFrameIsNotLost)
{
  // It is refused before those that wait are decoded, and is missing after them.
  fillQueue();
  expectRefused(4);
  gate.open();
  node.waitUntilDecoded();
  sendAndWait(node, "a", stream.frames[5]);
  sendAndWait(node, "a", stream.frames[6]);
  EXPECT_EQ(recorder.outcomes("a"), "....i.");
  StreamHealth health = onlyHealth(node);
  EXPECT_EQ(health.frames_lost, 0u);
  EXPECT_EQ(health.frames_failed, 1u);
  EXPECT_EQ(health.frames_refused, 1u);
  sendAndWait(node, "a", stream.frames[7]);
  sendAndWait(node, "a", stream.frames[12]); // 8 to 11 are lost
  EXPECT_EQ(onlyHealth(node).frames_lost, 4u);
}

TEST_F(BlockedStream, FramesThatAreLostBeforeARefusedOneAreCounted)
{
  fillQueue();
  expectRefused(5); // 4 is lost
  gate.open();
  node.waitUntilDecoded();
  sendAndWait(node, "a", stream.frames[6]);
  EXPECT_EQ(onlyHealth(node).frames_lost, 1u);
}

TEST_F(BlockedStream, OtherStreamsAreNotAffected)
{
  node.addStream("b");
  fillQueue();
  send(node, "b", stream.frames[0]);
  gate.waitForArrivals(2);
  EXPECT_EQ(recorder.outcomes("a"), ".");
  EXPECT_EQ(recorder.outcomes("b"), ".");
  EXPECT_EQ(node.health().at(1).frames_decoded, 1u);
}

TEST(ScansOfAStream, HavePointsWithoutVoxelsOfWhichTheStatusAndTheHealthTell)
{
  FakeClock clock;
  std::vector<std::string> messages;
  CentralNode node(settingsWith(clock), [&](const ReceivedFrame& frame) {
    EXPECT_TRUE(frame.status.ok()) << frame.status;
    messages.push_back(frame.status.message());
  });
  node.addStream("a");
  FrameEncoder encoder(StreamFormat::Version1, 2, Effort::Fast);
  FrameDecoder decoder;
  std::size_t outside = 0;
  std::vector<std::string> expected;
  for (unsigned int i = 0; i < 3; ++i) {
    auto scan = pcl_ext::io::test::makeCamera();
    pcl_ext::io::test::addPoints(scan, i, false, i == 1 ? 1u << 30 : 40u);
    const Bytes bytes = pcl_ext::io::test::encoded(encoder, scan);
    VoxelFrame frame;
    expected.push_back(decoder.decode(bytes.data(), bytes.size(), frame).message());
    EXPECT_EQ(expected.back().empty(), i == 1);
    outside += frame.points.outside_grid;
    sendAndWait(node, "a", bytes);
    EXPECT_EQ(onlyHealth(node).points_outside_grid, outside);
    // Nothing was removed.
    EXPECT_EQ(onlyHealth(node).voxels, frame.size());
    EXPECT_EQ(onlyHealth(node).kept_voxels, frame.size());
  }
  EXPECT_GT(outside, 0u);
  EXPECT_EQ(messages, expected);
}

} // namespace
