// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

#include <new>

namespace {

using namespace pcl_ext::nodes::test;
using pcl_ext::test::failEachAllocation;

constexpr float min_intensity = 2.0f;
constexpr unsigned int i_frame_rate = 6;

/** \brief With a history, so that a wrong one is noticed. */
VoxelOutlierRemovalSettings
removalSettings()
{
  return {pcl_ext::PointsUnit(), 1.0f};
}

/** \brief A node of one thread that is blocked until goOn(). Its stream "a" is
 * denoised, its stream "b" is not. */
class BlockedNode {
public:
  BlockedNode()
  {
    node.addStream("a", min_intensity);
    node.setOutlierRemoval("a", removalSettings());
    node.addStream("b");
    node.addStream("blocked");
  }

  void
  hold()
  {
    send(node, "blocked", Bytes());
    gate_.waitForArrivals(1);
  }

  void
  goOn()
  {
    goes_on_ = true;
    gate_.open();
    node.waitUntilDecoded();
  }

  StreamHealth
  health(const std::string& stream) const
  {
    for (const StreamHealth& health : node.health())
      if (health.name == stream)
        return health;
    return {};
  }

  FrameRecorder recorder;

private:
  static CentralNodeSettings
  settingsOfOneThread()
  {
    CentralNodeSettings settings = centralSettings();
    settings.threads = 1;
    settings.max_merge_age = Time::max();
    return settings;
  }

  Gate gate_;
  bool goes_on_ = false;

public:
  CentralNode node{settingsOfOneThread(), [this](const ReceivedFrame& frame) {
                     const Exemption exemption;
                     if (frame.stream == "blocked") {
                       gate_.pass();
                       return;
                     }
                     recorder.listener()(frame);
                     // Uses memory that Boost.Asio keeps for the next handler.
                     if (goes_on_)
                       send(node, "blocked", Bytes());
                   }}; // its thread uses what is above
};

/** \brief The possible states of a filter after a frame in which memory ran out. */
enum class FilterSaw { Frame, NoFrame, BeganAnew };

/** \brief Whether the frames of "a" are those of a filter in one of these states. */
bool
isShown(const std::vector<RecordedFrame>& recorded,
        const CodedStream& stream,
        FilterSaw saw)
{
  VoxelOutlierRemoval removal(removalSettings());
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    VoxelFrame expected = stream.decoded.at(i);
    const bool is_ok = recorded[i].code == CompressionCode::Ok;
    const bool ran_out = recorded[i].code == CompressionCode::OutOfMemory;
    if (is_ok || (ran_out && saw == FilterSaw::Frame)) {
      EXPECT_TRUE(removal.filter(expected).ok());
    }
    if (ran_out && saw == FilterSaw::BeganAnew)
      removal.reset();
    removeVoxelsBelow(expected, min_intensity);
    if (is_ok && (recorded[i].voxels.keys != expected.keys ||
                  recorded[i].voxels.intensities != expected.intensities))
      return false;
  }
  return true;
}

void
expectShownRight(const BlockedNode& held, const CodedStream& stream)
{
  const std::vector<RecordedFrame> recorded_a = held.recorder.frames("a");
  EXPECT_TRUE(isShown(recorded_a, stream, FilterSaw::Frame) ||
              isShown(recorded_a, stream, FilterSaw::NoFrame) ||
              isShown(recorded_a, stream, FilterSaw::BeganAnew))
      << held.recorder.outcomes("a");
  const std::vector<RecordedFrame> recorded_b = held.recorder.frames("b");
  for (std::size_t i = 0; i < recorded_b.size(); ++i)
    if (recorded_b[i].code == CompressionCode::Ok)
      expectSameFrame(recorded_b[i].voxels, stream.decoded.at(i));
  for (const std::string name : {"a", "b"}) {
    VoxelFrame last;
    for (const RecordedFrame& recorded : held.recorder.frames(name))
      if (recorded.code == CompressionCode::Ok)
        last = recorded.voxels;
      else {
        EXPECT_EQ(recorded.voxels.size(), 0u);
        EXPECT_EQ(recorded.statistics.voxels, 0u);
      }
    const VoxelFrame latest = latestVoxels(held.node, name);
    EXPECT_EQ(latest.keys, last.keys);
    EXPECT_EQ(latest.intensities, last.intensities);
  }
}

std::size_t
countOf(CompressionCode code, const std::vector<RecordedFrame>& recorded)
{
  return static_cast<std::size_t>(
      std::count_if(recorded.begin(), recorded.end(), [&](const RecordedFrame& frame) {
        return frame.code == code;
      }));
}

void
expectHealth(const BlockedNode& held, const std::string& name, std::size_t frames)
{
  const std::vector<RecordedFrame> recorded = held.recorder.frames(name);
  ASSERT_EQ(recorded.size(), frames);
  const StreamHealth health = held.health(name);
  EXPECT_EQ(health.frames_received, frames);
  EXPECT_EQ(health.frames_decoded, countOf(CompressionCode::Ok, recorded));
  EXPECT_EQ(health.frames_failed, frames - health.frames_decoded);
  EXPECT_EQ(health.frames_refused, 0u);
  EXPECT_EQ(health.frames_lost, 0u);
  EXPECT_EQ(health.i_frame_requests,
            static_cast<std::size_t>(std::count_if(
                recorded.begin(), recorded.end(), [](const RecordedFrame& frame) {
                  return frame.wants_i_frame;
                })));
  // Where memory ran out after the decoder, the next frame does not lack this one.
  for (std::size_t i = 0; i + 1 < frames; ++i)
    if (recorded[i].code == CompressionCode::OutOfMemory) {
      EXPECT_EQ(recorded[i].wants_i_frame, recorded[i + 1].code != CompressionCode::Ok);
    }
  const std::size_t failures = countOf(CompressionCode::OutOfMemory, recorded);
  // A frame that lacks its reference fails with another code.
  EXPECT_EQ(health.frames_failed,
            failures + countOf(CompressionCode::MissingReference, recorded));
  EXPECT_EQ(health.last_failure.message().empty(), failures == 0);
}

/** \brief Has an allocation of the decoding thread fail, among those for two frames of
 * a stream and one of another.
 * \param[in] before frames that were decoded before
 * \return false if there are no so many allocations
 */
bool
failInDecoding(const CodedStream& stream, std::size_t before, std::size_t number)
{
  BlockedNode held;
  for (std::size_t i = 0; i < before; ++i) {
    sendAndWait(held.node, "a", stream.frames[i]);
    sendAndWait(held.node, "b", stream.frames[i]);
  }
  held.hold();
  send(held.node, "a", stream.frames[before]);
  send(held.node, "a", stream.frames[before + 1]);
  send(held.node, "b", stream.frames[before]);
  bool has_failed = false;
  {
    const FailingAllocation failing(number);
    held.goOn();
    has_failed = failing.hasFailed();
  }
  std::size_t failures = 0;
  for (const std::string name : {"a", "b"})
    failures += countOf(CompressionCode::OutOfMemory, held.recorder.frames(name));
  EXPECT_LE(failures, has_failed ? 1u : 0u);
  expectShownRight(held, stream);
  for (std::size_t i = before + 2; i < stream.frames.size(); ++i)
    sendAndWait(held.node, "a", stream.frames[i]);
  for (std::size_t i = before + 1; i < stream.frames.size(); ++i)
    sendAndWait(held.node, "b", stream.frames[i]);
  expectShownRight(held, stream);
  for (const std::string name : {"a", "b"}) {
    expectHealth(held, name, stream.frames.size());
    // At the latest from the next I-frame on.
    const std::vector<RecordedFrame> recorded = held.recorder.frames(name);
    for (std::size_t i = i_frame_rate; i < recorded.size(); ++i)
      EXPECT_EQ(recorded[i].code, CompressionCode::Ok);
    EXPECT_TRUE(held.health(name).in_sync);
  }
  return has_failed;
}

TEST(CentralNodeMemory, FailuresWhileDecodingAreReported)
{
  const CodedStream stream = streamOf(9, i_frame_rate);
  for (const std::size_t before : {0u, 3u}) {
    std::size_t number = 1;
    while (failInDecoding(stream, before, number)) {
      ASSERT_FALSE(HasFailure())
          << "allocation " << number << " behind frame " << before;
      ++number;
    }
    EXPECT_GT(number, 10u);
  }
}

using CentralNodeExceptions = OneStream;

TEST_F(CentralNodeExceptions, AreReportedAsStatus)
{
  const CodedStream stream = streamOf(3);
  sendFrames(stream, {0});
  clock.setBroken(true);
  sendFrames(stream, {1});
  clock.setBroken(false);
  expectSameFrame(latestVoxels(node), stream.decoded[0]);
  const StreamHealth health = onlyHealth(node);
  EXPECT_EQ(health.last_failure.code(), CompressionCode::InputFailed);
  EXPECT_EQ(health.last_failure.message(), "the clock is broken");
  EXPECT_TRUE(health.in_sync);
  // It was decoded, so that the next one does not lack it.
  sendFrames(stream, {2});
  EXPECT_EQ(recorder.outcomes("a"), ".x.");
  EXPECT_EQ(recorder.frames("a").at(1).voxels.size(), 0u);
  expectSameFrame(recorder.frames("a").at(2).voxels, stream.decoded[2]);
}

TEST(CentralNodeMemory, FailuresInReceiveRefuseTheFrame)
{
  const CodedStream stream = streamOf(14, i_frame_rate);
  for (std::size_t refused = 0; refused < 12; ++refused) {
    BlockedNode held;
    held.hold();
    for (std::size_t i = 0; i < refused; ++i)
      send(held.node, "a", stream.frames[i]);
    std::size_t number = 1;
    for (bool has_failed = true; has_failed; ++number) {
      Bytes bytes = stream.frames[refused];
      const FailingAllocation failing(number);
      const CentralNodeStatus status = held.node.receive("a", std::move(bytes));
      const Exemption exemption;
      has_failed = failing.hasFailed();
      expectCode(status,
                 has_failed ? CentralNodeCode::OutOfMemory : CentralNodeCode::Ok);
    }
    const std::size_t refusals = number - 2;
    // The first has the stream ask for a turn; later ones at times need a new queue.
    if (refused == 0) {
      EXPECT_GT(refusals, 0u);
    }
    for (std::size_t i = refused + 1; i < 14; ++i)
      send(held.node, "a", stream.frames[i]);
    held.goOn();
    EXPECT_EQ(held.recorder.outcomes("a"), "..............");
    expectShownRight(held, stream);
    const StreamHealth health = held.health("a");
    EXPECT_EQ(health.frames_refused, refusals);
    EXPECT_EQ(health.frames_received, 14 + refusals);
    EXPECT_EQ(health.frames_lost, 0u);
  }
}

TEST(CentralNodeMemory, RefusalsNeedNoMemoryForTheirMessage)
{
  CentralNode node(centralSettings());
  const std::string long_name(100, 'n');
  const FailingAllocation failing(1);
  const CentralNodeStatus status = node.receive(long_name, Bytes());
  EXPECT_TRUE(failing.hasFailed());
  expectCode(status, CentralNodeCode::OutOfMemory);
}

TEST(CentralNodeMemory, MergingWithoutMemoryIsAStatusAndLosesNothing)
{
  const CodedStream stream = streamOf(2);
  for (const bool do_later_ones_fail : {false, true}) {
    BlockedNode held;
    for (std::size_t i = 0; i < 2; ++i) {
      sendAndWait(held.node, "b", stream.frames[i]);
      std::size_t number = 1;
      for (bool has_failed = true; has_failed; ++number) {
        VoxelFrame merged = stream.decoded[0];
        std::optional<MergeStatus> status;
        {
          const FailingAllocation failing(number, do_later_ones_fail);
          status = held.node.merge(merged);
          const Exemption exemption;
          has_failed = failing.hasFailed();
        }
        const std::string context = "allocation " + std::to_string(number);
        EXPECT_EQ(status->code(),
                  has_failed ? CentralNodeCode::OutOfMemory : CentralNodeCode::Ok)
            << context;
        EXPECT_EQ(status->streams.empty(), has_failed) << context;
        EXPECT_EQ(worldVoxels(merged),
                  has_failed ? pcl_ext::test::WorldVoxels()
                             : worldVoxels(stream.decoded[i]))
            << context;
        ASSERT_FALSE(HasFailure());
      }
      EXPECT_GT(number, 5u);
    }
  }
}

TEST(CentralNodeMemory, CallsThatThrowLeaveTheNodeUnchanged)
{
  const CodedStream stream = streamOf(4);
  BlockedNode held;
  const std::string name = "a stream whose name is no short one";
  std::optional<CentralNodeStatus> added;
  EXPECT_GT(failEachAllocation([&] { added = held.node.addStream(name); }), 1u);
  expectCode(*added, CentralNodeCode::Ok); // not there already
  for (std::size_t i = 0; i < 4; ++i) {
    sendAndWait(held.node, name, stream.frames[i]);
    VoxelFrame latest;
    std::size_t throws = failEachAllocation([&] {
      try {
        held.node.latestVoxels(name, latest);
      }
      catch (const std::bad_alloc&) {
        EXPECT_EQ(latest.keys.size(), latest.intensities.size());
        throw;
      }
    });
    EXPECT_GT(throws, 0u);
    expectSameFrame(latest, stream.decoded[i]);
    std::vector<StreamHealth> health;
    EXPECT_GT(failEachAllocation([&] { health = held.node.health(); }), 0u);
    EXPECT_EQ(health.at(0).name, "a");
    EXPECT_EQ(health.at(1).name, name);
    EXPECT_EQ(health.at(1).frames_decoded, i + 1);
  }
}

} // namespace
