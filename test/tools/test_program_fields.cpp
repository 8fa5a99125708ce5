// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/sensor_node.h>

#include "tools/program.h"

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::tools::test {

namespace {

/** \brief A cloud with a ring (UINT16) and a time (FLOAT64) after the coordinates, as a
 * PCD file has it.
 * \param[in] ring_name, time_name their names
 */
pcl::PCLPointCloud2
cloudWithRings(const std::string& ring_name = "ring",
               const std::string& time_name = "time:gps")
{
  pcl::PCLPointCloud2 cloud;
  const std::vector<std::pair<std::string, std::uint8_t>> fields = {
      {"x", pcl::PCLPointField::FLOAT32},
      {"y", pcl::PCLPointField::FLOAT32},
      {"z", pcl::PCLPointField::FLOAT32},
      {ring_name, pcl::PCLPointField::UINT16},
      {time_name, pcl::PCLPointField::FLOAT64}};
  for (const auto& [name, type] : fields) {
    pcl::PCLPointField& field = cloud.fields.emplace_back();
    field.name = name;
    field.datatype = type;
    field.count = 1;
    field.offset = cloud.point_step;
    cloud.point_step += static_cast<std::uint32_t>(pcl::getFieldSize(type));
  }
  cloud.height = 1;
  cloud.width = 600;
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.data.resize(cloud.row_step);
  for (std::uint32_t i = 0; i < cloud.width; ++i) {
    std::uint8_t* const point = &cloud.data[i * cloud.point_step];
    const float place[3] = {0.013f * static_cast<float>(i % 100), 1.0f, 2.0f};
    const auto ring = static_cast<std::uint16_t>(i % 16);
    const double time = 1.7e9 + 1e-3 * i;
    std::memcpy(point, place, sizeof(place));
    std::memcpy(point + 12, &ring, sizeof(ring));
    std::memcpy(point + 14, &time, sizeof(time));
  }
  return cloud;
}

std::multiset<std::string>
furtherBytes(const pcl::PCLPointCloud2& cloud)
{
  std::multiset<std::string> points;
  for (std::size_t i = 0; i < cloud.width; ++i) {
    const auto* const point =
        reinterpret_cast<const char*>(&cloud.data[i * cloud.point_step]);
    points.insert(
        std::string(point + cloud.fields.at(3).offset, point + cloud.point_step));
  }
  return points;
}

/** \brief Records a cloud as the only frame of a recording, with all its fields. */
void
recordCloud(const pcl::PCLPointCloud2& cloud, const std::string& path)
{
  nodes::SensorNodeSettings settings;
  settings.law = IntensityLaw::None;
  settings.compression.resolution = 0.1;
  settings.compression.keep_points = true;
  settings.compression.fields = {{io::all_fields}};
  KnownStream stream;
  stream.name = "/lidar";
  nodes::SensorNode node(settings);
  ASSERT_TRUE(
      node.encode(cloud, WorldPose::Identity(), stream.frames.emplace_back().bytes)
          .hasFrame());
  record({stream}, path);
}

std::string
fieldsOf(const pcl::PCLPointCloud2& cloud)
{
  std::string names;
  for (const pcl::PCLPointField& field : cloud.fields)
    names += (names.empty() ? "" : " ") + field.name;
  return names;
}

class ProgramFields : public ProgramTest {
protected:
  ProgramFields()
  {
    std::filesystem::create_directories(folder / "clouds");
    EXPECT_EQ(pcl::PCDWriter().writeBinary(folder / "clouds/0.pcd", cloudWithRings()),
              0);
  }

  /** \brief The first cloud of x.mcap, decoded into the folder out. */
  pcl::PCLPointCloud2
  decoded(const std::string& option = "") const
  {
    std::filesystem::remove_all(folder / "out");
    expectRun("decode x.mcap -o out " + option);
    pcl::PCLPointCloud2 cloud;
    EXPECT_EQ(option == "--ply"
                  ? pcl::io::loadPLYFile(folder / "out/000000.ply", cloud)
                  : pcl::io::loadPCDFile(folder / "out/000000.pcd", cloud),
              0);
    return cloud;
  }
};

} // namespace

TEST_F(ProgramFields, ComeBackInFilesAndInMessages)
{
  const pcl::PCLPointCloud2 sent = cloudWithRings();
  // The messages are as good as the files.
  for (const std::string input : {"clouds", "messages.mcap"}) {
    expectRun("encode " + input +
              " -o x.mcap --overwrite -r 0.1 --keep-points --fields all");
    const pcl::PCLPointCloud2 received = decoded();
    expectRun("decode x.mcap -o messages.mcap --overwrite");
    ASSERT_EQ(received.fields.size(), sent.fields.size());
    for (std::size_t i = 0; i < sent.fields.size(); ++i) {
      EXPECT_EQ(received.fields[i].name, sent.fields[i].name);
      EXPECT_EQ(received.fields[i].datatype, sent.fields[i].datatype);
    }
    EXPECT_EQ(furtherBytes(received), furtherBytes(sent)) << input;
  }
}

TEST_F(ProgramFields, OfNormalsAreNotMoved)
{
  writeText(folder / "normals.pcd",
            "VERSION .7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\n"
            "TYPE F F F F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n"
            "1 2 3 1 0 0\n");
  const std::string encode = "encode normals.pcd -o x.mcap --overwrite --fields ";
  EXPECT_TRUE(hasPart(run(encode + "all --pose 1,0,0,0,0,90").errors,
                      "/normals: its fields normal_x, normal_y and normal_z are kept "
                      "as they are, which does not hold for points that --pose has "
                      "moved"));
  EXPECT_EQ(run(encode + "all --pose 1,0,0,0,0,0").errors, "");
  EXPECT_EQ(run(encode + "all").errors, "");
}

TEST_F(ProgramFields, HaveNamesOfOneWordInFiles)
{
  const pcl::PCLPointCloud2 sent = cloudWithRings("the\nring\x7f", "the_ring_");
  recordCloud(sent, folder / "x.mcap");
  for (const char* option : {"", "--ply"}) {
    const pcl::PCLPointCloud2 received = decoded(option);
    EXPECT_EQ(fieldsOf(received), "x y z the_ring_ the_ring__") << option;
    EXPECT_EQ(furtherBytes(received), furtherBytes(sent)) << option;
  }
  // What fills gaps is no name.
  recordCloud(cloudWithRings(" ", "time"), folder / "x.mcap");
  EXPECT_EQ(fieldsOf(decoded()), "x y z __ time");
}

TEST_F(ProgramFields, OfSeveralValuesAreSeveralInPlyFiles)
{
  // The time as four numbers, one of whose names is taken.
  pcl::PCLPointCloud2 sent = cloudWithRings("pair_1", "pair");
  sent.fields[4].datatype = pcl::PCLPointField::UINT16;
  sent.fields[4].count = 4;
  recordCloud(sent, folder / "x.mcap");
  EXPECT_EQ(fieldsOf(decoded()), "x y z pair_1 pair"); // together in PCD files
  const pcl::PCLPointCloud2 received = decoded("--ply");
  EXPECT_EQ(fieldsOf(received), "x y z pair_1 pair_0 pair_1_ pair_2 pair_3");
  EXPECT_EQ(furtherBytes(received), furtherBytes(sent));
  // The program reads it, too.
  expectRun("encode out -o x.mcap --overwrite -r 0.1 --keep-points --fields all");
  EXPECT_EQ(furtherBytes(decoded()), furtherBytes(sent));
}

TEST_F(ProgramFields, IntensityIsCodedOnce)
{
  const auto bitsOf = [this](const std::string& options) {
    expectRun("encode room -q -o x.mcap --overwrite " + options);
    return decode(folder / "x.mcap").at(0).voxels.at(0).intensity_scale.bits;
  };
  writeClouds("room", roomClouds(1));
  EXPECT_GT(bitsOf(""), 0u);
  for (const std::string fields : {"--fields all", "--fields intensity:0.5"}) {
    EXPECT_EQ(bitsOf(fields), 0u);
    EXPECT_EQ(bitsOf(fields + " --keep-points"), 0u);
    // Unless an option asks for that of voxels.
    EXPECT_GT(bitsOf(fields + " --law native"), 0u);
    EXPECT_EQ(bitsOf(fields + " --intensity-bits 9"), 9u);
    EXPECT_GT(bitsOf(fields + " --intensity-field intensity"), 0u);
  }
  const pcl::PointCloud<pcl::PointXYZI> sent = roomClouds(1)[0];
  expectRun("encode room -q -o x.mcap --overwrite --fields all --keep-points");
  expectRun("decode x.mcap -o out");
  std::multiset<float> sent_intensities;
  std::multiset<float> received;
  for (const pcl::PointXYZI& point : sent)
    sent_intensities.insert(point.intensity);
  for (const pcl::PointXYZI& point : readCloud(folder / "out/000000.pcd"))
    received.insert(point.intensity);
  EXPECT_EQ(received, sent_intensities);
}

TEST_F(ProgramFields, ColoursThatAreNamedAreCodedOnce)
{
  pcl::PointCloud<pcl::PointXYZRGB> cloud;
  for (int i = 0; i < 9; ++i) {
    cloud.push_back(pcl::PointXYZRGB());
    cloud.back().x = 0.1f * static_cast<float>(i);
    cloud.back().r = 200;
  }
  std::filesystem::create_directory(folder / "coloured");
  ASSERT_EQ(pcl::io::savePCDFileBinary(folder / "coloured/0.pcd", cloud), 0);
  const auto bitsOf = [this](const std::string& options) {
    expectRun("encode coloured -q -o x.mcap --overwrite -r 0.05 " + options);
    return decode(folder / "x.mcap").at(0).voxels.at(0).colour_bits;
  };
  EXPECT_EQ(bitsOf("--fields all"), 6u);
  EXPECT_EQ(bitsOf("--fields rgb"), 0u);
  EXPECT_EQ(bitsOf("--fields rgb --colour-bits 5"), 5u);
}

TEST_F(ProgramFields, AreInTheRatio)
{
  // x, y, z, ring and time take 22 bytes.
  for (const auto& [options, of_point] :
       {std::pair<std::string, double>{"--fields all", 22.0}, {"", 16.0}}) {
    const ProgramRun encoded = run("encode clouds -o x.pcxi --overwrite " + options);
    const auto bytes =
        static_cast<double>(decode(folder / "x.pcxi").at(0).frames.at(0).bytes.size());
    std::ostringstream ratio;
    ratio << "ratio " << std::fixed << std::setprecision(1) << 600 * of_point / bytes
          << " against " << std::setprecision(0) << of_point << " bytes a point";
    EXPECT_TRUE(hasPart(encoded.output, ratio.str()));
  }
}

TEST_F(ProgramFields, AreNamedByInfo)
{
  expectRun("encode clouds -o x.pcxi --fields time:gps:0.01,ring");
  const ProgramRun table = expectRun("info x.pcxi");
  EXPECT_TRUE(hasPart(table.output, "field time:gps, field ring"));
  const ProgramRun json = expectRun("info --json x.pcxi");
  EXPECT_TRUE(hasPart(json.output, "\"name\": \"time:gps\""));
  EXPECT_TRUE(hasPart(json.output, "\"type\": \"float64\""));
  EXPECT_TRUE(hasPart(json.output, "\"step\": 0.01"));
}

TEST_F(ProgramFields, OfRingsTellTheOrderOfThePoints)
{
  pcl::PCLPointCloud2 cloud = cloudWithRings();
  for (std::uint32_t i = 0; i < cloud.width; ++i) {
    const float angle = 0.1653f * static_cast<float>(i / 16);
    const float place[3] = {3.0f * std::cos(angle),
                            3.0f * std::sin(angle),
                            0.1f * static_cast<float>(i % 16)};
    std::memcpy(&cloud.data[i * cloud.point_step], place, sizeof(place));
  }
  ASSERT_EQ(pcl::PCDWriter().writeBinary(folder / "clouds/0.pcd", cloud), 0);
  // Also where they are not kept.
  const ProgramRun encoded = run("encode clouds -o x.pcxi -r 0.001 --keep-points");
  EXPECT_EQ(encoded.status, 0);
  EXPECT_TRUE(
      hasPart(encoded.output, "600 points in order, on 38 x 16 rays, edge 0.001 m, "));
  EXPECT_FALSE(hasPart(encoded.output, "voxel"));
  const std::string table = expectRun("info x.pcxi").output;
  EXPECT_TRUE(hasPart(table, " points in order, on 38 x 16 rays"));
  EXPECT_FALSE(hasPart(table, "numbers of points"));
  const auto stream =
      nlohmann::json::parse(expectRun("info --json x.pcxi").output)["streams"][0];
  EXPECT_EQ(stream["scan"]["width"], 38);
  EXPECT_EQ(stream["scan"]["height"], 16);
  EXPECT_EQ(stream["scan"]["is_organised"], false);
  EXPECT_EQ(stream["mean_frame_points_in_order"], 600.0);
  EXPECT_EQ(stream["mean_frame_voxels"], 0.0);
  EXPECT_EQ(stream["bytes_per_point"], stream["bytes"].get<double>() / 600.0);
  EXPECT_FALSE(stream.contains("bytes_per_voxel"));
  expectRun("decode x.pcxi -o out");
  EXPECT_EQ(readCloud(folder / "out/000000.pcd").size(), 600u);
}

TEST_F(ProgramFields, ThatAllCannotKeepAreNamedWithoutTheOption)
{
  const std::string name(65, 'n');
  EXPECT_EQ(pcl::PCDWriter().writeBinary(folder / "clouds/0.pcd", cloudWithRings(name)),
            0);
  const ProgramRun all = run("encode clouds -o x.pcxi --fields all");
  EXPECT_EQ(all.status, 0) << all.errors;
  EXPECT_TRUE(hasPart(all.output + all.errors,
                      "fields that are left out: " + name.substr(0, 64) + '\n'))
      << all.output << all.errors;
}
} // namespace pcl_ext::tools::test
