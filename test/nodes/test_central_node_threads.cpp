// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A CentralNode that many threads use at once; to be run under ThreadSanitizer,
 * too.
 */
#include "support/node_tests.h"

#include <atomic>
#include <memory>
#include <thread>

namespace {

using namespace pcl_ext::nodes::test;

constexpr std::size_t stream_count = 6;
constexpr std::size_t frame_count = 25;

std::string
nameOf(std::size_t stream)
{
  return "stream " + std::to_string(stream);
}

std::vector<CodedStream>
manyStreams()
{
  std::vector<CodedStream> streams;
  for (std::size_t i = 0; i < stream_count; ++i)
    streams.push_back(streamOf(frame_count, 10, i + 1));
  return streams;
}

void
sendFromThreads(CentralNode& node, const std::vector<CodedStream>& streams)
{
  std::vector<std::thread> senders;
  for (std::size_t i = 0; i < streams.size(); ++i)
    senders.emplace_back([&, i] {
      for (const Bytes& frame : streams[i].frames)
        send(node, nameOf(i), frame);
    });
  for (std::thread& sender : senders)
    sender.join();
}

CentralNodeSettings
settingsOfManyThreads()
{
  CentralNodeSettings settings = centralSettings();
  settings.threads = 4;
  settings.max_waiting_frames = stream_count * frame_count;
  // Independent of the speed of the machine.
  settings.max_merge_age = Time::max();
  return settings;
}

class Repeating {
public:
  template <typename WorkT>
  explicit Repeating(WorkT work)
  : thread_([this, work] {
    do
      work();
    while (!shall_stop_);
  })
  {}

  ~Repeating()
  {
    shall_stop_ = true;
    thread_.join();
  }

private:
  std::atomic<bool> shall_stop_{false};
  std::thread thread_; // uses what is above
};

void
expectWholeStream(const std::vector<RecordedFrame>& recorded, const CodedStream& stream)
{
  ASSERT_EQ(recorded.size(), stream.frames.size());
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    EXPECT_EQ(recorded[i].code, CompressionCode::Ok);
    expectSameFrame(recorded[i].voxels, stream.decoded[i]);
  }
}

constexpr float threshold = 3.0f;

/** \brief Frames are filtered independently, so that a reset of the filter has no
 * effect. */
VoxelOutlierRemovalSettings
removalWithoutHistory()
{
  return {pcl_ext::PointsUnit{{false}}};
}

/** \brief The same where each frame may have been denoised.
 * \param[in] remove denoises a frame and returns the number of voxels removed
 */
template <typename RemoveT>
void
expectWholeStreamOrFiltered(const std::vector<RecordedFrame>& recorded,
                            const CodedStream& stream,
                            RemoveT remove)
{
  CodedStream filtered = stream;
  ASSERT_EQ(recorded.size(), stream.frames.size());
  for (std::size_t i = 0; i < recorded.size(); ++i)
    if (recorded[i].voxels.size() != stream.decoded[i].size()) {
      EXPECT_GT(remove(filtered.decoded[i]), 0u);
    }
  expectWholeStream(recorded, filtered);
}

TEST(CentralNodeThreads, FramesComeInOrderOneAtATimeWhateverIsCalled)
{
  const std::vector<CodedStream> streams = manyStreams();
  FrameRecorder recorder;
  std::map<std::string, std::atomic<int>> tellers;
  for (std::size_t i = 0; i < stream_count; ++i)
    tellers[nameOf(i)] = 0;
  std::atomic<bool> is_one_at_a_time{true};
  CentralNode node(settingsOfManyThreads(), [&](const ReceivedFrame& frame) {
    std::atomic<int>& count = tellers.at(frame.stream);
    if (++count != 1)
      is_one_at_a_time = false;
    recorder.listener()(frame);
    --count;
  });
  for (std::size_t i = 0; i < stream_count; ++i)
    node.addStream(nameOf(i));
  {
    const Repeating merging([&] {
      VoxelFrame merged;
      node.merge(merged);
      EXPECT_TRUE(isConsistent(merged));
    });
    const Repeating merging_too([&] {
      VoxelFrame merged;
      node.merge(merged);
    });
    const Repeating looking([&] {
      VoxelFrame voxels;
      node.latestVoxels(nameOf(1), voxels);
      EXPECT_EQ(voxels.keys.size(), voxels.intensities.size());
    });
    const Repeating asking([&] {
      for (const StreamHealth& health : node.health()) {
        EXPECT_LE(health.frames_decoded, health.frames_received);
        EXPECT_EQ(health.frames_failed, 0u);
      }
    });
    const Repeating changing([&] {
      node.setMinIntensity(nameOf(2), threshold);
      node.setMinIntensity(nameOf(2), 0.0f);
    });
    const Repeating filtering([&] {
      node.setOutlierRemoval(nameOf(3), removalWithoutHistory());
      node.setOutlierRemoval(nameOf(3), std::nullopt);
    });
    std::atomic<int> added{0};
    const Repeating adding([&] {
      if (added < 200)
        node.addStream("another " + std::to_string(added++));
    });
    const Repeating waiting([&] { node.waitUntilDecoded(); });
    sendFromThreads(node, streams);
    node.waitUntilDecoded();
  }
  EXPECT_TRUE(is_one_at_a_time);
  WorldVoxels expected;
  for (std::size_t i = 0; i < stream_count; ++i) {
    const std::vector<RecordedFrame> recorded = recorder.frames(nameOf(i));
    if (i == 2)
      expectWholeStreamOrFiltered(recorded, streams[i], [](VoxelFrame& frame) {
        return removeVoxelsBelow(frame, threshold);
      });
    else if (i == 3)
      expectWholeStreamOrFiltered(recorded, streams[i], [](VoxelFrame& frame) {
        return VoxelOutlierRemoval(removalWithoutHistory()).filter(frame).removed;
      });
    else
      expectWholeStream(recorded, streams[i]);
    addVoxels(recorded.back().voxels, 0.04, expected);
  }
  VoxelFrame merged;
  node.merge(merged);
  EXPECT_EQ(worldVoxels(merged), expected);
}

TEST(CentralNodeThreads, TheListenerMayCallTheNode)
{
  const CodedStream stream = streamOf(frame_count);
  FrameRecorder recorder;
  std::unique_ptr<CentralNode> node;
  std::atomic<std::size_t> merged_voxels{0};
  node = std::make_unique<CentralNode>(
      settingsOfManyThreads(), [&](const ReceivedFrame& frame) {
        recorder.listener()(frame);
        if (frame.stream == "relayed")
          return;
        // Each frame is sent on to another stream.
        const std::size_t index = recorder.frames("first").size() - 1;
        node->addStream("relayed");
        send(*node, "relayed", stream.frames[index]);
        VoxelFrame voxels;
        node->latestVoxels("first", voxels);
        expectSameFrame(voxels, stream.decoded[index]);
        node->merge(voxels);
        merged_voxels += voxels.size();
        node->setMinIntensity("first", 0.0f);
        node->setOutlierRemoval("first", std::nullopt);
        EXPECT_EQ(node->health().size(), 2u);
      });
  node->addStream("first");
  for (const Bytes& frame : stream.frames)
    send(*node, "first", frame);
  node->waitUntilDecoded();
  expectWholeStream(recorder.frames("first"), stream);
  expectWholeStream(recorder.frames("relayed"), stream);
  EXPECT_GT(merged_voxels, 0u);
}

TEST(CentralNodeThreads, DestructionWaitsForTheFramesThatWait)
{
  const std::vector<CodedStream> streams = manyStreams();
  FrameRecorder recorder;
  Gate gate;
  auto node = std::make_unique<CentralNode>(settingsOfManyThreads(),
                                            [&](const ReceivedFrame& frame) {
                                              gate.pass();
                                              recorder.listener()(frame);
                                            });
  for (std::size_t i = 0; i < stream_count; ++i) {
    node->addStream(nameOf(i));
    for (const Bytes& frame : streams[i].frames)
      send(*node, nameOf(i), frame);
  }
  gate.waitForArrivals(1);
  std::thread destroyer([&] { node.reset(); });
  gate.open();
  destroyer.join();
  for (std::size_t i = 0; i < stream_count; ++i)
    expectWholeStream(recorder.frames(nameOf(i)), streams[i]);
}

TEST(CentralNodeThreads, FramesOfOneStreamFromManyThreadsAreAllCounted)
{
  const CodedStream stream = streamOf(8, 1); // I-frames, which come in any order
  CentralNodeSettings settings = settingsOfManyThreads();
  settings.max_waiting_frames = 2;
  FrameRecorder recorder;
  CentralNode node(settings, recorder.listener());
  node.addStream("a");
  std::atomic<std::size_t> taken{0};
  std::vector<std::thread> senders;
  for (int i = 0; i < 4; ++i)
    senders.emplace_back([&] {
      for (const Bytes& frame : stream.frames)
        taken += node.receive("a", frame).ok() ? 1 : 0;
      node.receive("a", Bytes(3, 1));
    });
  for (std::thread& sender : senders)
    sender.join();
  node.waitUntilDecoded();
  const StreamHealth health = onlyHealth(node);
  EXPECT_EQ(health.frames_received, 4 * 9u);
  const std::size_t good = health.frames_decoded + health.frames_dropped;
  EXPECT_EQ(good, taken);
  EXPECT_EQ(good + health.frames_failed + health.frames_refused, 4 * 9u);
  EXPECT_EQ(recorder.frames("a").size(), good + health.frames_failed);
}

CentralNodeSettings
settingsOfOneThread()
{
  CentralNodeSettings settings = centralSettings();
  settings.threads = 1;
  return settings;
}

TEST(CentralNodeTurns, WhatWaitsCanBeRefused)
{
  const CodedStream stream = streamOf(6);
  Gate gate;
  CentralNode node(settingsOfOneThread(), [&](const ReceivedFrame&) { gate.pass(); });
  node.addStream("a");
  node.addStream("b");
  for (std::size_t i = 0; i < 5; ++i)
    send(node, "a", stream.frames[i]);
  send(node, "b", stream.frames[0]);
  gate.waitForArrivals(1);
  EXPECT_FALSE(node.waitUntilDecoded(Time(0)));
  std::thread refusing([&] { node.refuseWaiting(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  gate.open();
  refusing.join();
  EXPECT_TRUE(node.waitUntilDecoded(Time(0)));
  std::vector<StreamHealth> health = node.health();
  EXPECT_EQ(health[0].frames_decoded + health[0].frames_refused, 5u);
  EXPECT_GE(health[0].frames_decoded, 1u);
  EXPECT_EQ(health[1].frames_decoded + health[1].frames_refused, 1u);
  // What comes then is decoded.
  send(node, "b", stream.frames[0]);
  node.waitUntilDecoded();
  EXPECT_GE(node.health()[1].frames_decoded, 1u);
}

TEST(CentralNodeTurns, StreamsTakeTurnsUntilTheirFramesAreDone)
{
  const CodedStream stream = streamOf(6);
  Gate gate;
  std::string served; // written by the one thread, as the numbers
  std::map<std::string, std::uint32_t> last_number;
  CentralNode node(settingsOfOneThread(), [&](const ReceivedFrame& frame) {
    if (frame.stream == "blocked") {
      gate.pass();
      return;
    }
    EXPECT_TRUE(frame.status.ok());
    EXPECT_EQ(frame.statistics.frame_number, ++last_number[frame.stream]);
    served += frame.stream;
  });
  node.addStream("blocked");
  send(node, "blocked", Bytes());
  gate.waitForArrivals(1);
  for (const auto& [name, frames] :
       std::map<std::string, std::size_t>{{"a", 6}, {"b", 2}, {"c", 1}, {"d", 4}}) {
    node.addStream(name);
    for (std::size_t i = 0; i < frames; ++i)
      send(node, name, stream.frames[i]);
  }
  gate.open();
  node.waitUntilDecoded();
  EXPECT_EQ(served,
            "abcd"
            "abd"
            "ad"
            "ad"
            "a"
            "a");
}

} // namespace
