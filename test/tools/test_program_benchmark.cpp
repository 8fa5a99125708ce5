// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "measuring/samples.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

TEST(Samples, APercentileIsTheNearestRankAndNeverTheWorst)
{
  measuring::Samples samples;
  EXPECT_FALSE(samples.percentile(500));
  // 1 to 1000, out of order: 7 and 1000 have no common divisor.
  for (int i = 1; i <= 1000; ++i)
    samples.add(7 * i % 1000 + 1);
  EXPECT_EQ(samples.percentile(500), 500.0);
  EXPECT_EQ(samples.percentile(990), 990.0);
  EXPECT_EQ(samples.percentile(999), 999.0);
  measuring::Samples few;
  for (int i = 1; i < 100; ++i)
    few.add(i);
  EXPECT_FALSE(few.percentile(990));
  few.add(100);
  EXPECT_EQ(few.percentile(990), 99.0);
  EXPECT_FALSE(few.percentile(999));
}

using ProgramBenchmark = ProgramTest;

TEST_F(ProgramBenchmark, EncodesAsTheCommandEncodeAndTellsRates)
{
  writeClouds("room", roomClouds(4));
  expectRun("encode room -o room.pcxi -r 0.05 --law count -e fast -q --rate 20");
  expectRun(
      "benchmark room -r 0.05 --law count -n 4 -e fast --rate 20 --json x.json -q");
  const auto json = nlohmann::json::parse(std::ifstream(folder / "x.json"));
  EXPECT_EQ(
      json["options"],
      " --rate 20 --frames 4 --json x.json --law count --resolution 0.05 --effort "
      "fast --quiet");
  ASSERT_EQ(json["results"].size(), 1u);
  const nlohmann::json& fast = json["results"][0];
  const auto bytes = static_cast<double>(fs::file_size(folder / "room.pcxi"));
  EXPECT_EQ(fast["bytes"], bytes);
  EXPECT_NEAR(fast["kbit_s"], 8e-3 * bytes / 4 * 20, 1e-9);
  EXPECT_FALSE(fast["period_is_assumed"]);
  std::size_t voxels = 0;
  const auto streams = decode(folder / "room.pcxi"); // outlives the loop
  for (const io::VoxelFrame& frame : streams[0].voxels)
    voxels += frame.size();
  EXPECT_EQ(fast["voxels"], voxels);
  EXPECT_GT(fast["encode"]["worst_ms"], 0.0);
  EXPECT_NE(fast["encode"]["p50_ms"], nullptr);
  EXPECT_EQ(fast["decode"]["p99_ms"], nullptr);
  expectRun("decode room.pcxi -o room_clouds --remove-outliers --unit points -q");
  std::size_t kept = 0;
  for (const auto& entry : fs::directory_iterator(folder / "room_clouds"))
    kept += readCloud(entry.path()).size();
  EXPECT_EQ(fast["removed_voxels"], voxels - kept);
}

TEST_F(ProgramBenchmark, RepeatsCloudsWithEachEffortAndSaysWhatItCannotTell)
{
  writeClouds("room", roomClouds(2));
  const ProgramRun run = expectRun("benchmark room -r 0.5 -n 5 -q --json -");
  const auto json = nlohmann::json::parse(run.output);
  ASSERT_EQ(json["results"].size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const nlohmann::json& row = json["results"][i];
    EXPECT_EQ(row["effort"], std::vector({"fast", "balanced", "small"})[i]);
    EXPECT_EQ(row["clouds"], 2);
    EXPECT_EQ(row["frames"], 5);
    EXPECT_TRUE(row["period_is_assumed"]);
    // Of voxels of this edge no filter is made for.
    EXPECT_NE(row["filter_failure"], "");
    EXPECT_EQ(row["filter"]["worst_ms"], nullptr);
  }
  const ProgramRun table = expectRun("benchmark room -r 0.5 -n 5 -q");
  EXPECT_TRUE(hasPart(table.output,
                      "/room: nothing tells the times of its clouds: 10.0 a "
                      "second are assumed; --rate sets it\n"));
}

TEST_F(ProgramBenchmark, MeasuresTheCellWhereNothingElseIsNamed)
{
  const ProgramRun result = expectRun("benchmark -n 2 -e fast -q");
  EXPECT_TRUE(
      hasPart(result.output, "resolution 0.04 m, law count, an I-frame every 30"));
  EXPECT_TRUE(hasPart(result.output, "| /cell_sensor_1 | fast   | filter |"));
}

TEST_F(ProgramBenchmark, ACloudThatIsDamagedIsNamedAndTheOthersAreMeasured)
{
  writeClouds("room", roomClouds(1));
  writeBytes(folder / "room/999.pcd", {1, 2, 3});
  const ProgramRun damaged =
      expectRemark("benchmark room -n 2 -e fast -q", "999.pcd", 1);
  EXPECT_TRUE(hasPart(damaged.output, "| /room  | fast   | 1      | 2      |"));
}

} // namespace pcl_ext::tools::test
