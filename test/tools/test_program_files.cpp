// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "tools/program.h"

#include <pcl/io/pcd_io.h>
#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace pcl_ext::tools::test {

namespace {

template <typename NumberT>
NumberT
numberOf(const pcl::PCLPointCloud2& cloud, std::size_t point, const std::string& field)
{
  NumberT number{};
  const int index = pcl::getFieldIndex(cloud, field);
  EXPECT_GE(index, 0) << "no field " << field;
  if (index >= 0)
    std::memcpy(&number,
                &cloud.data[point * cloud.point_step +
                            cloud.fields[static_cast<std::size_t>(index)].offset],
                sizeof(number));
  return number;
}

/** \brief The points of the cases that users report: x from -8 m in steps of .5 m. */
constexpr std::size_t points_of_case = 64;

std::string
nuScenesBytes()
{
  std::string bytes;
  for (std::size_t i = 0; i < points_of_case; ++i) {
    const auto number = static_cast<float>(i);
    for (const float value : {-8.0f + 0.5f * number,
                              0.25f * number,
                              1.0f + 0.01f * static_cast<float>(i % 5),
                              static_cast<float>(i * 4 % 256),
                              static_cast<float>(i % 32)}) {
      std::array<char, sizeof(value)> of_value{};
      std::memcpy(of_value.data(), &value, sizeof(value));
      bytes.append(of_value.data(), of_value.size());
    }
  }
  return bytes;
}

} // namespace

using ProgramFiles = ProgramTest;

TEST_F(ProgramFiles, WithoutAHeaderHaveTheFieldsThatAreNamed)
{
  writeText(folder / "scan.bin", nuScenesBytes());
  expectRemark("encode scan.bin -o x.pcxi",
               "not of 4 floats a point (x y z reflectance, as KITTI's): give "
               "--bin-fields x,y,z,intensity,ring",
               1);
  expectRun("encode scan.bin -o x.mcap -r 0.001 --keep-points --fields all "
            "--bin-fields x,y,z,intensity,ring:float32");
  expectRun("decode x.mcap -o out");
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(folder / "out/000000.pcd", cloud), 0);
  ASSERT_EQ(cloud.width * cloud.height, points_of_case);
  for (std::size_t i = 0; i < points_of_case; ++i) {
    const long number = std::lround(2.0f * (numberOf<float>(cloud, i, "x") + 8.0f));
    EXPECT_EQ(numberOf<float>(cloud, i, "ring"), static_cast<float>(number % 32));
    EXPECT_EQ(numberOf<float>(cloud, i, "intensity"),
              static_cast<float>(number * 4 % 256));
  }
  // From the standard input, which has no name, and of commands that try settings.
  EXPECT_EQ(
      runShell("\"$P\" encode - -o y.pcxi --bin-fields x,y,z,_,_ < scan.bin").errors,
      "");
  EXPECT_TRUE(hasPart(run("advise scan.bin --bin-fields x,y,z,_,_").output,
                      " --bin-fields x,y,z,_,_\n"));
  EXPECT_EQ(run("benchmark scan.bin --bin-fields x,y,z,_,_").status, 0);
}

TEST_F(ProgramFiles, FieldsWithoutEffectOrSenseAreRefused)
{
  writeText(folder / "scan.bin", nuScenesBytes());
  writeClouds("room", roomClouds(1));
  writeMcap(folder / "bag.mcap", {});
  expectRefusals(
      2,
      {{"encode room -o x.pcxi --bin-fields x,y,z",
        "--bin-fields is for files without a header, such as .bin, and there are none"},
       {"encode scan.bin -o x.pcxi --bin-fields x,y",
        "--bin-fields: there is no field 'z'"},
       {"encode bag.mcap -o x.pcxi --bin-fields x,y,z",
        "--bin-fields is for files; 'bag.mcap' is a bag, whose messages name their "
        "fields"},
       {"benchmark --cell --bin-fields x,y,z", "--bin-fields is for inputs"},
       {"benchmark bag.mcap bag.mcap",
        "'bag.mcap' is a bag, which is taken alone: run the command for each bag, or "
        "join recordings by pcl_ext merge first"}});
  std::filesystem::create_directories(folder / "texts");
  writeText(folder / "texts/0.bin", "1 2 3\n4 5 6\n");
  const ProgramRun of_text = run("encode texts -o x.pcxi --bin-fields x,y,z");
  EXPECT_EQ(of_text.status, 1);
  EXPECT_TRUE(hasPart(of_text.errors, "cannot read 'texts/0.bin': it is text that"));
}

TEST_F(ProgramFiles, RemarksOnFilesAreMadeOnceAStream)
{
  const std::string text =
      "VERSION .7\nFIELDS x y z gps\nSIZE 4 4 4 8\nTYPE F F F F\nCOUNT 1 1 1 0\n"
      "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n";
  writeText(folder / "a0.pcd", text);
  writeText(folder / "a1.pcd", text);
  const ProgramRun result = run("encode a0.pcd a1.pcd -o x.pcxi");
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(
      result.errors,
      "pcl_ext encode: /a0: the field 'gps' is left out: its SIZE or COUNT is 0\n");
  EXPECT_TRUE(hasPart(run("benchmark a0.pcd").errors, "the field 'gps' is left out"));
}

TEST_F(ProgramFiles, IntegersOf64BitsHaveValuesOfPoints)
{
  const auto write = [this](const std::string& name, const std::string& points) {
    writeText(folder / name,
              "VERSION .7\nFIELDS x y z t\nSIZE 4 4 4 8\nTYPE F F F U\nWIDTH 3\n"
              "HEIGHT 1\nPOINTS 3\nDATA ascii\n" +
                  points);
  };
  write("label.pcd", ".101 .101 .101 1\n.103 .103 .103 1\n.102 .102 .102 7\n");
  EXPECT_EQ(run("encode label.pcd -o x.mcap -r 0.1 --fields t").status, 0);
  expectRun("decode x.mcap -o out");
  pcl::PCLPointCloud2 cloud;
  ASSERT_EQ(pcl::io::loadPCDFile(folder / "out/000000.pcd", cloud), 0);
  ASSERT_EQ(cloud.width, 1u);
  EXPECT_EQ(numberOf<std::uint32_t>(cloud, 0, "t"), 1u);
  write("time.pcd",
        ".1 .1 .1 1700000000000000001\n.2 .2 .2 1700000000000000002\n.3 .3 .3 3\n");
  expectFailure("encode time.pcd -o y.mcap --keep-points --fields t:1000",
                2,
                "--fields: 'time.pcd': the field 't' (uint64) has values of more than "
                "53 bits: 64-bit integers are kept exactly, without a step");
  EXPECT_EQ(run("encode time.pcd -o y.mcap --keep-points --fields t").status, 0);
}

TEST_F(ProgramFiles, AllFieldsAreThoseOfColoursOfPointsOfOneVoxel)
{
  writeText(folder / "a.pcd",
            "VERSION .7\nFIELDS x y z rgb label\nSIZE 4 4 4 4 4\nTYPE F F F U U\n"
            "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"
            ".101 .101 .101 16711680 1\n.103 .103 .103 255 2\n");
  // Voxels, and what may be a scan.
  for (const char* law : {"-l count", ""}) {
    SCOPED_TRACE(law);
    const ProgramRun encoded =
        run(std::string("encode a.pcd -o x.mcap --overwrite -r 0.1 --keep-points "
                        "--fields all ") +
            law);
    EXPECT_EQ(encoded.status, 0);
    EXPECT_EQ(encoded.errors, "");
    expectRun("decode x.mcap -o out --overwrite");
    pcl::PCLPointCloud2 cloud;
    ASSERT_EQ(pcl::io::loadPCDFile(folder / "out/000000.pcd", cloud), 0);
    ASSERT_EQ(cloud.width * cloud.height, 2u);
    std::map<std::uint32_t, std::uint32_t> colours;
    for (std::size_t i = 0; i < 2; ++i)
      colours[numberOf<std::uint32_t>(cloud, i, "label")] =
          numberOf<std::uint32_t>(cloud, i, "rgb") & 0xffffff;
    EXPECT_EQ(colours,
              (std::map<std::uint32_t, std::uint32_t>{{1, 0xff0000}, {2, 255}}));
  }
}

} // namespace pcl_ext::tools::test
