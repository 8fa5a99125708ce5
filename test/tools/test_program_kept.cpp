// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/recording/recording_reader.h>

#include "clouds/file_stamps.h"
#include "tools/program.h"

#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>

namespace pcl_ext::tools::test {

namespace {

using clouds::stampOfName;
using std::chrono::nanoseconds;

void
writeWithViewpoint(const std::string& path,
                   pcl::PointCloud<pcl::PointXYZI> cloud,
                   const Eigen::Vector4f& origin,
                   const Eigen::Quaternionf& orientation)
{
  cloud.sensor_origin_ = origin;
  cloud.sensor_orientation_ = orientation;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  ASSERT_EQ(pcl::io::savePCDFileBinary(path, cloud), 0);
}

pcl::PointCloud<pcl::PointXYZI>
organisedWall()
{
  pcl::PointCloud<pcl::PointXYZI> cloud(80, 60);
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const float depth = 2.0f + 0.001f * static_cast<float>(i % 80 + i % 3);
    cloud[i].x = 0.01f * (static_cast<float>(i % 80) - 40.0f) * depth;
    cloud[i].y = 0.01f * (static_cast<float>(i / 80) - 30.0f) * depth;
    cloud[i].z = i % 11 == 5 ? std::numeric_limits<float>::quiet_NaN() : depth;
    cloud[i].intensity = static_cast<float>(i * 37 % 200);
  }
  cloud.is_dense = false;
  return cloud;
}

} // namespace

class ProgramKept : public ProgramTest {
protected:
  /** \brief Writes clouds with these names into the folder named. */
  void
  writeNamed(const std::vector<std::string>& names) const
  {
    std::filesystem::remove_all(folder / "named");
    writeClouds("named", roomClouds(names.size()));
    for (std::size_t i = 0; i < names.size(); ++i)
      std::filesystem::rename(folder / ("named/00" + std::to_string(i) + ".pcd"),
                              folder / ("named/" + names[i] + ".pcd"));
  }
};

TEST_F(ProgramKept, ScansWithoutRaysAreToldToBeSo)
{
  std::mt19937_64 random(7);
  pcl::PointCloud<pcl::PointXYZI> anywhere(6, 5); // too few points to tell rays
  for (pcl::PointXYZI& point : anywhere)
    for (int axis = 0; axis < 3; ++axis)
      point.data[axis] = 0.02f * static_cast<float>(random() % 99) - 0.98f;
  pcl::PointCloud<pcl::PointXYZI> in_a_row = anywhere;
  in_a_row.width = 30;
  in_a_row.height = 1;
  const Eigen::Quaternionf none = Eigen::Quaternionf::Identity();
  for (const auto& [cloud, order] :
       {std::pair<pcl::PointCloud<pcl::PointXYZI>, std::string>{organisedWall(),
                                                                "in order, 80 x 60"},
        {anywhere, "in order, 6 x 5, without rays"},
        {in_a_row, "in order, without rays"}}) {
    writeWithViewpoint(folder / "points/0.pcd", cloud, Eigen::Vector4f::Zero(), none);
    const ProgramRun encoded =
        run("encode points -o x.pcxi --overwrite -r 0.001 --keep-order --law none");
    EXPECT_TRUE(hasPart(encoded.output, "points " + order + ", edge"))
        << encoded.output << encoded.errors;
    const ProgramRun info = expectRun("info x.pcxi");
    EXPECT_TRUE(hasPart(info.output, "| points " + order + " |"));
    expectRun("decode x.pcxi -o out --overwrite");
    const auto decoded = readCloud(folder / "out/000000.pcd");
    ASSERT_EQ(decoded.width, cloud.width);
    ASSERT_EQ(decoded.height, cloud.height);
    for (std::size_t i = 0; i < cloud.size(); ++i)
      ASSERT_EQ(std::isfinite(decoded[i].x), std::isfinite(cloud[i].z)) << i;
  }
}

TEST_F(ProgramKept, OrderIfThatIsAskedFor)
{
  // In no order, so that voxels take fewer bytes.
  std::mt19937_64 random(7);
  pcl::PointCloud<pcl::PointXYZI> sent;
  for (int i = 0; i < 300; ++i)
    sent.emplace_back(static_cast<float>(random() % 100) * 0.02f,
                      static_cast<float>(random() % 100) * 0.02f,
                      static_cast<float>(random() % 4) * 0.02f,
                      0.0f);
  writeClouds("points", {sent});
  const std::string encode = "encode points -r 0.01 --law none -o ";
  const ProgramRun any = run(encode + "any.pcxi --keep-points");
  EXPECT_FALSE(hasPart(any.output, "points in order"));
  EXPECT_FALSE(hasPart(any.errors, "the order of the points takes "));
  const ProgramRun kept = run(encode + "kept.pcxi --keep-order");
  EXPECT_TRUE(hasPart(kept.output, "points in order"));
  EXPECT_TRUE(hasPart(kept.output, " 0.02 m, the step of coordinates"));
  EXPECT_TRUE(hasPart(kept.errors,
                      "the order of the points takes " +
                          std::to_string(bytesOf(folder / "kept.pcxi").size() -
                                         bytesOf(folder / "any.pcxi").size())));
  expectRun("decode kept.pcxi -o kept");
  const pcl::PointCloud<pcl::PointXYZI> back = readCloud(folder / "kept/000000.pcd");
  ASSERT_EQ(back.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i)
    EXPECT_LT(
        (back[i].getVector3fMap() - sent[i].getVector3fMap()).lpNorm<Eigen::Infinity>(),
        0.0050001f);
}

TEST_F(ProgramKept, ViewpointsOfPcdFiles)
{
  const auto clouds = roomClouds(3);
  const Eigen::Vector4f first(1.5f, -2.25f, 0.75f, 0.0f);
  const Eigen::Vector4f last(3.0f, 0.0f, 0.75f, 0.0f);
  const Eigen::Quaternionf turned(0.5f, -0.5f, 0.5f, -0.5f);
  writeWithViewpoint(folder / "moved/0.pcd", clouds[0], first, turned);
  writeWithViewpoint(folder / "moved/1.pcd", clouds[1], first, turned);
  writeWithViewpoint(folder / "moved/2.pcd", clouds[2], last, turned);
  EXPECT_EQ(run("encode moved -o x.mcap").status, 0);
  expectRun("cut x.mcap -o cut.mcap");
  expectRun("decode cut.mcap -o out");
  for (const char* file : {"out/000000.pcd", "out/000001.pcd", "out/000002.pcd"}) {
    const pcl::PointCloud<pcl::PointXYZI> decoded = readCloud(folder / file);
    const bool is_last = std::string(file) == "out/000002.pcd";
    EXPECT_EQ(decoded.sensor_origin_, is_last ? last : first) << file;
    EXPECT_EQ(decoded.sensor_orientation_.coeffs(), turned.coeffs()) << file;
  }
  // Where it cannot be kept, the program says so.
  EXPECT_TRUE(hasPart(run("encode moved -o x.pcxi").errors, "VIEWPOINT"));
  EXPECT_TRUE(
      hasPart(run("encode moved -o y.mcap --pose 1,2,3,0,0,0").errors, "VIEWPOINT"));
}

TEST_F(ProgramKept, ViewpointsOfRecordingsThatAreMerged)
{
  const auto cloud = roomClouds(1)[0];
  const Eigen::Quaternionf straight = Eigen::Quaternionf::Identity();
  // Of the second recording all files have the default, as far as a reader can tell.
  const float places[3][2] = {{1.0f, 2.0f}, {0.0f, 0.0f}, {1.0f, 4.0f}};
  for (int part = 0; part < 3; ++part) {
    const std::string number = std::to_string(part);
    for (int i = 0; i < 2; ++i)
      writeWithViewpoint(folder / (number + "/s/160000000" + number + "." +
                                   std::to_string(i) + ".pcd"),
                         cloud,
                         {places[part][i], 0.0f, 0.0f, 0.0f},
                         straight);
    EXPECT_EQ(run("encode " + number + "/s -o " + number + ".mcap").status, 0);
  }
  expectRun("merge 2.mcap 0.mcap 1.mcap -o x.mcap");
  expectRun("decode x.mcap -o out");
  for (int frame = 0; frame < 6; ++frame)
    EXPECT_EQ(readCloud(folder / ("out/00000" + std::to_string(frame) + "_160000000" +
                                  std::to_string(frame / 2) + "." +
                                  std::to_string(frame % 2) + "00000000.pcd"))
                  .sensor_origin_.x(),
              places[frame / 2][frame % 2])
        << frame;
  // Parts of one recording keep its metadata as they are.
  expectRun("cut x.mcap -o a.mcap --frames :3 -q");
  expectRun("cut x.mcap -o b.mcap --frames 3: -q");
  EXPECT_EQ(run("merge a.mcap b.mcap -o ab.mcap -q").status, 0);
  recording::RecordingReader joined;
  recording::RecordingReader whole;
  ASSERT_TRUE(joined.open(folder / "ab.mcap").ok());
  ASSERT_TRUE(whole.open(folder / "x.mcap").ok());
  EXPECT_EQ(joined.streams()[0].metadata, whole.streams()[0].metadata);
}

TEST_F(ProgramKept, StampsInNamesOfFiles)
{
  // As numbers and as texts they are in different orders.
  writeNamed({"1305031102.175304", "1305031102.2", "1305031102.211214001"});
  expectRun("encode named -o x.mcap -r 0.05");
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  const nanoseconds second = std::chrono::seconds(1305031102);
  const nanoseconds stamps[] = {second + nanoseconds(175304000),
                                second + nanoseconds(200000000),
                                second + nanoseconds(211214001)};
  ASSERT_EQ(streams[0].frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(streams[0].frames[i].time, stamps[i]);
    EXPECT_EQ(streams[0].frames[i].stamp, stamps[i]);
  }
  // The decoded clouds have them, too, and another run finds them.
  expectRun("decode x.mcap -o out");
  EXPECT_TRUE(std::filesystem::exists(folder / "out/000000_1305031102.175304000.pcd"));
  expectRun("decode x.mcap -o out --overwrite");
  EXPECT_EQ(filesIn(folder / "out"), 3u);
  expectRun("encode out -o again.mcap -r 0.05");
  EXPECT_EQ(decode(folder / "again.mcap")[0].frames[2].stamp, stamps[2]);
  expectRun("encode named -o rate.mcap --rate 4");
  EXPECT_EQ(decode(folder / "rate.mcap")[0].frames[1].time,
            std::chrono::milliseconds(250));
}

TEST_F(ProgramKept, TimesInNamesOfFilesThatAreLeftOutAreToldOf)
{
  const std::string told =
      "pcl_ext encode: named: the times in the names are left out, ";
  writeNamed({"1305031102.5", "1305031102.50"});
  EXPECT_EQ(run("encode named -o x.mcap").errors,
            told + "as that of 'named/1305031102.50.pcd' is not later than that of "
                   "'named/1305031102.5.pcd'\n");
  writeNamed({"1305031102.5", "1305031102.6", "map"});
  EXPECT_EQ(run("encode named -o y.mcap").errors,
            told + "as 'named/map.pcd' has none\n");
  // Decoded files stay in the order of their frames where times go back.
  writeNamed({"000000_1305031103.000000000",
              "000001_1305031101.000000000",
              "000002_1305031102.000000000"});
  EXPECT_EQ(run("encode named -o z.mcap -r 0.05 --i-frame-rate 1").errors,
            told +
                "as that of 'named/000001_1305031101.000000000.pcd' is not later than "
                "that of 'named/000000_1305031103.000000000.pcd'\n");
  expectRun("encode named/000001_1305031101.000000000.pcd -o one.pcxi -r 0.05");
  EXPECT_EQ(decode(folder / "z.mcap")[0].voxels[1].keys,
            decode(folder / "one.pcxi")[0].voxels[0].keys);
}

TEST_F(ProgramKept, NamesThatAreStamps)
{
  using namespace std::chrono_literals;
  EXPECT_EQ(stampOfName("a/1305031102.175304.pcd"), 1305031102175304000ns);
  EXPECT_EQ(stampOfName("cloud_1700000000.5.pcd"), 1700000000500000000ns);
  EXPECT_EQ(stampOfName("12.345000000.pcd"), 12345ms); // of a simulation
  EXPECT_EQ(stampOfName("1403636579763555584.pcd"), 1403636579763555584ns);
  EXPECT_EQ(stampOfName("1403636579763555.bin"), 1403636579763555us);
  EXPECT_EQ(stampOfName("n015__LIDAR_TOP__1532402927647951.pcd.bin"),
            1532402927647951us);
  EXPECT_EQ(stampOfName("1403636579763.ply"), 1403636579763ms);
  EXPECT_EQ(stampOfName("1403636579.pcd"), 1403636579s);
  // Date and time of day, as PCL's recorder writes them.
  EXPECT_EQ(stampOfName("frame_20121214T142255.814212.pcd"), 1355494975814212us);
  EXPECT_EQ(stampOfName("20121231T235959.9.pcd"), 1356998399900ms);
  EXPECT_EQ(stampOfName("20130101T000000.pcd"), 1356998400s);
  EXPECT_EQ(stampOfName("a-20240229T000000.000001.pcd"), 1709164800000001us);
  for (const char* name : {"000123.pcd",
                           "0000000123.bin", // KITTI
                           "scan_2.1.pcd",
                           "20201122134635.pcd",
                           "9999999999999999999.pcd", // beyond 64 bits
                           "99999999999.5.pcd",
                           "1700000000.1234567890.pcd",
                           "20230229T142255.814212.pcd",
                           "20121314T142255.814212.pcd",
                           "20121214T246000.814212.pcd",
                           "20121214T142260.814212.pcd",
                           "19691231T142255.814212.pcd",
                           "cloud.pcd",
                           ".pcd",
                           ""})
    EXPECT_EQ(stampOfName(name), std::nullopt) << name;
}

TEST_F(ProgramKept, FieldsAndOrderThatAreLeftOutAreNamedOnce)
{
  std::filesystem::create_directories(folder / "lidar");
  for (const char* name : {"lidar/0.pcd", "lidar/1.pcd"}) {
    const std::string text =
        "VERSION .7\nFIELDS x y z intensity ring time\nSIZE 4 4 4 4 "
        "2 8\nTYPE F F F F U F\nCOUNT 1 1 1 1 1 1\nWIDTH 2\n"
        "HEIGHT 2\nPOINTS 4\nDATA ascii\n1 0 0 5 0 .1\n2 0 0 5 1 "
        ".2\n3 0 0 5 2 .3\n4 0 0 5 3 .4\n";
    writeText(folder / name, text);
  }
  EXPECT_EQ(
      run("encode lidar -o x.mcap").errors,
      "pcl_ext encode: /lidar: fields that are left out: ring, time; the rows and "
      "columns of the points are not kept; --fields keeps fields\n");
}

TEST_F(ProgramKept, RowsAndColumnsOfFilesThatDiffer)
{
  const auto write =
      [this](const std::string& name, const std::string& fields, std::size_t columns) {
        const bool has_ring = fields == "x y z ring";
        std::string text =
            "VERSION .7\nFIELDS " + fields +
            (has_ring ? "\nSIZE 4 4 4 2\nTYPE F F F U" : "\nSIZE 4 4 4\nTYPE F F F") +
            "\nWIDTH " + std::to_string(columns) + "\nHEIGHT 3\nDATA ascii\n";
        for (std::size_t i = 0; i < 3 * columns; ++i)
          text += std::to_string(i) + " 0 0" + (has_ring ? " 1\n" : "\n");
        writeText(folder / name, text);
      };
  std::filesystem::create_directories(folder / "lidar");
  write("lidar/0.pcd", "x y z", 4);
  write("lidar/1.pcd", "x y z", 5);
  expectRun("encode lidar -q -o x.mcap --keep-order");
  expectRun("decode x.mcap -o again");
  EXPECT_EQ(run("encode again -q -o y.mcap --keep-order").errors, "");
  const DecodedStream stream = decode(folder / "y.mcap")[0];
  ASSERT_EQ(stream.frames.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto cloud = readCloud(folder / ("again/00000" + std::to_string(i) + ".pcd"));
    EXPECT_EQ(cloud.width, 4 + i);
    EXPECT_EQ(cloud.height, 3u);
    EXPECT_EQ(stream.voxels[i].pointCount(), 12 + 3 * i);
  }
  // Of several sensors, as it seems.
  write("lidar/2.pcd", "x y z ring", 4);
  const ProgramRun ring = expectRemark(
      "encode lidar -o ring.mcap --keep-order",
      "lidar: 'lidar/2.pcd' (4 x 3 points with x y z ring) is unlike 'lidar/0.pcd' "
      "(4 x 3 points with x y z); if they are of several sensors, put those of each "
      "into a folder of their own and name the folders\n");
  EXPECT_TRUE(hasPart(ring.errors, "fields that are left out: ring"));
  write("lidar/2.pcd", "x y z", 9);
  EXPECT_TRUE(hasPart(run("encode lidar -o wide.mcap").errors,
                      "'lidar/2.pcd' (9 x 3 points with x y z) is unlike"));
}

TEST_F(ProgramKept, RowsAndColumnsWithoutAnyPoint)
{
  pcl::PointCloud<pcl::PointXYZI> points(4, 3);
  auto none = points;
  for (auto& point : none)
    point.x = std::numeric_limits<float>::quiet_NaN();
  none.is_dense = false;
  writeClouds("camera", {points, none, points});
  expectRun("encode camera -q -o x.mcap --keep-order");
  EXPECT_EQ(expectRun("decode x.mcap -o out").output, "out: 3 frames, 24 points\n");
  const pcl::PointCloud<pcl::PointXYZI> decoded = readCloud(folder / "out/000001.pcd");
  EXPECT_EQ(decoded.width, 4u);
  EXPECT_EQ(decoded.height, 3u);
  for (const auto& point : decoded)
    EXPECT_TRUE(std::isnan(point.x));
  // PLY has no points that are missing.
  EXPECT_EQ(expectRun("decode x.mcap -o ply --ply").output,
            "ply: 3 frames, 24 points, 1 frame without points and file\n");
}

} // namespace pcl_ext::tools::test
