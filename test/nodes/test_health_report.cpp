// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/nodes/impl/health_report.h>

#include <gtest/gtest.h>

#include <optional>
#include <string>

namespace {

using namespace pcl_ext::nodes;
using namespace std::chrono_literals;

std::optional<std::string>
valueOf(const HealthReport& report, const std::string& key)
{
  for (const auto& [name, value] : report.values())
    if (name == key)
      return value;
  return std::nullopt;
}

void
expectLevel(const HealthReport& report, HealthLevel level, const std::string& message)
{
  EXPECT_EQ(report.level(), level) << report.message();
  EXPECT_EQ(report.message(), message);
}

TEST(HealthReport, TheHighestLevelHasTheMessage)
{
  HealthReport report;
  expectLevel(report, HealthLevel::Ok, "OK");
  report.raise(HealthLevel::Warning, "first");
  report.raise(HealthLevel::Warning, "second");
  expectLevel(report, HealthLevel::Warning, "first");
  report.raise(HealthLevel::Error, "third");
  report.raise(HealthLevel::Warning, "fourth");
  expectLevel(report, HealthLevel::Error, "third");
}

TEST(HealthReport, OfASender)
{
  SenderHealth before;
  before.last_arrival = 100s;
  const auto report_of = [&before](const SenderHealth& now) {
    return describeHealth(now, before, 101s);
  };
  expectLevel(report_of(before), HealthLevel::Ok, "OK");
  expectLevel(
      describeHealth(before, before, 103s), HealthLevel::Error, "No clouds arrive");
  expectLevel(describeHealth(SenderHealth(), SenderHealth(), 1s),
              HealthLevel::Stale,
              "No clouds have arrived yet");
  SenderHealth now = before;
  now.clouds_missed = 1;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Clouds are missing: lost on the way or dropped from the queue");
  now.clouds_of_other_frame = 1;
  expectLevel(
      report_of(now), HealthLevel::Error, "Clouds without transform are dropped");
  now = before;
  now.node.clouds_refused = 2;
  expectLevel(report_of(now), HealthLevel::Error, "Clouds are refused");
  EXPECT_EQ(valueOf(report_of(now), "clouds refused"), "2");
  now = before;
  now.node.frame.voxelization.points_outside_grid = 5;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Points are left out, as they are outside the grid of voxels");
  EXPECT_EQ(valueOf(report_of(now), "points outside the grid"), "5");
  now = before;
  now.node.frame.coding.voxels = 10;
  now.node.outliers_removed = 10;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  now.node.outliers_removed = 11;
  expectLevel(
      report_of(now), HealthLevel::Warning, "Most voxels are removed as outliers");
  now = before;
  now.node.outliers_stay = true;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Outliers stay, as voxels of this edge are not judged");
  now = before;
  now.node.frame.voxelization.points_used = 10;
  now.node.points_removed = 10;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  now.node.points_removed = 11;
  expectLevel(
      report_of(now), HealthLevel::Warning, "Most points are removed as outliers");
  EXPECT_EQ(valueOf(report_of(now), "points removed as outliers"), "11");
  now = before;
  now.latest_transforms = 2;
  now.node.frames_with_last_transform = 3;
  expectLevel(
      report_of(now), HealthLevel::Warning, "A transform of another time is used");
  EXPECT_EQ(valueOf(report_of(now), "frames with last transform"), "5");
  // Old news is none.
  before = now;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
}

TEST(HealthReport, OfASenderUnderRateControl)
{
  SenderHealth before;
  before.last_arrival = 100s;
  const auto report_of = [&before](const SenderHealth& now) {
    return describeHealth(now, before, 101s);
  };
  EXPECT_EQ(valueOf(report_of(before), "rate control"), std::nullopt);
  SenderHealth now = before;
  pcl_ext::io::RateControlStatus& status = now.node.rate_control;
  status.is_on = true;
  status.max_rate = 2e5;
  status.used_rate = 1.5e5;
  status.step_number = 3;
  status.choice = "voxels of 0.02 m";
  status.reason = "frames take much";
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  EXPECT_EQ(valueOf(report_of(now), "rate control"), "voxels of 0.02 m");
  EXPECT_EQ(valueOf(report_of(now), "rate control chose it as"), "frames take much");
  EXPECT_EQ(valueOf(report_of(now), "rate control step"), "3");
  EXPECT_EQ(valueOf(report_of(now), "max_rate, bit/s"), "200000");
  EXPECT_EQ(valueOf(report_of(now), "bits of the last second"), "150000");
  EXPECT_EQ(valueOf(report_of(now), "clouds left out for max_rate"), "0");
  status.clouds_left_out = 2;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Clouds are left out, as max_rate has no room");
  before.node.rate_control.clouds_left_out = 2;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  status.not_kept = "max_rate is not kept";
  expectLevel(
      report_of(now), HealthLevel::Warning, "Rate control: max_rate is not kept");
}

TEST(HealthReport, OfAReceiver)
{
  ReceiverHealth before;
  before.last_arrival = 100s;
  before.stream.in_sync = true;
  const auto report_of = [&before](const ReceiverHealth& now) {
    return describeHealth(now, before, 102s);
  };
  expectLevel(report_of(before), HealthLevel::Ok, "OK");
  EXPECT_EQ(valueOf(report_of(before), "in sync"), "yes");
  ReceiverHealth now = before;
  now.left_out = 1;
  expectLevel(
      report_of(now), HealthLevel::Error, "Frames are of another frame id or format");
  now = before;
  now.stream.frames_lost = 1;
  expectLevel(report_of(now), HealthLevel::Warning, "Frames are lost");
  now.stream.frames_failed = 1;
  now.stream.last_failure = {pcl_ext::io::CompressionCode::Corrupt, "bad checksum"};
  expectLevel(report_of(now), HealthLevel::Warning, "Frames fail: bad checksum");
  now = before;
  now.stream.frames_refused = 1;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Frames arrive faster than they are decoded");
  now = before;
  now.stream.voxels = 1000;
  now.stream.frames_received = 2;
  now.stream.bytes = 800;
  expectLevel(report_of(now), HealthLevel::Warning, "All voxels are removed as noise");
  EXPECT_EQ(valueOf(report_of(now), "compression ratio"), "40");
  now.stream.kept_voxels = 1000;
  now.stream.has_intensities = false;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  now.min_intensity = 2.0f;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "min_intensity has no effect: the frames have no intensities");
  now.stream.has_intensities = true;
  now.stream.kept_voxels = 10;
  now.stream.outliers_removed = 501;
  expectLevel(
      report_of(now),
      HealthLevel::Warning,
      "Most voxels are removed as outliers: density_unit may not fit the sensor");
  now.stream.outliers_removed = 500;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  now.stream.points_outside_grid = 4;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Points of scans are left out, as they are outside the grid of voxels");
  EXPECT_EQ(valueOf(report_of(now), "points outside the grid"), "4");
  before.stream.points_outside_grid = 4; // those were before
  now.stream.voxels_outside_grid = 3;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Voxels are too far from those of other streams to be merged");
  now = before;
  now.stream.intensities_reduced = 1;
  expectLevel(report_of(now),
              HealthLevel::Warning,
              "Intensities are too far above those of other streams to be merged");
  now.stream.intensities_reduced = 0; // in the last merged frame
  now.stream.merges_reduced = 1;
  now.stream.merges_outside_grid = 2;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  EXPECT_EQ(faultsOfMerging(now.stream, 0.0, MergedFrames::All),
            (std::vector<std::string>{
                "Voxels are too far from those of other streams to be merged: in 2 "
                "merged frames",
                "Intensities are too far above those of other streams to be merged: in "
                "1 merged frame"}));
  now = before;
  now.stream.resolution = 0.06;
  expectLevel(report_of(now), HealthLevel::Ok, "OK"); // is not merged
  now.merged_resolution = 0.04;
  expectLevel(
      report_of(now),
      HealthLevel::Warning,
      "Voxels have an edge of 0.06 m, those of the merged grid and the map 0.04 "
      "m, where they leave gaps: set a resolution that is not finer than theirs");
  EXPECT_EQ(valueOf(report_of(now), "resolution, m"), "0.06");
  now.stream.resolution = 0.03;
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
  now.stream.resolution = double{0.04f};
  expectLevel(report_of(now), HealthLevel::Ok, "OK");
}

TEST(HealthReport, AnErrorIsSaidWhereNothingHasArrived)
{
  HealthReport report = describeHealth(ReceiverHealth(), ReceiverHealth(), 5s);
  expectLevel(report, HealthLevel::Stale, "No frames have arrived yet");
  report.raise(HealthLevel::Error, "Two nodes");
  report.raise(HealthLevel::Stale, "Nothing");
  expectLevel(report, HealthLevel::Error, "Two nodes");
}

TEST(HealthReport, OfAllStreamsTogether)
{
  StreamHealth stream;
  stream.rates.frames_per_second = 10.0;
  stream.rates.bytes_per_second = 500.0;
  StreamHealth other = stream;
  other.in_sync = true;
  stream.last_decoded = other.last_decoded = 8s;
  stream.frames_decoded = 1;
  HealthReport report = describeTogether({stream, other}, true, 7, 10s);
  expectLevel(report, HealthLevel::Ok, "OK");
  EXPECT_EQ(valueOf(report, "streams"), "2");
  EXPECT_EQ(valueOf(report, "streams in sync"), "1");
  // One has never had a frame; later the other one has stopped.
  EXPECT_EQ(valueOf(report, "streams without frames for 2 s"), "1");
  EXPECT_EQ(valueOf(describeTogether({stream, other}, true, 7, 10001ms),
                    "streams without frames for 2 s"),
            "2");
  EXPECT_EQ(valueOf(report, "frames per second"), "20");
  EXPECT_EQ(valueOf(report, "bytes per second"), "1000");
  EXPECT_EQ(valueOf(report, "map nodes"), "7");
  expectLevel(describeTogether({}, false, 0, 10s),
              HealthLevel::Warning,
              "Not all streams are OK");
}

} // namespace
