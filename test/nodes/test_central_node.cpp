/** \file
 * \brief What a CentralNode decodes and denoises, and how it answers to wrong orders.
 */
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>

#include "support/central_streams.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace std::chrono_literals;
using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using pcl_ext::removeFaintVoxels;
using pcl_ext::io::Effort;
using pcl_ext::io::StreamFormat;
using pcl_ext::io::test::expectSameFrame;

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

/** \brief Streams of every effort and format, by name. */
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
  Listener listener;
  CentralNode node(centralSettings(), listener.listener());
  for (const auto& [name, stream] : streams)
    expectCode(node.addStream(name), CentralNodeCode::Ok);
  for (std::size_t i = 0; i < 8; ++i)
    for (const auto& [name, stream] : streams)
      send(node, name, stream.frames[i]);
  node.waitUntilDecoded();
  for (const auto& [name, stream] : streams) {
    SCOPED_TRACE(name);
    const std::vector<HeardFrame> heard = listener.heard(name);
    ASSERT_EQ(heard.size(), stream.frames.size());
    for (std::size_t i = 0; i < heard.size(); ++i) {
      EXPECT_EQ(heard[i].code, CompressionCode::Ok);
      expectSameFrame(heard[i].voxels, stream.decoded[i]);
      EXPECT_EQ(heard[i].statistics.frame_number, i + 1);
      EXPECT_EQ(heard[i].statistics.is_i_frame, i % 5 == 0);
      EXPECT_EQ(heard[i].statistics.bytes, stream.frames[i].size());
      EXPECT_EQ(heard[i].statistics.voxels, stream.decoded[i].size());
    }
    expectSameFrame(latestVoxels(node, name), stream.decoded.back());
  }
}

TEST(CentralNode, DoesWithoutAListener)
{
  const CodedStream stream = streamOf(3);
  CentralNode node(centralSettings());
  expectCode(node.addStream("a"), CentralNodeCode::Ok);
  send(node, "a", stream.frames[1]); // fails
  for (const Bytes& frame : stream.frames)
    send(node, "a", frame);
  node.waitUntilDecoded();
  expectSameFrame(latestVoxels(node), stream.decoded[2]);
}

TEST(CentralNode, AFrameThatFailsHasNoVoxelsAndLeavesTheLatest)
{
  const CodedStream stream = streamOf(4);
  Listener listener;
  CentralNode node(centralSettings(), listener.listener());
  node.addStream("a");
  sendAndWait(node, "a", stream.frames[0]);
  sendAndWait(node, "a", stream.frames[2]);
  const std::vector<HeardFrame> heard = listener.heard("a");
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard[1].code, CompressionCode::MissingReference);
  EXPECT_EQ(heard[1].voxels.size(), 0u);
  EXPECT_EQ(heard[1].statistics.voxels, 0u); // not those of the frame before
  EXPECT_EQ(heard[1].statistics.bytes, 0u);
  EXPECT_EQ(heard[1].statistics.frame_number, 0u);
  EXPECT_TRUE(heard[1].wants_i_frame);
  expectSameFrame(latestVoxels(node), stream.decoded[0]);
  // The frame in between was only late: the stream goes on.
  sendAndWait(node, "a", stream.frames[1]);
  sendAndWait(node, "a", stream.frames[2]);
  expectSameFrame(latestVoxels(node), stream.decoded[2]);
}

TEST(CentralNode, AnyBytesAreSafeAndTheStreamGoesOn)
{
  const CodedStream stream = streamOf(3);
  std::mt19937_64 random(1);
  Listener listener;
  CentralNodeSettings settings = centralSettings();
  settings.max_waiting_frames = 10000;
  CentralNode node(settings, listener.listener());
  node.addStream("a");
  send(node, "a", stream.frames[0]);
  std::size_t sent = 0;
  for (std::size_t size = 0; size < stream.frames[1].size(); ++size) {
    Bytes cut(stream.frames[1].begin(),
              stream.frames[1].begin() + static_cast<std::ptrdiff_t>(size));
    send(node, "a", cut);
    Bytes damaged = stream.frames[1];
    damaged[size] = static_cast<std::uint8_t>(damaged[size] ^ 1u << (size % 8));
    send(node, "a", damaged);
    sent += 2;
  }
  for (std::size_t i = 0; i < 100; ++i, ++sent) {
    Bytes rubbish(i);
    for (std::uint8_t& byte : rubbish)
      byte = static_cast<std::uint8_t>(random());
    send(node, "a", rubbish);
  }
  send(node, "a", stream.frames[1]);
  send(node, "a", stream.frames[2]);
  node.waitUntilDecoded();
  const std::vector<HeardFrame> heard = listener.heard("a");
  ASSERT_EQ(heard.size(), sent + 3);
  for (std::size_t i = 1; i <= sent; ++i)
    EXPECT_NE(heard[i].code, CompressionCode::Ok) << "message " << i;
  expectSameFrame(heard[sent + 1].voxels, stream.decoded[1]);
  expectSameFrame(heard[sent + 2].voxels, stream.decoded[2]);
}

TEST(CentralNode, LimitsOfTheDecoderHold)
{
  const CodedStream stream = streamOf(1);
  Listener listener;
  CentralNodeSettings settings = centralSettings();
  settings.decoder_limits.max_voxels = stream.decoded[0].size() - 1;
  CentralNode node(settings, listener.listener());
  node.addStream("a");
  sendAndWait(node, "a", stream.frames[0]);
  EXPECT_EQ(listener.heard("a").at(0).code, CompressionCode::LimitExceeded);
  EXPECT_FALSE(listener.heard("a").at(0).wants_i_frame); // which would be as large
}

TEST(CentralNode, ToldStampsAreThoseGivenElseThoseCarriedElseNone)
{
  CodedStream::Settings with_stamps;
  with_stamps.frames = 2;
  with_stamps.first_stamp = 1700000000000000u;
  const CodedStream carrying(with_stamps);
  const CodedStream bare = streamOf(2);
  Listener listener;
  CentralNode node(centralSettings(), listener.listener());
  node.addStream("carrying");
  node.addStream("bare");
  sendAndWait(node, "carrying", carrying.frames[0]);
  sendAndWait(node, "carrying", carrying.frames[1], 17ns);
  sendAndWait(node, "bare", bare.frames[0]);
  sendAndWait(node, "bare", bare.frames[1], 19s);
  EXPECT_EQ(listener.heard("carrying").at(0).stamp, Time(1700000000s));
  EXPECT_EQ(listener.heard("carrying").at(1).stamp, Time(17ns));
  EXPECT_EQ(listener.heard("bare").at(0).stamp, Time(0));
  EXPECT_EQ(listener.heard("bare").at(1).stamp, Time(19s));
}

TEST(CentralNodeNoise, IsRemovedByTheThresholdOfEachStream)
{
  const CodedStream stream = streamOf(4);
  const std::map<std::string, float> thresholds = {
      {"all", 0.0f}, {"below", -3.0f}, {"some", 3.0f}, {"none", 300.0f}};
  Listener listener;
  CentralNode node(centralSettings(), listener.listener());
  for (const auto& [name, threshold] : thresholds)
    expectCode(node.addStream(name, threshold), CentralNodeCode::Ok);
  for (std::size_t i = 0; i < 4; ++i)
    for (const auto& [name, threshold] : thresholds)
      send(node, name, stream.frames[i]);
  node.waitUntilDecoded();
  const std::vector<StreamHealth> health = node.health();
  for (const auto& [name, threshold] : thresholds) {
    SCOPED_TRACE(name);
    VoxelFrame expected;
    for (std::size_t i = 0; i < 4; ++i) {
      expected = stream.decoded[i];
      const std::size_t removed = removeFaintVoxels(expected, threshold);
      EXPECT_EQ(removed > 0, threshold > 0.0f);
      EXPECT_EQ(expected.size() > 0, threshold < 100.0f);
      const HeardFrame heard = listener.heard(name).at(i);
      expectSameFrame(heard.voxels, expected);
      EXPECT_EQ(heard.statistics.voxels, stream.decoded[i].size());
    }
    expectSameFrame(latestVoxels(node, name), expected);
    const auto index = static_cast<std::size_t>(
        std::distance(thresholds.begin(), thresholds.find(name)));
    EXPECT_EQ(health.at(index).voxels, stream.decoded[3].size());
    EXPECT_EQ(health.at(index).kept_voxels, expected.size());
  }
}

TEST(CentralNodeNoise, AChangedThresholdHoldsFromTheNextFrameOn)
{
  const CodedStream stream = streamOf(4);
  Listener listener;
  CentralNode node(centralSettings(), listener.listener());
  node.addStream("a");
  node.addStream("b");
  const std::vector<float> thresholds = {0.0f, 4.0f, 2.0f, 0.0f};
  for (std::size_t i = 0; i < 4; ++i) {
    expectCode(node.setMinIntensity("a", thresholds[i]), CentralNodeCode::Ok);
    EXPECT_EQ(latestVoxels(node).size(),
              i == 0 ? 0 : listener.heard("a").back().voxels.size());
    sendAndWait(node, "a", stream.frames[i]);
    sendAndWait(node, "b", stream.frames[i]);
    VoxelFrame expected = stream.decoded[i];
    removeFaintVoxels(expected, thresholds[i]);
    expectSameFrame(listener.heard("a").back().voxels, expected);
    expectSameFrame(listener.heard("b").back().voxels, stream.decoded[i]);
  }
}

TEST(CentralNodeOrders, WrongOnesAreToldApart)
{
  CentralNode node(centralSettings());
  expectCode(node.addStream("a"), CentralNodeCode::Ok);

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
    status = node.receive(name, streamOf(1).frames[0]);
    expectCode(status, CentralNodeCode::UnknownStream);
    EXPECT_EQ(status.message(), message);
  }
  node.waitUntilDecoded();
  EXPECT_EQ(node.health().size(), 1u);
  EXPECT_EQ(onlyHealth(node).frames_received, 0u);
}

TEST(CentralNodeOrders, LatestVoxelsOfAStreamThatHasNoneAreEmpty)
{
  CentralNode node(centralSettings());
  node.addStream("a");
  for (const std::string name : {"a", "unknown"}) {
    VoxelFrame voxels = streamOf(1).decoded[0];
    node.latestVoxels(name, voxels);
    EXPECT_EQ(voxels.size(), 0u);
    EXPECT_TRUE(voxels.intensities.empty());
  }
}

TEST(CentralNodeOrders, LatestVoxelsStayWhenTheyAreTooOldToMerge)
{
  const CodedStream stream = streamOf(1);
  FakeClock clock;
  CentralNodeSettings settings = settingsWith(clock);
  settings.max_merge_age = 1500ms;
  CentralNode node(settings);
  node.addStream("a");
  clock.set(100s);
  sendAndWait(node, "a", stream.frames[0]);
  VoxelFrame voxels;
  clock.set(101500ms);
  node.merge(voxels);
  EXPECT_EQ(voxels.size(), stream.decoded[0].size());
  clock.set(101500ms + 1ns);
  node.merge(voxels);
  EXPECT_EQ(voxels.size(), 0u);
  const std::optional<LatestFrame> latest = node.latestVoxels("a", voxels);
  expectSameFrame(voxels, stream.decoded[0]);
  ASSERT_TRUE(latest.has_value());
  EXPECT_EQ(latest->number, 1u);
}

TEST(CentralNodeOrders, AClockThatIsSetBackRevivesNoVoxels)
{
  const CodedStream stream = streamOf(1);
  FakeClock clock;
  CentralNode node(settingsWith(clock));
  node.addStream("a");
  clock.set(100s);
  sendAndWait(node, "a", stream.frames[0]);
  VoxelFrame voxels;
  clock.set(10s);
  node.merge(voxels);
  EXPECT_EQ(voxels.size(), 0u);
}

TEST(CentralNodeOrders, ServesHundredsOfStreams)
{
  const CodedStream stream = streamOf(2);
  Listener listener;
  CentralNode node(centralSettings(), listener.listener());
  std::vector<std::string> names;
  for (int i = 0; i < 500; ++i)
    names.push_back("sensor " + std::to_string(1000 + i));
  for (const std::string& name : names)
    expectCode(node.addStream(name), CentralNodeCode::Ok);
  for (const Bytes& frame : stream.frames)
    for (const std::string& name : names)
      send(node, name, frame);
  node.waitUntilDecoded();
  const std::vector<StreamHealth> health = node.health();
  ASSERT_EQ(health.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(health[i].name, names[i]);
    EXPECT_EQ(health[i].frames_decoded, 2u);
    EXPECT_EQ(listener.course(names[i]), "..");
  }
}

/** \brief Expects settings to be refused with a message, and every call to be safe. */
void
expectInvalid(const std::function<void(CentralNodeSettings&)>& spoil,
              const std::string& message)
{
  CentralNodeSettings settings = centralSettings();
  spoil(settings);
  Listener listener;
  CentralNode node(settings, listener.listener());
  const CentralNodeStatus status = node.settingsStatus();
  expectCode(status, CentralNodeCode::InvalidSettings);
  EXPECT_EQ(status.message(), message);
  EXPECT_EQ(node.addStream("a").message(), message);
  EXPECT_EQ(node.setMinIntensity("a", 1.0f).message(), message);
  EXPECT_EQ(node.receive("a", streamOf(1).frames[0]).message(), message);
  node.waitUntilDecoded();
  EXPECT_TRUE(listener.heard("a").empty());
  EXPECT_TRUE(node.health().empty());
  VoxelFrame voxels = streamOf(1).decoded[0];
  node.latestVoxels("a", voxels);
  EXPECT_EQ(voxels.size(), 0u);
  voxels = streamOf(1).decoded[0];
  node.merge(voxels);
  EXPECT_EQ(voxels.size(), 0u);
}

TEST(CentralNodeSettings, AreCheckedOneByOne)
{
  expectCode(CentralNode(centralSettings()).settingsStatus(), CentralNodeCode::Ok);
  expectCode(CentralNode(CentralNodeSettings()).settingsStatus(), CentralNodeCode::Ok);
  expectInvalid([](auto& settings) { settings.resolution = 0.0; },
                "resolution is 0; it must be 1e-6 to 1e6 metres");
  expectInvalid([](auto& settings) { settings.resolution = double{nan_value}; },
                "resolution is nan; it must be 1e-6 to 1e6 metres");
  expectInvalid([](auto& settings) { settings.threads = 1025; },
                "threads is 1025; it must be 0 to 1024");
  expectInvalid([](auto& settings) { settings.max_waiting_frames = 0; },
                "max_waiting_frames is 0; it must be 1 or more");
  expectInvalid([](auto& settings) { settings.max_merge_age = Time(0); },
                "max_merge_age is 0; it must be above 0 seconds");
  expectInvalid([](auto& settings) { settings.max_merge_age = -1500ms; },
                "max_merge_age is -1.5; it must be above 0 seconds");
  expectInvalid([](auto& settings) { settings.decoder_limits.max_voxels = 0; },
                "decoder_limits.max_voxels is 0; it must be above 0");
  expectInvalid([](auto& settings) { settings.decoder_limits.max_frame_bytes = 0; },
                "decoder_limits.max_frame_bytes is 0; it must be above 0");
  expectInvalid([](auto& settings) { settings.clock = nullptr; },
                "clock is empty; it must be set");
}

} // namespace
