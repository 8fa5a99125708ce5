// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

#include <cmath>

namespace {

using namespace pcl_ext::nodes::test;

constexpr double resolution = 0.04;

WorldVoxels
mergedVoxels(CentralNode& node)
{
  VoxelFrame merged = streamOf(1).decoded[0];
  node.merge(merged);
  EXPECT_TRUE(isConsistent(merged));
  EXPECT_EQ(merged.grid.resolution, resolution);
  EXPECT_EQ(merged.grid.origin, (std::array<double, 3>{}));
  EXPECT_FALSE(merged.depth_model.has_value());
  return worldVoxels(merged);
}

/** \brief Streams on grids of other resolutions and other lattices, but none with the
 * centre of a voxel on a face of the common grid, where rounding would decide. */
std::map<std::string, CodedStream>
streamsOfManyGrids()
{
  std::map<std::string, CodedStream> streams;
  const auto add = [&](double edge, StreamFormat format, std::array<double, 3> origin) {
    CodedStream::Settings settings;
    settings.seed = streams.size() + 1;
    settings.frames = 3;
    settings.resolution = edge;
    settings.format = format;
    settings.origin = origin;
    streams.emplace("stream " + std::to_string(streams.size()), settings);
  };
  add(0.04, StreamFormat::Version1, {});
  add(0.04, StreamFormat::Version1, {});
  add(0.02, StreamFormat::Version1, {});
  add(0.06, StreamFormat::Version1, {});
  add(0.04, StreamFormat::Published, {0.013, -0.011, 5.007});
  add(0.01, StreamFormat::Published, {-0.333, 0.251, 0.002});
  return streams;
}

using Merging = OneStream;

TEST_F(Merging, SumsTheVoxelsOfAllStreamsOnTheCommonGrid)
{
  const std::map<std::string, CodedStream> streams = streamsOfManyGrids();
  for (const auto& [name, stream] : streams)
    node.addStream(name);
  for (std::size_t i = 0; i < 3; ++i) {
    std::size_t voxels = 0;
    WorldVoxels expected;
    for (const auto& [name, stream] : streams) {
      sendAndWait(node, name, stream.frames[i]);
      addVoxels(stream.decoded[i], resolution, expected);
      voxels += stream.decoded[i].size();
    }
    ASSERT_LT(expected.size(), voxels); // some are summed
    EXPECT_EQ(mergedVoxels(node), expected);
    EXPECT_EQ(mergedVoxels(node), expected); // again
  }
}

/** \brief Expects each voxel of a stream to be in a voxel of its own, by the index of the
 * lower corner on all axes. */
template <typename IndexOf>
void
expectOneToOne(const CodedStream& stream, IndexOf index_of)
{
  CentralNode node(centralSettings());
  node.addStream("a");
  sendAndWait(node, "a", stream.frames[0]);
  const VoxelFrame& frame = stream.decoded[0];
  WorldVoxels expected;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const auto index = pcl_ext::io::test::latticeIndex(frame, i);
    expected[{index_of(index[0]), index_of(index[1]), index_of(index[2])}] =
        static_cast<double>(frame.intensity_scale.value(frame.intensities[i]));
  }
  ASSERT_EQ(expected.size(), frame.size());
  EXPECT_EQ(mergedVoxels(node), expected);
}

TEST_F(Merging, ACentreOnAFaceBelongsToTheVoxelAbove)
{
  // Where PCL anchors its lattice for boxes that are an odd number of voxels wide.
  CodedStream::Settings settings;
  settings.frames = 1;
  settings.format = StreamFormat::Published;
  // Its indices begin at the corner of the grid, 32 voxels below the origin.
  // The farthest ones are rounded the most.
  for (const int voxels : {-900'000, -450, -7, 0, 13, 900, 900'000}) {
    const double origin = (voxels + 0.5) * resolution;
    settings.origin = {origin, origin, origin};
    expectOneToOne(CodedStream(settings),
                   [&](std::int64_t index) { return index - 32 + voxels + 1; });
  }
  // Voxels of twice the size have the middle between two in their own.
  settings.format = StreamFormat::Version1;
  settings.origin = {};
  settings.resolution = 2.0 * resolution;
  expectOneToOne(CodedStream(settings),
                 [](std::int64_t index) { return 2 * index + 1; });
}

TEST(MaxMergeAge, StreamsTakePartUntilTheyAreTooOld)
{
  const CodedStream first = streamOf(2, 30, 1);
  const CodedStream second = streamOf(3, 30, 2);
  const WorldVoxels of_first = worldVoxels(first.decoded[0]);
  const WorldVoxels of_second = worldVoxels(second.decoded[0]);
  WorldVoxels of_both = of_first;
  addVoxels(second.decoded[0], resolution, of_both);
  FakeClock clock;
  CentralNodeSettings settings = settingsWith(clock);
  settings.max_merge_age = 2s;
  CentralNode node(settings);
  node.addStream("first");
  node.addStream("second");
  clock.set(10s);
  sendAndWait(node, "first", first.frames[0]);
  clock.set(11s);
  sendAndWait(node, "second", second.frames[0]);
  EXPECT_EQ(mergedVoxels(node), of_both);
  sendAndWait(node, "second", second.frames[2]); // fails, and changes nothing
  clock.set(12s);
  EXPECT_EQ(mergedVoxels(node), of_both);
  clock.set(12s + 1ns);
  EXPECT_EQ(mergedVoxels(node), of_second);
  // A frame that fails keeps nothing alive.
  sendAndWait(node, "first", Bytes(20, 7));
  EXPECT_EQ(mergedVoxels(node), of_second);
  clock.set(13s + 1ns);
  EXPECT_TRUE(mergedVoxels(node).empty());
  // They stay the latest of their stream.
  VoxelFrame latest;
  EXPECT_EQ(node.latestVoxels("second", latest)->number, 1u);
  pcl_ext::io::test::expectSameFrame(latest, second.decoded[0]);
  sendAndWait(node, "first", first.frames[1]);
  EXPECT_EQ(mergedVoxels(node), worldVoxels(first.decoded[1]));
}

TEST(MaxMergeAge, MayBeUnlimited)
{
  const CodedStream stream = streamOf(1);
  FakeClock clock;
  CentralNodeSettings settings = settingsWith(clock);
  settings.max_merge_age = Time::max();
  CentralNode node(settings);
  node.addStream("a");
  sendAndWait(node, "a", stream.frames[0]);
  clock.set(1700000000s);
  EXPECT_EQ(mergedVoxels(node), worldVoxels(stream.decoded[0]));
}

TEST_F(Merging, CountsAreExactUpToTheEndOfSixteenBits)
{
  VoxelFrame frame = pcl_ext::io::test::emptyFrame(5);
  frame.keys = {0, 77, 78, 4000, 32767};
  frame.intensities = {255, 1, 0, 100, 254};
  const Bytes bytes = coded(frame);
  for (unsigned int streams = 1; streams <= 257; ++streams) {
    const std::string name = std::to_string(streams);
    node.addStream(name);
    send(node, name, bytes);
    if (streams != 2 && streams != 129 && streams != 257)
      continue;
    node.waitUntilDecoded();
    WorldVoxels expected = worldVoxels(frame);
    for (auto& voxel : expected)
      voxel.second *= streams;
    EXPECT_EQ(mergedVoxels(node), expected) << streams << " streams";
  }
  // 258 * 255 is more than 16 bits hold.
  node.addStream("258");
  sendAndWait(node, "258", bytes);
  const WorldVoxels merged = mergedVoxels(node);
  ASSERT_EQ(merged.size(), frame.size());
  for (const auto& [index, intensity] : worldVoxels(frame))
    EXPECT_NEAR(merged.at(index), 258.0 * intensity, 258.0 * 255.0 / 65535.0);
}

/** \brief Expects the sums of the voxels of streams.
 * \param[in] tolerance a part of the largest intensity
 */
void
expectSums(const std::vector<VoxelFrame>& frames, double tolerance)
{
  CentralNode merging(centralSettings());
  WorldVoxels expected;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    merging.addStream(std::to_string(i), -1000.0f);
    sendAndWait(merging, std::to_string(i), coded(frames[i]));
    addVoxels(frames[i], resolution, expected);
  }
  double largest = 0.0;
  for (const auto& voxel : expected)
    largest = std::max(largest, std::abs(voxel.second));
  const WorldVoxels merged = mergedVoxels(merging);
  ASSERT_EQ(merged.size(), expected.size());
  for (const auto& [index, intensity] : expected) {
    ASSERT_EQ(merged.count(index), 1u);
    EXPECT_NEAR(merged.at(index), intensity, tolerance * largest);
  }
}

TEST_F(Merging, ScalesMayDiffer)
{
  // Steps and offsets of the streams.
  using Scales = std::vector<std::pair<float, float>>;
  const std::vector<std::pair<Scales, double>> cases = {
      {{{1.0f, -32.0f}, {1.0f, -200.0f}, {1.0f, 0.0f}}, 0.0},
      {{{0.1f, 0.0f}, {0.7f, 0.0f}, {1e-3f, 0.0f}}, 1.0 / 65535.0},
      {{{2e-4f, 0.0f}, {0.39f, 0.0f}}, 1.0 / 65535.0}};
  for (const auto& [scales, tolerance] : cases) {
    SCOPED_TRACE(scales.front().first);
    std::mt19937_64 random(5);
    std::vector<VoxelFrame> frames;
    for (const auto& [step, offset] : scales) {
      frames.push_back(pcl_ext::io::test::randomFrame(random, 5, 1000));
      frames.back().intensity_scale.step = step;
      frames.back().intensity_scale.offset = offset;
    }
    expectSums(frames, tolerance);
  }
}

TEST_F(Merging, FewHighAndLowIntensitiesAreInTheScale)
{
  // Sums beyond 16 bits, returns of a reflector, and those below all others: fewer than
  // one voxel of 256 each.
  struct Case {
    float step;
    float offset;
    std::uint16_t usual; // highest symbol
    std::uint16_t rare;
  };
  for (const Case& one : {Case{1.0f, 0.0f, 1, 60000},
                          Case{0.0612f, 0.0f, 800, 65000},
                          Case{0.01f, -300.0f, 40000, 0}}) {
    SCOPED_TRACE(one.step);
    std::mt19937_64 random(3);
    VoxelFrame frame = pcl_ext::io::test::randomFrame(random, 5, 4000, 16);
    frame.intensity_scale.step = one.step;
    frame.intensity_scale.offset = one.offset;
    for (std::uint16_t& symbol : frame.intensities)
      symbol = static_cast<std::uint16_t>(one.usual - below(random, one.usual));
    frame.intensities[100] = one.rare;
    expectSums({frame, frame, frame}, 1.0 / 32768.0);
  }
}

/** \brief A frame of which one voxel has an intensity beyond all measure, 2.55e38. */
VoxelFrame
frameOfAFaultySensor(float sign)
{
  VoxelFrame frame = pcl_ext::io::test::emptyFrame(5);
  frame.keys = {7, 77};
  frame.intensities = {0, 255};
  frame.intensity_scale.step = 1e36f;
  if (sign < 0.0f) {
    frame.intensities = {255, 0};
    frame.intensity_scale.offset = -2.55e38f;
  }
  return frame;
}

TEST_F(Merging, AFaultyIntensityLeavesThoseOfOtherStreams)
{
  for (const float step : {1.0f, 0.1f, 1e-3f, 1e-30f})
    for (const float sign : {1.0f, -1.0f}) {
      CentralNode merging(centralSettings());
      std::mt19937_64 random(8);
      VoxelFrame frame = pcl_ext::io::test::randomFrame(random, 5, 1000);
      frame.intensity_scale.step = step;
      const VoxelFrame faulty = frameOfAFaultySensor(sign);
      for (const std::string name : {"a", "faulty"}) {
        merging.addStream(name, -3e38f);
        sendAndWait(merging, name, coded(name == "a" ? frame : faulty));
      }
      const WorldVoxels of_fault = worldVoxels(faulty);
      const WorldVoxels merged = mergedVoxels(merging);
      for (const auto& [index, intensity] : worldVoxels(frame))
        if (of_fault.count(index) == 0 &&
            intensity > 100.0 * static_cast<double>(step)) {
          EXPECT_NEAR(merged.at(index), intensity, 0.02 * intensity) << step;
        }
      for (const auto& [index, intensity] : of_fault)
        if (intensity != 0.0) {
          EXPECT_GT(merged.at(index) / intensity, 0.0); // reduced
        }
      EXPECT_EQ(merging.health()[0].intensities_reduced, 0u);
      EXPECT_GE(merging.health()[1].intensities_reduced, 1u);
      EXPECT_EQ(merging.health()[1].merges_reduced, 1u);
    }
}

TEST_F(Merging, OfIntensitiesOf0BehindTinyOnes)
{
  VoxelFrame frame = pcl_ext::io::test::emptyFrame(4);
  frame.keys = {1, 2, 3};
  frame.intensities = {1, 2, 3};
  frame.intensity_scale.step = 1e-30f;
  sendAndWait(node, "a", coded(frame));
  EXPECT_EQ(mergedVoxels(node).size(), 3u);
  frame.intensities = {0, 0, 0};
  sendAndWait(node, "a", coded(frame));
  EXPECT_EQ(mergedVoxels(node), worldVoxels(frame));
}

TEST_F(Merging, NamesTheStreamsAndTheOldestStamp)
{
  const CodedStream stream = streamOf(1);
  for (const std::string name : {"b", "c", "d", "silent"})
    node.addStream(name);
  VoxelFrame merged;
  EXPECT_FALSE(node.merge(merged).oldestStamp().has_value());
  sendAndWait(node, "a", stream.frames[0], 70s);
  clock.set(3s); // "a" is too old
  sendAndWait(node, "b", stream.frames[0], 90s);
  sendAndWait(node, "c", stream.frames[0], 80s);
  sendAndWait(node, "d", stream.frames[0], 0s);
  const MergeStatus status = node.merge(merged);
  expectCode(status, CentralNodeCode::Ok);
  std::string merged_streams;
  for (const MergedStream& source : status.streams)
    merged_streams += source.name + (source.frame ? " " : "- ");
  EXPECT_EQ(merged_streams, "a- b c d silent- ");
  EXPECT_EQ(status.streams[1].frame->stamp, Time(90s));
  EXPECT_EQ(status.oldestStamp(), Time(80s));
}

TEST_F(Merging, TheGridShrinksWhenAFarStreamEnds)
{
  VoxelFrame near = pcl_ext::io::test::emptyFrame(4);
  near.keys = {1, 2, 3};
  near.intensities = {1, 2, 3};
  VoxelFrame far = near;
  far.grid.first_index = {900000, -900000, 5};
  node.addStream("near");
  node.addStream("far");
  sendAndWait(node, "near", coded(near));
  sendAndWait(node, "far", coded(far));
  WorldVoxels expected = worldVoxels(near);
  addVoxels(far, resolution, expected);
  EXPECT_EQ(mergedVoxels(node), expected);
  clock.set(100s);
  sendAndWait(node, "near", coded(near));
  VoxelFrame merged;
  node.merge(merged);
  EXPECT_EQ(worldVoxels(merged), worldVoxels(near));
  EXPECT_LE(merged.grid.depth, 4u);
}

} // namespace
