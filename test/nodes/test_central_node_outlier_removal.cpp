// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

#include <limits>

namespace {

using namespace pcl_ext::nodes::test;

VoxelOutlierRemovalSettings
atLogOdds(float min_log_odds)
{
  return {PointsUnit(), min_log_odds};
}

VoxelFrame
filtered(VoxelFrame frame, VoxelOutlierRemoval& removal)
{
  EXPECT_GT(removal.filter(frame).removed, 0u);
  EXPECT_GT(frame.size(), 100u);
  return frame;
}

struct FilteredStream {
  CodedStream coded;
  std::optional<VoxelOutlierRemovalSettings> settings;
  float min_intensity = 0.0f;
};

std::map<std::string, FilteredStream>
filteredStreams(std::size_t frames)
{
  std::map<std::string, FilteredStream> streams;
  const auto add = [&](const std::string& name, bool are_faces, const auto& settings) {
    CodedStream::Settings coded;
    coded.seed = streams.size() + 1;
    coded.frames = frames;
    coded.i_frame_rate = 5;
    if (are_faces)
      coded.depth_model = pcl_ext::io::test::roomDepthModel(6, coded.bits);
    streams.insert({name, FilteredStream{CodedStream(coded), settings}});
  };
  const std::optional<VoxelOutlierRemovalSettings> none;
  add("all", false, none);
  add("threshold alone", false, none);
  add("counts", false, std::optional(atLogOdds(0.0f)));
  VoxelOutlierRemovalSettings settings = atLogOdds(1.0f);
  settings.unit = AutomaticUnit();
  add("shares", true, std::optional(settings));
  settings.min_log_odds = -1.0f;
  settings.unit = AutomaticUnit{{false}};
  add("without history", true, std::optional(settings));
  settings = atLogOdds(0.0f);
  settings.unit = FacesUnit{{}, 16.0f};
  settings.max_blocks = 20;
  add("faces", false, std::optional(settings));
  add("both", false, std::optional(atLogOdds(0.0f)));
  add("threshold of all", false, none);
  add("threshold of none", false, none);
  streams.at("threshold alone").min_intensity = 2.0f;
  streams.at("threshold of all").min_intensity = -3.0f;
  streams.at("threshold of none").min_intensity = 300.0f;
  streams.at("both").min_intensity = 3.0f;
  return streams;
}

TEST(CentralNodeOutliers, EachStreamHasAFilterBeforeThresholdAndMerging)
{
  constexpr std::size_t frames = 12;
  const std::map<std::string, FilteredStream> streams = filteredStreams(frames);
  FrameRecorder recorder;
  CentralNode node(centralSettings(), recorder.listener());
  std::map<std::string, VoxelOutlierRemoval> removals;
  for (const auto& [name, stream] : streams) {
    expectCode(node.addStream(name, stream.min_intensity), CentralNodeCode::Ok);
    expectCode(node.setOutlierRemoval(name, stream.settings), CentralNodeCode::Ok);
    if (stream.settings)
      removals.emplace(name, *stream.settings);
  }
  for (std::size_t i = 0; i < frames; ++i) {
    // All wait at once, and share the threads and their memory.
    for (const auto& [name, stream] : streams)
      send(node, name, stream.coded.frames[i]);
    node.waitUntilDecoded();
    WorldVoxels merged_voxels;
    for (const auto& [name, stream] : streams) {
      SCOPED_TRACE(name + ", frame " + std::to_string(i));
      VoxelFrame expected = stream.coded.decoded[i];
      if (stream.settings)
        expected = filtered(expected, removals.at(name));
      const std::size_t outliers = stream.coded.decoded[i].size() - expected.size();
      const std::size_t faint = removeVoxelsBelow(expected, stream.min_intensity);
      EXPECT_EQ(faint > 0, stream.min_intensity > 0.0f);
      EXPECT_EQ(expected.size() > 0, stream.min_intensity < 100.0f);
      const RecordedFrame recorded = recorder.frames(name).at(i);
      expectSameFrame(recorded.voxels, expected);
      EXPECT_EQ(recorded.statistics.voxels, stream.coded.decoded[i].size());
      expectSameFrame(latestVoxels(node, name), expected);
      addVoxels(expected, 0.04, merged_voxels);
      for (const StreamHealth& health : node.health())
        if (health.name == name) {
          EXPECT_EQ(health.voxels, stream.coded.decoded[i].size());
          EXPECT_EQ(health.outliers_removed, outliers);
          EXPECT_EQ(health.kept_voxels, expected.size());
        }
    }
    VoxelFrame merged;
    node.merge(merged);
    const WorldVoxels is_merged = worldVoxels(merged);
    // Shares have fractions.
    ASSERT_EQ(is_merged.size(), merged_voxels.size());
    for (const auto& [index, intensity] : merged_voxels)
      ASSERT_NEAR(is_merged.at(index), intensity, 0.02);
  }
}

using CentralNodeOutliersOfOneStream = OneStream;

TEST_F(CentralNodeOutliersOfOneStream, AChangeHoldsFromTheNextFrameOnAndResetsTheFilter)
{
  const CodedStream stream = streamOf(16);
  node.addStream("b");
  std::optional<VoxelOutlierRemovalSettings> in_force;
  std::optional<VoxelOutlierRemoval> removal;
  const auto change = [&](const std::optional<VoxelOutlierRemovalSettings>& settings) {
    const VoxelFrame before = latestVoxels(node);
    expectCode(node.setOutlierRemoval("a", settings), CentralNodeCode::Ok);
    expectSameFrame(latestVoxels(node), before);
    in_force = settings;
    removal.reset();
    if (settings)
      removal.emplace(*settings);
  };
  std::size_t frames_that_show_it = 0; // that a filter began anew
  for (std::size_t i = 0; i < stream.frames.size(); ++i) {
    if (i == 2 || i == 8)
      change(atLogOdds(2.0f));
    if (i == 5)
      change(atLogOdds(3.0f));
    if (i == 7) // the same again keeps the history
      expectCode(node.setOutlierRemoval("a", in_force), CentralNodeCode::Ok);
    if (i == 11)
      change(std::nullopt);
    if (i == 13) { // the last one counts
      change(std::nullopt);
      change(atLogOdds(-2.0f));
    }
    sendAndWait(node, "a", stream.frames[i]);
    sendAndWait(node, "b", stream.frames[i]);
    VoxelFrame expected = stream.decoded[i];
    if (removal) {
      expected = filtered(expected, *removal);
      VoxelOutlierRemoval remembering(*in_force);
      for (std::size_t before = 0; before < i; ++before)
        filtered(stream.decoded[before], remembering);
      if (filtered(stream.decoded[i], remembering).keys != expected.keys)
        ++frames_that_show_it;
    }
    expectSameFrame(recorder.frames("a").back().voxels, expected);
    expectSameFrame(recorder.frames("b").back().voxels, stream.decoded[i]);
    EXPECT_EQ(node.health()[0].outliers_removed,
              stream.decoded[i].size() - expected.size());
  }
  EXPECT_GT(frames_that_show_it, 0u);
}

TEST_F(CentralNodeOutliersOfOneStream, FramesThatFailDoNotReachTheFilter)
{
  const CodedStream stream = streamOf(12, 6);
  const VoxelOutlierRemovalSettings settings = atLogOdds(2.5f);
  node.setOutlierRemoval("a", settings);
  VoxelOutlierRemoval removal(settings);
  for (const std::size_t i : {0u, 1u, 3u, 4u, 6u, 7u, 8u}) {
    sendAndWait(node, "a", Bytes(20, 7));
    sendAndWait(node, "a", stream.frames[i]);
    const RecordedFrame recorded = recorder.frames("a").back();
    if (i == 3 || i == 4) { // 2 is missing, until the I-frame
      EXPECT_EQ(recorded.code, CompressionCode::MissingReference);
      EXPECT_EQ(recorded.voxels.size(), 0u);
      continue;
    }
    expectSameFrame(recorded.voxels, filtered(stream.decoded[i], removal));
  }
  EXPECT_EQ(onlyHealth(node).frames_decoded, 5u);
  // A filter that had begun anew at the I-frame would have kept others.
  VoxelOutlierRemoval fresh(settings);
  std::size_t differing = 0;
  for (const std::size_t i : {6u, 7u, 8u})
    differing += filtered(stream.decoded[i], fresh).keys !=
                         recorder.frames("a").at(2 * i - 3).voxels.keys
                     ? 1
                     : 0;
  EXPECT_GT(differing, 0u);
}

TEST_F(CentralNodeOutliersOfOneStream, InvalidCallsAreReportedAndChangeNothing)
{
  const CodedStream stream = streamOf(6);
  node.setOutlierRemoval("a", atLogOdds(0.5f));
  VoxelOutlierRemoval removal(atLogOdds(0.5f));
  constexpr float infinity = std::numeric_limits<float>::infinity();
  std::vector<VoxelOutlierRemovalSettings> wrong(2, atLogOdds(0.0f));
  wrong[0].min_log_odds = infinity;
  wrong[1].unit = FacesUnit{{}, 0.0f};
  for (std::size_t i = 0; i < stream.frames.size(); ++i) {
    sendAndWait(node, "a", stream.frames[i]);
    expectSameFrame(recorder.frames("a").back().voxels,
                    filtered(stream.decoded[i], removal));
    const VoxelOutlierRemovalSettings& settings = wrong[i % wrong.size()];
    const CentralNodeStatus status = node.setOutlierRemoval("a", settings);
    expectCode(status, CentralNodeCode::InvalidSettings);
    EXPECT_EQ(status.message(),
              "outlier_removal: " + pcl_ext::checkSettings(settings).message());
  }
  for (const auto& settings :
       {std::optional(atLogOdds(1.0f)), std::optional<VoxelOutlierRemovalSettings>()}) {
    const CentralNodeStatus status = node.setOutlierRemoval("b", settings);
    expectCode(status, CentralNodeCode::UnknownStream);
    EXPECT_EQ(status.message(), "there is no stream 'b'");
  }
  CentralNodeSettings wrong_settings = centralSettings();
  wrong_settings.max_waiting_frames = 0;
  CentralNode unusable(wrong_settings);
  EXPECT_EQ(unusable.setOutlierRemoval("a", atLogOdds(1.0f)).message(),
            unusable.settingsStatus().message());
}

TEST_F(CentralNodeOutliersOfOneStream, HealthSaysWhatWasRemovedAndNotJudged)
{
  EXPECT_TRUE(onlyHealth(node).outlier_removal.ok());
  const CodedStream stream = streamOf(3);
  VoxelOutlierRemovalSettings settings;
  node.setOutlierRemoval("a", settings);
  sendAndWait(node, "a", stream.frames[0]);
  StreamHealth health = onlyHealth(node);
  EXPECT_TRUE(health.outlier_removal.ok());
  EXPECT_EQ(health.outlier_removal.removed, health.outliers_removed);
  // They are counts, which the frame does not say.
  EXPECT_NE(health.outlier_removal.message().find("the unit points"),
            std::string::npos);
  settings.unit = PointsUnit();
  node.setOutlierRemoval("a", settings);
  sendAndWait(node, "a", stream.frames[1]);
  health = onlyHealth(node);
  EXPECT_EQ(health.outlier_removal.message(), "");
  EXPECT_GT(health.outliers_removed, 0u);
  // A frame that fails leaves the health of the one before.
  node.setOutlierRemoval("a", std::nullopt);
  sendAndWait(node, "a", Bytes(20, 7));
  EXPECT_EQ(onlyHealth(node).outliers_removed, health.outliers_removed);
  sendAndWait(node, "a", stream.frames[2]);
  EXPECT_EQ(onlyHealth(node).outliers_removed, 0u);
  EXPECT_EQ(onlyHealth(node).outlier_removal.removed, 0u);

  CodedStream::Settings coarse;
  coarse.frames = 1;
  coarse.resolution = 0.25;
  node.setOutlierRemoval("a", settings);
  sendAndWait(node, "a", CodedStream(coarse).frames[0]);
  health = onlyHealth(node);
  EXPECT_EQ(health.outlier_removal.code(),
            pcl_ext::OutlierRemovalCode::UnsupportedResolution);
  EXPECT_EQ(health.kept_voxels, health.voxels);
}

} // namespace
