// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace pcl_ext::tools::test {

std::vector<std::string>
linesWith(const std::string& text, const std::string& beginning)
{
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind(beginning, 0) == 0)
      lines.push_back(line);
  return lines;
}

// Clouds have seconds for their encoding, which may be slow here: --rate is small.
using ProgramAdvise = ProgramTest;

TEST_F(ProgramAdvise, PrintsACommandThatDoesWhatItAdvises)
{
  writeClouds("a room", roomClouds(3));
  const ProgramRun result = expectRun("advise 'a room' --law count --rate 0.1 -q");
  EXPECT_EQ(linesWith(result.output, "/a room: 3 clouds of ").size(), 1u)
      << result.output;
  EXPECT_TRUE(hasPart(result.output, " points, 0.1 a second; law count\n"));
  const std::vector<std::string> commands =
      linesWith(result.output, "  pcl_ext encode ");
  ASSERT_EQ(commands.size(), 1u) << result.output;
  const std::string edge = commands[0].substr(commands[0].find(" -r ") + 4);
  EXPECT_EQ(linesWith(result.output,
                      "  parameters=[{'resolution': " + edge.substr(0, edge.find(' ')) +
                          ", 'intensity': 'count', 'effort': '")
                .size(),
            1u);
  EXPECT_EQ(
      linesWith(result.output, "| " + edge.substr(0, edge.find(' ')) + " *").size(),
      1u);
  const ProgramRun run = runShell("\"$P\"" + commands[0].substr(9) + " -q");
  EXPECT_EQ(run.status, 0) << run.errors << commands[0];
  EXPECT_EQ(decode(folder / "small.mcap")[0].voxels.size(), 3u);
}

TEST_F(ProgramAdvise, TriesOneSettingAndNamesItsParameters)
{
  writeClouds("room", roomClouds(2));
  const ProgramRun result = expectRun(
      "advise room -r 0.2 -e small --law quadratic --sensor 87,58,848,480 --crop "
      "-9,-9,-9,9,9,9 --keep-points --fields intensity:0.5 --i-frame-rate 9 "
      "--rate 0.1 -q");
  EXPECT_EQ(
      linesWith(result.output, "  p"),
      std::vector<std::string>(
          {"  pcl_ext encode room -o small.mcap -r 0.2 -e small --rate 0.1 --law "
           "quadratic --sensor "
           "87,58,848,480 --i-frame-rate 9 --crop -9,-9,-9,9,9,9 --keep-points "
           "--fields intensity:0.5",
           "  parameters=[{'resolution': 0.2, 'intensity': 'quadratic', 'effort': "
           "'small', 'sensor_fov_x_deg': 87, 'sensor_fov_y_deg': 58, 'sensor_columns': "
           "848, 'sensor_rows': 480, 'i_frame_rate': 9, 'crop_box': "
           "'[-9,-9,-9,9,9,9]', 'keep_points': True, 'fields': "
           "'intensity:0.5'}]"}))
      << result.output;
  // Of an edge that is given, holes are not asked.
  EXPECT_EQ(linesWith(result.output, "| 0.2 *").size(), 1u);
  EXPECT_EQ(linesWith(result.output, "| 0.").size(), 1u);
}

TEST_F(ProgramAdvise, ARateMakesVoxelsLargerUntilNoneKeepsIt)
{
  writeClouds("room", roomClouds(3));
  const auto edgeAt = [this](const std::string& rate) {
    const ProgramRun result = run("advise room -q --rate 0.1 --max-rate " + rate);
    const std::string line = linesWith(result.output, "  pcl_ext encode ").at(0);
    return std::stod(line.substr(line.find(" -r ") + 4));
  };
  EXPECT_LT(edgeAt("1gBIT/s"), edgeAt("'600 bit/s'"));
  // As for encode, 0 is no limit.
  EXPECT_EQ(expectRun("advise room -q --rate 0.1 --max-rate 0 -r 0.2").errors, "");
  expectFailure(
      "advise room -q --rate 0.1 --max-rate 12bit/s",
      1,
      "/room: nothing here keeps within --max-rate 12bit/s; the mark is at the "
      "fewest bytes: --crop, --temporal-filter or fewer clouds take fewer");
}

TEST_F(ProgramAdvise, PointsThatAreKeptHaveFineVoxels)
{
  writeClouds("room", roomClouds(2));
  const ProgramRun kept = expectRun("advise room --keep-points --rate 0.1 -q");
  EXPECT_EQ(linesWith(kept.output, "| 0.001 * ").size(), 1u) << kept.output;
}

TEST_F(ProgramAdvise, PointsThatCoincideAreNoSurface)
{
  auto clouds = roomClouds(1);
  writeClouds("room", clouds);
  for (std::size_t i = clouds[0].size() / 5; i > 0; --i)
    clouds[0].push_back(pcl::PointXYZI());
  writeClouds("missing", clouds);
  const auto holes_at_5_cm = [this](const std::string& input) {
    const ProgramRun result = run("advise -q -e fast --rate 0.1 " + input);
    std::istringstream line(linesWith(result.output, "| 0.05").at(0));
    std::string column;
    for (int i = 0; i < 4; ++i)
      std::getline(line, column, '|');
    return std::stod(column);
  };
  const double of_room = holes_at_5_cm("room");
  EXPECT_GT(of_room, 0.0);
  EXPECT_EQ(holes_at_5_cm("missing"), of_room);
  EXPECT_EQ(holes_at_5_cm("room -r 0.05"), of_room);
}

TEST_F(ProgramAdvise, LeavesOutEdgesAtWhichOutliersAreNotRemoved)
{
  writeClouds("room", roomClouds(2));
  const std::string advise = "advise room --law count --rate 0.1 -q";
  // Else it tries larger edges, too.
  EXPECT_GE(linesWith(expectRun(advise).output, "| 0.3 ").size(), 1u);
  const std::string output = expectRun(advise + " --remove-outliers").output;
  EXPECT_GE(linesWith(output, "| 0.").size(), 3u) << output;
  EXPECT_EQ(linesWith(output, "| 0.3 ").size(), 0u) << output;
}

TEST_F(ProgramAdvise, ABagHasATableForEachTopic)
{
  writeClouds("a", roomClouds(2));
  writeClouds("b", roomClouds(2, 7));
  expectRun("encode a b -o two.mcap -r 0.02 --law count -q --rate 0.5");
  expectRun("decode two.mcap -o clouds.mcap -q");
  const ProgramRun result = expectRun("advise clouds.mcap -q");
  EXPECT_EQ(linesWith(result.output, "/a: 2 clouds of ").size(), 1u) << result.output;
  EXPECT_EQ(linesWith(result.output, "| edge, m ").size(), 2u);
  const std::vector<std::string> commands =
      linesWith(result.output, "  pcl_ext encode ");
  ASSERT_EQ(commands.size(), 2u);
  EXPECT_TRUE(hasPart(commands[0], "clouds.mcap -o small_a.mcap --topics /a -r "));
  EXPECT_TRUE(hasPart(commands[1], "clouds.mcap -o small_b.mcap --topics /b -r "));
  EXPECT_TRUE(hasPart(result.output, " 0.5 a second; law native\n"));
}

TEST_F(ProgramAdvise, SaysWhatCannotBeTold)
{
  writeClouds("one", roomClouds(1));
  const ProgramRun one = run("advise one -q"); // may be too slow for 10 a second
  EXPECT_EQ(
      linesWith(one.output,
                "One cloud does not tell what P-frames take, which is less: rates "
                "are those of I-frames.")
          .size(),
      1u)
      << one.output;
  EXPECT_TRUE(hasPart(one.output, "10.0 a second, assumed, as nothing tells (--rate)"));
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  pcl::PointCloud<pcl::PointXYZI> unknown;
  unknown.emplace_back(nan, nan, nan, 1.0f);
  writeClouds("unknown", {unknown, unknown});
  expectFailure(
      "advise unknown -q",
      1,
      "/unknown: nothing can be told: /unknown: no cloud has a point with finite "
      "coordinates");
  expectFailure("advise one -q --crop 90,90,90,91,91,91",
                1,
                "/one: nothing can be told: /one: no point is inside the box");
  pcl::PointCloud<pcl::PointXYZI> few;
  few.emplace_back(0.0f, 0.0f, 1.0f, 1.0f);
  few.emplace_back(4.0f, 0.0f, 1.0f, 1.0f);
  writeClouds("few", {few, few});
  expectFailure(
      "advise few -q",
      1,
      "/few: no edge here has at most 25 % holes, or there is no surface; the mark "
      "is at the largest");
}

} // namespace pcl_ext::tools::test
