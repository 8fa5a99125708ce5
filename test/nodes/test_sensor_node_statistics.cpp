// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "support/node_tests.h"

namespace {

using namespace pcl_ext::nodes::test;

TEST(SensorNodeStatistics, CountBytesPointsAndVoxels)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.crop_box = BoundingBox{{-0.2, -1.0, -1.0}, {1.0, 1.0, 1.0}};
  SensorNode node(settings);
  std::uint64_t cloud_bytes = 0;
  std::uint64_t frame_bytes = 0;
  for (unsigned int frame = 0; frame < 5; ++frame) {
    const Cloud seen = cloudSeenFrom(poseOf(frame), frame, 500 + 100 * frame);
    const Cloud preprocessed =
        naivelyPreprocessed(seen, poseOf(frame), naiveCount, settings.crop_box);
    if (frame == 2)
      node.requestIFrame();
    const Bytes bytes = encoded(node, messageOf(seen), poseOf(frame));
    EXPECT_EQ(node.statistics().frame.coding.is_i_frame, frame == 0 || frame == 2);
    cloud_bytes += sizeof(pcl::PointXYZI) * seen.size();
    frame_bytes += bytes.size();
    const SensorNodeStatistics statistics = node.statistics();
    EXPECT_EQ(statistics.frames, frame + 1);
    EXPECT_EQ(statistics.i_frames, frame < 2 ? 1u : 2u);
    EXPECT_EQ(statistics.encode_times.count(), frame + 1);
    EXPECT_GT(statistics.encode_times.sum_seconds, 0.0);
    EXPECT_EQ(statistics.cloud_bytes, cloud_bytes);
    EXPECT_EQ(statistics.frame_bytes, frame_bytes);
    EXPECT_DOUBLE_EQ(statistics.compressionRatio(),
                     static_cast<double>(cloud_bytes) /
                         static_cast<double>(frame_bytes));
    EXPECT_EQ(statistics.preprocessing.points, seen.size());
    EXPECT_EQ(statistics.preprocessing.points_cropped,
              seen.size() - preprocessed.size());
    EXPECT_EQ(statistics.frame.voxelization.points, preprocessed.size());
    EXPECT_EQ(statistics.frame.coding.voxels,
              naiveVoxels(preprocessed, resolution).size());
    EXPECT_EQ(statistics.frame.coding.bytes, bytes.size());
    EXPECT_EQ(statistics.frame.coding.frame_number, frame + 1);
  }
  EXPECT_GT(node.statistics().preprocessing.points_cropped, 0u);
}

SensorNode
nodeWith(const FakeClock& clock)
{
  SensorNodeSettings settings = settingsOf(IntensityLaw::Count);
  settings.clock = clock.clock();
  return SensorNode(settings);
}

TEST(SensorNodeStatistics, RatesAndLatenciesAreOfTheClockOfTheSettings)
{
  FakeClock clock;
  SensorNode node = nodeWith(clock);
  std::vector<std::size_t> sizes;
  // Three frames, a quarter of a second apart, ready 50, 80 and 20 ms behind their
  // stamps.
  const std::vector<std::chrono::milliseconds> stamps = {7000ms, 7220ms, 7530ms};
  const std::vector<std::chrono::milliseconds> ready = {7050ms, 7300ms, 7550ms};
  for (std::size_t frame = 0; frame < 3; ++frame) {
    clock.set(ready[frame]);
    const auto stamp =
        static_cast<std::uint64_t>(std::chrono::microseconds(stamps[frame]).count());
    const Cloud seen = cloudSeenFrom(poseOf(0), 1 + static_cast<unsigned int>(frame));
    sizes.push_back(encoded(node, messageOf(seen, stamp), poseOf(0)).size());
  }
  StreamRates rates = node.statistics().rates;
  EXPECT_DOUBLE_EQ(rates.frames_per_second, 4.0);
  EXPECT_DOUBLE_EQ(rates.bytes_per_second,
                   static_cast<double>(sizes[1] + sizes[2]) / 0.5);
  EXPECT_DOUBLE_EQ(rates.mean_latency_seconds, 0.05);
  EXPECT_DOUBLE_EQ(rates.max_latency_seconds, 0.08);
  EXPECT_GT(rates.mean_cycle_seconds, 0.0);
  EXPECT_GE(rates.max_cycle_seconds, rates.mean_cycle_seconds);

  // Clouds that are left out are no frames.
  clock.set(7600ms);
  expectLeftOut(
      node, pcl::PCLPointCloud2(), std::nullopt, SensorNodeCode::InvalidCloud);
  EXPECT_DOUBLE_EQ(node.statistics().rates.frames_per_second, 4.0);
  clock.set(10s);
  rates = node.statistics().rates;
  EXPECT_EQ(rates.frames_per_second, 0.0);
  EXPECT_EQ(rates.max_latency_seconds, 0.0);
}

} // namespace
