// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/site_program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

using ProgramMap = SiteTest;

TEST_F(ProgramMap, ReplacesNoFileUnlessAsked)
{
  const Bytes precious{'o', 'w', 'n'};
  for (const char* const map : {"mine.ot", "old.ot"})
    writeBytes(folder / map, precious);
  const std::string receive = "receive -q --for 10ms --map mine.ot" + at(server);
  expectFailure(receive, 2, "'mine.ot' exists: name another output, or replace");
  EXPECT_EQ(bytesOf(folder / "mine.ot"), precious);
  writeClouds("room", roomClouds(5));
  const std::string replace = at(server) + "--overwrite --map ";
  Receiving empty(folder, replace + "mine.ot --min-intensity 1e9");
  Receiving receiving(folder, replace + "old.ot");
  expectRun("send -q room --rate 50 --resolution 0.05" + at(server));
  EXPECT_EQ(empty.end(SIGINT), 1);
  EXPECT_TRUE(hasPart(empty.errors(), "the map is empty, and not written: "));
  EXPECT_FALSE(hasPart(empty.errors(), "no intensities"));
  EXPECT_EQ(bytesOf(folder / "mine.ot"), precious);
  EXPECT_EQ(receiving.end(SIGINT), 0) << receiving.errors();
  EXPECT_NE(bytesOf(folder / "old.ot"), precious);
  EXPECT_TRUE(hasPart(receiving.errors(),
                      "/room: no pose of its sensor is known, so that the map gets no "
                      "free space from this stream"))
      << receiving.errors();
}

TEST_F(ProgramMap, KeepsAFileThatAppearsWhileItRuns)
{
  writeClouds("room", roomClouds(5));
  Receiving receiving(folder, at(server) + "--map map.ot");
  const Bytes precious{'o', 'w', 'n'};
  writeBytes(folder / "map.ot", precious);
  expectRun("send -q room --rate 50 --resolution 0.05 --pose 0,0,0,0,0,0" + at(server));
  EXPECT_EQ(receiving.end(SIGINT), 1);
  EXPECT_TRUE(
      hasPart(receiving.errors(), "File exists; the map is in 'map.ot.unfinished'"))
      << receiving.errors();
  EXPECT_FALSE(hasPart(receiving.errors(), "no pose"));
  EXPECT_EQ(bytesOf(folder / "map.ot"), precious);
  EXPECT_GT(bytesOf(folder / "map.ot.unfinished").size(), 1000u);
}

TEST_F(ProgramMap, HasVoxelsOfNoNativeIntensity)
{
  auto clouds = roomClouds(2);
  for (auto& cloud : clouds)
    for (pcl::PointXYZI& point : cloud)
      point.intensity = 0.0f;
  writeClouds("dark", clouds);
  const auto statusOf = [&](const std::string& map, const std::string& options) {
    Receiving receiving(folder, at(server) + "--map " + map + options);
    expectRun("send -q dark --rate 50 -r 0.05 --law native" + at(server));
    return receiving.end(SIGINT);
  };
  EXPECT_EQ(statusOf("whole.ot", ""), 0);
  EXPECT_EQ(statusOf("asked.ot", " --map-full-intensity 0"), 0);
  EXPECT_EQ(bytesOf(folder / "whole.ot"), bytesOf(folder / "asked.ot"));
  EXPECT_EQ(statusOf("shares.ot", " --map-full-intensity 4"), 1); // it is empty
}

} // namespace pcl_ext::tools::test
