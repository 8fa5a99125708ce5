// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "tools/program.h"

#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace pcl_ext::tools::test {

namespace {

/** \brief A cube of voxels of 4 cm, each with a point; without gaps it takes few
 * bytes.
 * \param[in] step voxels from one to the next
 */
pcl::PointCloud<pcl::PointXYZ>
cubeOfVoxels(int width, bool has_gaps, int step = 1)
{
  const auto centre = [step](int i) {
    return 0.04f * (static_cast<float>(step * i) + 0.5f);
  };
  std::mt19937 random(1);
  pcl::PointCloud<pcl::PointXYZ> cloud;
  for (int x = 0; x < width; ++x)
    for (int y = 0; y < width; ++y)
      for (int z = 0; z < width; ++z)
        if (!has_gaps || random() % 2 == 0)
          cloud.push_back({centre(x), centre(y), centre(z)});
  return cloud;
}

} // namespace

using ProgramLimits = ProgramTest;

TEST_F(ProgramLimits, FramesAboveADecodersDefaultAreRead)
{
  const pcl::PointCloud<pcl::PointXYZ> cloud = cubeOfVoxels(130, true);
  ASSERT_GT(cloud.size(), std::size_t{1} << 20);
  pcl::io::savePCDFileBinary(folder / "large.pcd", cloud);
  expectRun("encode large.pcd -o x.mcap -r 0.04 -l none -e fast");
  const ProgramRun verified = expectRun("verify x.mcap");
  EXPECT_EQ(verified.output, "1 frame decoded, 0 lost\n");
  expectRun("decode x.mcap -o y.mcap --bag");
  expectRemark(
      "decode x.mcap -o z --max-voxels 1000000", "exceed the limit of 1000000", 1);
}

TEST_F(ProgramLimits, RegularGridsOfManyVoxelsAreRead)
{
  // They take fewer bytes than readers demand for so many blocks.
  std::filesystem::create_directories(folder / "room");
  pcl::io::savePCDFileBinary(folder / "room/0.pcd", cubeOfVoxels(10, true));
  pcl::io::savePCDFileBinary(folder / "room/1.pcd", cubeOfVoxels(102, false, 4));
  pcl::io::savePCDFileBinary(folder / "room/2.pcd", cubeOfVoxels(10, true));
  expectRun("encode room -o x.pcxi -r 0.04 -l none -e fast -q");
  const ProgramRun verified = expectRun("verify x.pcxi");
  EXPECT_EQ(verified.output, "3 frames decoded, 0 lost\n");
}

TEST_F(ProgramLimits, StreamsShareTheMemory)
{
  const pcl::PointCloud<pcl::PointXYZ> cloud = cubeOfVoxels(40, false);
  for (const char* stream : {"a", "b", "c", "d"}) {
    std::filesystem::create_directories(folder / ("room/" + std::string(stream)));
    for (const char* number : {"0", "1", "2"})
      pcl::io::savePCDFileBinary(
          folder / ("room/" + std::string(stream) + "/" + number + ".pcd"), cloud);
  }
  expectRun("encode room/a room/b room/c room/d -o x.mcap -r 0.04 -l none -e fast -q");
  const ProgramRun roomy = expectRun("verify x.mcap");
  EXPECT_EQ(roomy.output, "12 frames decoded, 0 lost\n");
  const ProgramRun narrow = run("verify x.mcap --memory-limit 10MB");
  EXPECT_EQ(narrow.status, 0);
  EXPECT_EQ(narrow.output, roomy.output);
  EXPECT_TRUE(hasPart(narrow.errors, "to keep --memory-limit"));
  for (const auto& [limit, text] :
       {std::pair<std::string, std::string>{"1MB", "1 MB"}, {"1kB", "1000 bytes"}}) {
    const ProgramRun none = run("verify x.mcap --memory-limit " + limit);
    EXPECT_EQ(none.status, 1);
    EXPECT_TRUE(hasPart(none.output, "the memory limit is " + text));
  }
}

} // namespace pcl_ext::tools::test
