// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>
#include <set>

namespace pcl_ext::tools::test {

namespace {

constexpr double edge = 0.04;

using DoublePoints = std::vector<std::array<double, 3>>;

/** \brief Points of a place in UTM coordinates, where floats are 0.06 and 0.5 m apart. */
DoublePoints
farPoints()
{
  std::mt19937_64 random(7);
  DoublePoints points(1000);
  for (auto& point : points)
    point = {6e5 + static_cast<double>(io::test::uniform(random, 0.0, 20.0)),
             5.2e6 + static_cast<double>(io::test::uniform(random, 0.0, 20.0)),
             400.0 + static_cast<double>(io::test::uniform(random, 0.0, 20.0))};
  return points;
}

/** \brief The centres of the voxels that have points. */
std::set<std::array<double, 3>>
centresOf(DoublePoints points)
{
  for (auto& point : points)
    for (double& number : point)
      number = (std::floor(number / edge) + 0.5) * edge;
  return {points.begin(), points.end()};
}

pcl::PCLPointCloud2
mapCloud(const DoublePoints& points)
{
  pcl::PCLPointCloud2 cloud;
  for (const char* name : {"x", "y", "z"}) {
    pcl::PCLPointField field;
    field.name = name;
    field.offset = cloud.point_step;
    field.datatype = pcl::PCLPointField::FLOAT64;
    field.count = 1;
    cloud.fields.push_back(field);
    cloud.point_step += 8;
  }
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(points.size());
  cloud.row_step = cloud.point_step * cloud.width;
  cloud.data.resize(24 * points.size());
  std::memcpy(cloud.data.data(), points.data(), cloud.data.size());
  return cloud;
}

DoublePoints
readFile(const std::string& path)
{
  pcl::PCLPointCloud2 cloud;
  const bool is_ply = std::filesystem::path(path).extension() == ".ply";
  EXPECT_GE(is_ply ? pcl::io::loadPLYFile(path, cloud)
                   : pcl::io::loadPCDFile(path, cloud),
            0);
  EXPECT_EQ(cloud.fields.at(0).datatype, pcl::PCLPointField::FLOAT64);
  DoublePoints points(cloud.width);
  for (std::size_t i = 0; i < points.size(); ++i)
    std::memcpy(points[i].data(), &cloud.data[i * cloud.point_step], 24);
  return points;
}

} // namespace

using ProgramFarClouds = ProgramTest;

TEST_F(ProgramFarClouds, FilesOfAllKindsKeepThePrecisionOfDoubles)
{
  const DoublePoints points = farPoints();
  ASSERT_EQ(pcl::PCDWriter().writeBinary(folder / "in.pcd", mapCloud(points)), 0);
  ASSERT_EQ(pcl::PLYWriter().writeBinary(folder / "in.ply", mapCloud(points)), 0);
  for (const std::string input : {"pcd", "ply"})
    expectRun("encode in." + input + " -o " + input + ".pcxi -r 0.04");
  EXPECT_EQ(bytesOf(folder / "pcd.pcxi"), bytesOf(folder / "ply.pcxi"));
  for (const std::string option :
       {"--pcd binary", "--pcd compressed", "--pcd ascii", "--ply"}) {
    SCOPED_TRACE(option);
    expectRun("decode pcd.pcxi -o '" + option + "' " + option);
    const DoublePoints decoded =
        readFile(folder / (option + "/000000" + (option == "--ply" ? ".ply" : ".pcd")));
    const auto centres = centresOf(decoded);
    EXPECT_EQ(centres, centresOf(points));
    ASSERT_EQ(decoded.size(), centres.size());
    for (const auto& point : decoded)
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(centresOf({point}).begin()->at(axis), point[axis], 1e-6);
  }
}

/** \brief Points along a line, at places that are no multiples of a step: a cloud that is
 * 290 m wide, of which a grid of voxels of 0.1 mm holds 210 m. */
pcl::PointCloud<pcl::PointXYZI>
wideCloud()
{
  pcl::PointCloud<pcl::PointXYZI> cloud;
  for (int i = -145; i <= 145; ++i) {
    pcl::PointXYZI point;
    point.getVector3fMap() << static_cast<float>(i) + 0.00003f, 0.0f, 1.0f;
    point.intensity = 5.0f;
    cloud.push_back(point);
  }
  return cloud;
}

TEST_F(ProgramFarClouds, PointsBeyondTheGridAreToldWithWhatHoldsThem)
{
  writeClouds("wide", {wideCloud(), wideCloud()});
  const ProgramRun lossy =
      expectRemark("encode wide -o x.pcxi -r 0.0001 --json",
                   "82 of 291 points are more than 2^20 voxels from the grid's "
                   "origin and were left out",
                   1);
  EXPECT_TRUE(hasPart(lossy.errors,
                      "use --coarsen, a --resolution of 0.00014 m or more, or a "
                      "--bounding-box around the points to keep"));
  EXPECT_TRUE(
      hasPart(lossy.errors, "1 more frame likewise, in all 164 points of 582 points"));
  EXPECT_TRUE(hasPart(lossy.output, "\"status\":\"incomplete\""));
  EXPECT_TRUE(hasPart(lossy.output, "\"points_outside_grid\":164"));
  EXPECT_FALSE(hasPart(lossy.errors, "origin amid"));
  // What is in the grid is written.
  EXPECT_EQ(decode(folder / "x.pcxi")[0].voxels[0].size(), 209u);
  // Also where remarks are not printed.
  expectRemark("encode wide -o q.pcxi -r 0.0001 --quiet", "82 of 291 points", 1);

  expectRun("encode wide -o resolution.pcxi -r 0.00014");
  EXPECT_EQ(run("encode wide -o coarse.pcxi -r 0.0001 --coarsen").status, 0);
  const ProgramRun boxed =
      run("encode wide -o box.pcxi -r 0.0001 --bounding-box=-100,-1,0,100,1,2");
  EXPECT_EQ(boxed.status, 0); // as asked for
  EXPECT_TRUE(hasPart(boxed.output, "points left out outside the box"));
  expectRemark("benchmark wide -n 1 -e fast -r 0.0001", "82 of 291 points", 1);
  expectRemark("advise wide -e fast -r 0.0001", "82 of 291 points", 1);
}

pcl::PointCloud<pcl::PointXYZI>
cameraCloud()
{
  pcl::PointCloud<pcl::PointXYZI> cloud(80, 60);
  for (std::uint32_t row = 0; row < cloud.height; ++row)
    for (std::uint32_t column = 0; column < cloud.width; ++column) {
      const float depth =
          (column < 40 ? 1.2f : 2400.0f) + 0.003f * static_cast<float>(column);
      pcl::PointXYZI& point = cloud.at(column, row);
      point.getVector3fMap() << (static_cast<float>(column) - 39.5f) / 61.0f * depth,
          (static_cast<float>(row) - 28.0f) / 60.5f * depth, depth;
      point.intensity = 9.0f;
    }
  return cloud;
}

TEST_F(ProgramFarClouds, ScansOfOtherSizesAreToldBesidesTheFirst)
{
  pcl::PointCloud<pcl::PointXYZI> other = cameraCloud();
  other.resize(80 * 40);
  other.width = 80;
  other.height = 40;
  // The first cloud has no points, from which nothing follows.
  writeClouds("clouds", {{}, cameraCloud(), other, cameraCloud()});
  const std::string sizes = "in order, 80 x 60, or in order, 80 x 40";
  const ProgramRun encoded =
      expectRun("encode clouds -o x.pcxi -r 0.001 --keep-points --fields all -q");
  EXPECT_TRUE(hasPart(encoded.output, "points " + sizes + ", edge"));
  const ProgramRun info = expectRun("info x.pcxi");
  EXPECT_TRUE(hasPart(info.output, "| points " + sizes + ", field intensity |"));
  const auto json = nlohmann::json::parse(expectRun("info --json x.pcxi").output);
  EXPECT_EQ(json["streams"][0]["scan"]["height"], 60);
  EXPECT_EQ(json["streams"][0]["scan"]["is_one_order"], false);
}

TEST_F(ProgramFarClouds, PointsOfScansBeyondTheGridAreToldWhereVoxelsAreNeeded)
{
  writeClouds("clouds", {cameraCloud(), cameraCloud()});
  // Half of the points are outside the grid of voxels.
  const ProgramRun encoded =
      expectRun("encode clouds -o x.pcxi -r 0.001 --keep-points -q");
  EXPECT_TRUE(hasPart(encoded.output, "9,600 points in order, 80 x 60, edge 0.001 m"));
  const ProgramRun all = expectRun("decode x.pcxi -o all");
  EXPECT_TRUE(hasPart(all.output, "2 frames, 9,600 points"));
  const ProgramRun some = run("decode x.pcxi -o some --min-intensity 5");
  EXPECT_EQ(some.status, 1);
  EXPECT_TRUE(hasPart(some.output, "2 frames, 4,800 points"));
  EXPECT_TRUE(hasPart(some.errors,
                      "frame 0: 2400 points of the scan are outside its grid of voxels "
                      "and were left out: encode with a larger --resolution"));
  EXPECT_TRUE(hasPart(some.errors, "in all frames 4,800 points"));
}
} // namespace pcl_ext::tools::test
