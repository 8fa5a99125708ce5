// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

#include <functional>
#include <limits>

namespace {

using namespace pcl_ext::nodes::test;

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

std::map<std::string, CodedStream>
streamsOfAllKinds()
{
  std::map<std::string, CodedStream> streams;
  const auto add = [&](const std::string& name, Effort effort, StreamFormat format) {
    CodedStream::Settings settings;
    settings.seed = streams.size() + 1;
    settings.effort = effort;
    settings.format = format;
    settings.i_frame_rate = 5;
    if (format == StreamFormat::Version1 && effort == Effort::Small)
      settings.bits = 5;
    streams.emplace(name, settings);
  };
  add("fast", Effort::Fast, StreamFormat::Version1);
  add("balanced", Effort::Balanced, StreamFormat::Version1);
  add("small", Effort::Small, StreamFormat::Version1);
  add("published", Effort::Balanced, StreamFormat::Published);
  return streams;
}

TEST(CentralNode, DecodesEachStreamAsADecoderOfItsOwn)
{
  const std::map<std::string, CodedStream> streams = streamsOfAllKinds();
  FrameRecorder recorder;
  CentralNode node(centralSettings(), recorder.listener());
  for (const auto& [name, stream] : streams)
    expectCode(node.addStream(name), CentralNodeCode::Ok);
  for (std::size_t i = 0; i < 8; ++i)
    for (const auto& [name, stream] : streams)
      send(node, name, stream.frames[i]);
  node.waitUntilDecoded();
  for (const auto& [name, stream] : streams) {
    SCOPED_TRACE(name);
    const std::vector<RecordedFrame> recorded = recorder.frames(name);
    ASSERT_EQ(recorded.size(), stream.frames.size());
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      EXPECT_EQ(recorded[i].code, CompressionCode::Ok);
      expectSameFrame(recorded[i].voxels, stream.decoded[i]);
      EXPECT_EQ(recorded[i].statistics.frame_number, i + 1);
      EXPECT_EQ(recorded[i].statistics.is_i_frame, i % 5 == 0);
      EXPECT_EQ(recorded[i].statistics.bytes, stream.frames[i].size());
      EXPECT_EQ(recorded[i].statistics.voxels, stream.decoded[i].size());
    }
    expectSameFrame(latestVoxels(node, name), stream.decoded.back());
  }
}

using CentralNodeFrames = OneStream;

TEST(CentralNode, LimitsOfTheDecoderHold)
{
  const CodedStream stream = streamOf(1);
  FrameRecorder recorder;
  CentralNodeSettings settings = centralSettings();
  settings.decoder_limits.max_voxels = stream.decoded[0].size() - 1;
  CentralNode node(settings, recorder.listener());
  node.addStream("a");
  sendAndWait(node, "a", stream.frames[0]);
  EXPECT_EQ(recorder.frames("a").at(0).code, CompressionCode::LimitExceeded);
  EXPECT_FALSE(recorder.frames("a").at(0).wants_i_frame); // it would be as large
}

TEST_F(CentralNodeFrames, AChangedThresholdHoldsFromTheNextFrameOn)
{
  const CodedStream stream = streamOf(4);
  node.addStream("b");
  const std::vector<float> thresholds = {0.0f, 4.0f, 2.0f, 0.0f};
  for (std::size_t i = 0; i < 4; ++i) {
    expectCode(node.setMinIntensity("a", thresholds[i]), CentralNodeCode::Ok);
    EXPECT_EQ(latestVoxels(node).size(),
              i == 0 ? 0 : recorder.frames("a").back().voxels.size());
    sendAndWait(node, "a", stream.frames[i]);
    sendAndWait(node, "b", stream.frames[i]);
    VoxelFrame expected = stream.decoded[i];
    removeVoxelsBelow(expected, thresholds[i]);
    expectSameFrame(recorder.frames("a").back().voxels, expected);
    expectSameFrame(recorder.frames("b").back().voxels, stream.decoded[i]);
  }
}

TEST_F(CentralNodeFrames, AreWithoutLayoutIfTheyAreToBePacked)
{
  VoxelFrame frame = streamOf(1).decoded[0];
  pcl_ext::io::MessageLayout layout;
  layout.point_step = 12;
  frame.layout = std::make_shared<pcl_ext::io::MessageLayout>(layout);
  for (const bool is_packed : {false, true}) {
    expectCode(node.setPacked("a", is_packed), CentralNodeCode::Ok);
    sendAndWait(node, "a", coded(frame));
    EXPECT_EQ(recorder.frames("a").back().voxels.layout == nullptr, is_packed);
  }
}

TEST_F(CentralNodeFrames, InvalidCallsAreReported)
{
  CentralNodeStatus status = node.addStream("a", 2.0f);
  expectCode(status, CentralNodeCode::StreamExists);
  EXPECT_EQ(status.message(), "the stream 'a' exists already");
  status = node.addStream("");
  expectCode(status, CentralNodeCode::InvalidSettings);
  EXPECT_EQ(status.message(), "the name of a stream is empty");
  status = node.addStream("b", nan_value);
  expectCode(status, CentralNodeCode::InvalidSettings);
  EXPECT_EQ(status.message(), "min_intensity is nan; it must be a number");
  status = node.setMinIntensity("a", nan_value);
  expectCode(status, CentralNodeCode::InvalidSettings);
  for (const std::string name : {"b", "A", "a "}) {
    const std::string message = "there is no stream '" + name + "'";
    status = node.setMinIntensity(name, 1.0f);
    expectCode(status, CentralNodeCode::UnknownStream);
    EXPECT_EQ(status.message(), message);
    expectCode(node.setPacked(name, true), CentralNodeCode::UnknownStream);
    status = node.receive(name, streamOf(1).frames[0]);
    expectCode(status, CentralNodeCode::UnknownStream);
    EXPECT_EQ(status.message(), message);
  }
  node.waitUntilDecoded();
  EXPECT_EQ(node.health().size(), 1u);
  EXPECT_EQ(onlyHealth(node).frames_received, 0u);
}

TEST_F(CentralNodeFrames, LatestVoxelsOfAStreamThatHasNoneAreEmpty)
{
  for (const std::string name : {"a", "unknown"}) {
    VoxelFrame voxels = streamOf(1).decoded[0];
    node.latestVoxels(name, voxels);
    EXPECT_EQ(voxels.size(), 0u);
    EXPECT_TRUE(voxels.intensities.empty());
  }
}

TEST_F(CentralNodeFrames, VoxelsOfAClockThatWasSetBackAreNotMerged)
{
  clock.set(100s);
  sendFrames(streamOf(1), {0});
  VoxelFrame voxels;
  clock.set(10s);
  node.merge(voxels);
  EXPECT_EQ(voxels.size(), 0u);
}

void
expectInvalid(const CentralNodeSettings& settings, const std::string& message)
{
  FrameRecorder recorder;
  CentralNode node(settings, recorder.listener());
  const CentralNodeStatus status = node.settingsStatus();
  expectCode(status, CentralNodeCode::InvalidSettings);
  EXPECT_EQ(status.message(), message);
  EXPECT_EQ(node.addStream("a").message(), message);
  EXPECT_EQ(node.setMinIntensity("a", 1.0f).message(), message);
  const CodedStream stream = streamOf(1);
  EXPECT_EQ(node.receive("a", stream.frames[0]).message(), message);
  node.waitUntilDecoded();
  EXPECT_TRUE(recorder.frames("a").empty());
  EXPECT_TRUE(node.health().empty());
  VoxelFrame voxels = stream.decoded[0];
  node.latestVoxels("a", voxels);
  EXPECT_EQ(voxels.size(), 0u);
  voxels = stream.decoded[0];
  node.merge(voxels);
  EXPECT_EQ(voxels.size(), 0u);
}

TEST(CentralNodeSettings, AreCheckedOneByOne)
{
  expectCode(CentralNode(centralSettings()).settingsStatus(), CentralNodeCode::Ok);
  expectCode(CentralNode(CentralNodeSettings()).settingsStatus(), CentralNodeCode::Ok);
  const std::vector<std::pair<std::function<void(CentralNodeSettings&)>, std::string>>
      cases = {{[](auto& settings) { settings.resolution = 0.0; },
                "resolution is 0; it must be 1e-06 to 1e+06 m"},
               {[](auto& settings) { settings.resolution = double{nan_value}; },
                "resolution is nan; it must be 1e-06 to 1e+06 m"},
               {[](auto& settings) { settings.threads = 1025; },
                "threads is 1025; it must be 0 to 1024"},
               {[](auto& settings) { settings.max_waiting_frames = 0; },
                "max_waiting_frames is 0; it must be 1 or more"},
               {[](auto& settings) { settings.max_merge_age = Time(0); },
                "max_merge_age is 0; it must be above 0 seconds"},
               {[](auto& settings) { settings.max_merge_age = -1500ms; },
                "max_merge_age is -1.5; it must be above 0 seconds"},
               {[](auto& settings) { settings.decoder_limits.max_voxels = 0; },
                "decoder_limits.max_voxels is 0; it must be above 0"},
               {[](auto& settings) { settings.decoder_limits.max_frame_bytes = 0; },
                "decoder_limits.max_frame_bytes is 0; it must be above 0"},
               {[](auto& settings) { settings.clock = nullptr; },
                "clock is empty; it must be set"}};
  for (const auto& [change, message] : cases) {
    CentralNodeSettings settings = centralSettings();
    change(settings);
    expectInvalid(settings, message);
  }
}

} // namespace
