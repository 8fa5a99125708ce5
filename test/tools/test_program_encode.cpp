// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "tools/program.h"

#include <pcl/common/io.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <sstream>

namespace pcl_ext::tools::test {

namespace {

using Clouds = std::vector<pcl::PointCloud<pcl::PointXYZI>>;

/** \brief The bytes that a user of the class has on disk. */
template <typename PointT, typename ModelT>
Bytes
bytesOfClass(const Clouds& clouds, const io::IntensityCompressionSettings& settings)
{
  io::OctreePointCloudIntensityCompression<PointT, ModelT> encoder(settings);
  std::ostringstream file;
  for (const auto& cloud : clouds) {
    typename pcl::PointCloud<PointT>::Ptr points(new pcl::PointCloud<PointT>);
    pcl::copyPointCloud(cloud, *points);
    EXPECT_TRUE(encoder.encodePointCloud(points, file).ok());
  }
  const std::string text = file.str();
  return {text.begin(), text.end()};
}

class ProgramEncode : public ProgramTest {
protected:
  template <typename PointT, typename ModelT>
  void
  expectBytesOfClass(const std::string& options,
                     const Clouds& clouds,
                     const io::IntensityCompressionSettings& settings) const
  {
    expectRun("encode room -o x.pcxi --no-header --overwrite " + options);
    EXPECT_EQ(bytesOf(folder / "x.pcxi"),
              (bytesOfClass<PointT, ModelT>(clouds, settings)))
        << options;
  }
};

} // namespace

TEST_F(ProgramEncode, FileHasTheBytesOfTheClass)
{
  const Clouds clouds = roomClouds(7);
  writeClouds("room", clouds);
  // Defaults are those of the class, but for the effort of files. That each option sets
  // its setting: test_setting_options.cpp.
  io::IntensityCompressionSettings settings;
  settings.effort = io::Effort::Balanced;
  expectBytesOfClass<pcl::PointXYZI, NativeIntensity>("", clouds, settings);
  expectBytesOfClass<pcl::PointXYZ, NoIntensity>("--law none", clouds, settings);
  io::IntensityCompressionSettings filtered = settings;
  for (const auto& [option, frames] : std::vector<std::pair<std::string, unsigned int>>{
           {"", 8}, {"=2", 2}, {"=0", 0}}) {
    filtered.temporal_filter = frames;
    // Clouds of the class have no stamps, which counts as 20 a second.
    expectBytesOfClass<pcl::PointXYZI, NativeIntensity>(
        "--rate 20 --temporal-filter" + option, clouds, filtered);
  }
  io::IntensityCompressionSettings published;
  published.resolution = 0.05;
  published.format = io::StreamFormat::Published;
  published.colour_bits = 0;
  expectRun("encode room -o y.pcxi -r 0.05 -l count --format published");
  EXPECT_EQ(bytesOf(folder / "y.pcxi"),
            (bytesOfClass<pcl::PointXYZ, CountIntensity>(clouds, published)));
  pcl::PointCloud<pcl::PointXYZ> plain;
  pcl::copyPointCloud(clouds[0], plain);
  std::filesystem::remove_all(folder / "room");
  std::filesystem::create_directory(folder / "room");
  pcl::io::savePCDFileBinary(folder / "room/0.pcd", plain);
  expectBytesOfClass<pcl::PointXYZ, NoIntensity>("", {clouds[0]}, settings);
}
TEST_F(ProgramEncode, SensorPoseCropAndOutliersAreThoseOfTheNode)
{
  const Clouds clouds = roomClouds(3);
  writeClouds("room", clouds);
  nodes::SensorNodeSettings settings;
  settings.compression.resolution = 0.05;
  settings.compression.effort = io::Effort::Balanced;
  settings.law = IntensityLaw::Quadratic;
  settings.sensor = RuntimeSensor(70.0, 60.0, 100, 90);
  settings.crop_box = io::BoundingBox{{0.0, -1.0, -1.0}, {4.0, 2.0, 1.5}};
  settings.outlier_removal.emplace();
  nodes::SensorNode node(settings);
  ASSERT_TRUE(node.settingsStatus().ok()) << node.settingsStatus();
  // Half a turn about x and a way.
  WorldPose pose = WorldPose::Identity();
  pose.translate(Eigen::Vector3d(1.0, 0.5, 2.0));
  pose.rotate(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0));
  Bytes expected;
  for (const auto& cloud : clouds) {
    pcl::PCLPointCloud2 message;
    pcl::toPCLPointCloud2(cloud, message);
    Bytes bytes;
    ASSERT_TRUE(node.encode(message, pose, bytes).hasFrame());
    expected.insert(expected.end(), bytes.begin(), bytes.end());
  }
  const std::string common = "encode room -r 0.05 -l quadratic --sensor 70,60,100,90 "
                             "--crop 0,-1,-1,4,2,1.5 --remove-outliers --no-header ";
  expectRun(common + "-o quaternion.pcxi --pose 1,0.5,2,1,0,0,0");
  EXPECT_EQ(bytesOf(folder / "quaternion.pcxi"), expected);
  expectRun(common + "-o matrix.pcxi --pose "
                     "'1 0 0 1  0 -1 0 0.5  0 0 -1 2  0 0 0 1'");
  EXPECT_EQ(bytesOf(folder / "matrix.pcxi"), expected);
  expectRun(common + "-o x.mcap --pose 1,0.5,2,1,0,0,0");
  recording::RecordingReader reader;
  ASSERT_TRUE(reader.open(folder / "x.mcap").ok());
  EXPECT_EQ(reader.streams()[0].metadata.at("sensor_pose"), "1,0.5,2,1,0,0,0");
  EXPECT_EQ(reader.streams()[0].metadata.at("crop_box"), "0,-1,-1,4,2,1.5");
  expectRun(common + "-o named.pcxi --pose /room=1,0.5,2,1,0,0,0");
  EXPECT_EQ(bytesOf(folder / "named.pcxi"), expected);
}

TEST_F(ProgramEncode, NumbersInNamesOfFilesOrderThem)
{
  writeClouds("room", roomClouds(4));
  std::filesystem::create_directories(folder / "numbered");
  const char* const names[] = {"cloud_2", "cloud_009", "cloud_10", "cloud_11"};
  for (std::size_t i = 0; i < 4; ++i)
    std::filesystem::copy(folder / ("room/00" + std::to_string(i) + ".pcd"),
                          folder / (std::string("numbered/") + names[i] + ".pcd"));
  expectRun("encode room -o room.pcxi -r 0.05");
  expectRun("encode numbered -o folder.pcxi -r 0.05");
  expectRun("encode 'numbered/*.pcd' -o pattern.pcxi -r 0.05");
  EXPECT_EQ(bytesOf(folder / "folder.pcxi"), bytesOf(folder / "room.pcxi"));
  EXPECT_EQ(bytesOf(folder / "pattern.pcxi"), bytesOf(folder / "room.pcxi"));
}

TEST_F(ProgramEncode, AnglesAreAboutTheFixedAxes)
{
  pcl::PointCloud<pcl::PointXYZI> cloud;
  cloud.push_back(pcl::PointXYZI{1.01f, 2.01f, 3.01f, 0.0f});
  writeClouds("point", {cloud});
  // Roll turns (1, 2, 3) to (1, -3, 2), yaw then to (3, 1, 2).
  expectRun("encode point -o x.pcxi -r 0.1 --pose 10,20,30,90,0,90");
  expectRun("decode x.pcxi -o decoded");
  const auto decoded = readCloud(folder / "decoded/000000.pcd");
  ASSERT_EQ(decoded.size(), 1u);
  EXPECT_NEAR(decoded[0].x, 13.01f, 0.06f);
  EXPECT_NEAR(decoded[0].y, 21.01f, 0.06f);
  EXPECT_NEAR(decoded[0].z, 32.01f, 0.06f);
}

TEST_F(ProgramEncode, TimesFollowTheRateAndHeadersAreCarried)
{
  writeClouds("a", roomClouds(4, 1));
  writeClouds("b", roomClouds(2, 2));
  expectRun("encode a b -o x.mcap --rate 4 --frame-id hall --frames 1:");
  const std::vector<DecodedStream> streams = decode(folder / "x.mcap");
  ASSERT_EQ(streams.size(), 2u);
  EXPECT_EQ(streams[0].name, "/a");
  EXPECT_EQ(streams[1].name, "/b");
  ASSERT_EQ(streams[0].frames.size(), 3u);
  ASSERT_EQ(streams[1].frames.size(), 1u);
  for (std::size_t i = 0; i < 3; ++i) {
    const recording::Time time = std::chrono::milliseconds(250 * (i + 1));
    EXPECT_EQ(streams[0].frames[i].time, time);
    EXPECT_EQ(streams[0].frames[i].stamp, time);
    EXPECT_EQ(streams[0].frames[i].frame_id, "hall");
  }
}

TEST_F(ProgramEncode, FilesOfAllKindsAndPatternsAreOneStream)
{
  const Clouds clouds = roomClouds(4);
  std::filesystem::create_directories(folder / "room");
  ASSERT_EQ(pcl::io::savePCDFileASCII(folder / "room/0.pcd", clouds[0]), 0);
  ASSERT_EQ(pcl::io::savePCDFileBinaryCompressed(folder / "room/1.pcd", clouds[1]), 0);
  ASSERT_EQ(pcl::io::savePLYFileBinary(folder / "room/2.ply", clouds[2]), 0);
  std::string kitti;
  for (const pcl::PointXYZI& point : clouds[3])
    for (const float number : {point.x, point.y, point.z, point.intensity})
      kitti.append(reinterpret_cast<const char*>(&number), sizeof(number));
  writeText(folder / "room/3.bin", kitti);
  expectRun("encode 'room/*' -o pattern.pcxi --resolution 0.05");
  expectRun("encode room/ -o folder.pcxi --resolution 0.05");
  expectRun("encode room/0.pcd room/1.pcd room/2.ply room/3.bin -o files.pcxi "
            "--resolution 0.05");
  EXPECT_EQ(decode(folder / "folder.pcxi")[0].frames.size(), 4u);
  EXPECT_EQ(bytesOf(folder / "pattern.pcxi"), bytesOf(folder / "folder.pcxi"));
  EXPECT_EQ(bytesOf(folder / "files.pcxi"), bytesOf(folder / "folder.pcxi"));
}

TEST_F(ProgramEncode, NothingIsWrittenUnderTheNameOfAnOutputThatFails)
{
  writeClouds("room", roomClouds(2));
  const Bytes before = {1, 2, 3};
  writeBytes(folder / "x.mcap", before);
  const std::string text =
      "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\n"
      "HEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3x\n";
  writeText(folder / "no.pcd", text);
  for (const std::string output : {"x.mcap", "y.pcxi"}) {
    const ProgramRun failed = run("encode no.pcd --overwrite -o " + output);
    EXPECT_EQ(failed.status, 1);
    for (const std::string& part :
         {std::string("'no.pcd': line 9: '3x' is no number of the field 'z'"),
          "'" + output + "' was not written"})
      EXPECT_TRUE(hasPart(failed.errors, part));
    EXPECT_FALSE(std::filesystem::exists(folder / (output + ".unfinished")));
  }
  EXPECT_EQ(bytesOf(folder / "x.mcap"), before);
  EXPECT_FALSE(std::filesystem::exists(folder / "y.pcxi"));
  EXPECT_EQ(runShell("\"$P\" encode room -o - > /dev/full").status, 1);
}
TEST_F(ProgramEncode, SummaryTellsVoxelsEdgeRateAndWhatWasLeftOut)
{
  Clouds clouds = roomClouds(3);
  std::size_t infinite = 0; // most of the first cloud's
  for (auto& cloud : clouds) {
    for (std::size_t i = 0; i < (&cloud == clouds.data() ? cloud.size() : 10); ++i)
      if (i % 10 != 0) {
        cloud[i].x = std::numeric_limits<float>::infinity();
        ++infinite;
      }
    cloud.is_dense = false;
  }
  writeClouds("room", clouds);
  const ProgramRun result =
      run("encode room -o x.pcxi -r 0.1 --crop -2,-2,1.8,2,2,3 --rate 4");
  EXPECT_EQ(result.status, 0) << result.errors;
  const DecodedStream stream = decode(folder / "x.pcxi")[0];
  std::size_t voxels = 0;
  std::size_t points = 0;
  for (const io::VoxelFrame& frame : stream.voxels)
    voxels += frame.size();
  std::size_t outside = 0;
  for (const auto& cloud : clouds)
    for (const pcl::PointXYZI& point : cloud)
      ++(std::isinf(point.x) || point.z < 1.8f ? outside : points);
  outside -= infinite;
  const auto bytes = static_cast<double>(bytesOf(folder / "x.pcxi").size());
  const auto text = [](double number, int digits) {
    char buffer[40];
    std::snprintf(buffer, sizeof(buffer), "%.*f", digits, number);
    return std::string(buffer);
  };
  std::string output;
  for (const char letter : result.output)
    if (letter != ',')
      output += letter;
  EXPECT_TRUE(hasPart(output,
                      std::to_string(points) + " points in " + std::to_string(voxels) +
                          " voxels of 0.1 m ("));
  EXPECT_TRUE(
      hasPart(output,
              text(static_cast<double>(points) / static_cast<double>(voxels), 1) +
                  " points a voxel)"));
  EXPECT_TRUE(
      hasPart(output, std::to_string(infinite) + " points left out as not finite"));
  EXPECT_TRUE(
      hasPart(output, std::to_string(outside) + " points left out outside the box"));
  // Three frames at 4 Hz take 0.75 s.
  EXPECT_TRUE(hasPart(
      output, text(bytes, 0) + " bytes (" + text(bytes / 0.75, 0) + " bytes/s)"));
  EXPECT_TRUE(hasPart(output,
                      "ratio " + text(16.0 * static_cast<double>(points) / bytes, 1) +
                          " against 16 bytes a point (x y z intensity)\n"));
}

} // namespace pcl_ext::tools::test
