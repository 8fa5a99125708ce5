#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "tools/program.h"

#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

namespace pcl_ext {
namespace tools {
namespace test {

namespace {

/** \brief The points of the small room alone. */
pcl::PointCloud<pcl::PointXYZ>
roomPoints()
{
  pcl::PointCloud<pcl::PointXYZ> cloud;
  pcl::copyPointCloud(roomClouds(1)[0], cloud);
  return cloud;
}

void
expectText(const std::string& text, const std::string& part)
{
  EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
}

} // namespace

TEST(ProgramDefaults, AreThoseOfTheClassButForTheEffortOfFiles)
{
  const TestFolder folder;
  const pcl::PointCloud<pcl::PointXYZ> cloud = roomPoints();
  pcl::io::savePCDFileBinary(folder / "room.pcd", cloud);
  io::IntensityCompressionSettings settings;
  settings.effort = io::Effort::Balanced;
  io::OctreePointCloudIntensityCompression<pcl::PointXYZ> encoder(settings);
  std::ostringstream frame;
  ASSERT_TRUE(encoder.encodePointCloud(cloud.makeShared(), frame).ok());
  expectRun(folder, "encode room.pcd -o x.pcxi --no-header");
  const Bytes bytes = bytesOf(folder / "x.pcxi");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), frame.str());
  expectFailure(folder,
                "encode room.pcd -o x.pcxi --overwrite --intensity-bits 4",
                2,
                "--intensity-bits has no effect on clouds without intensities");
}

TEST(ProgramEncode, SummaryTellsVoxelsEdgeRateAndWhatWasLeftOut)
{
  const TestFolder folder;
  std::vector<pcl::PointCloud<pcl::PointXYZI>> clouds = roomClouds(3);
  for (auto& cloud : clouds) {
    cloud[7].x = std::numeric_limits<float>::quiet_NaN();
    cloud.is_dense = false;
  }
  writeClouds(folder, "room", clouds);
  const ProgramRun result =
      run(folder, "encode room -o x.pcxi -r 0.1 --crop -2,-2,1.8,2,2,3 --rate 4");
  EXPECT_EQ(result.status, 0) << result.errors;
  const DecodedStream stream = decode(folder / "x.pcxi")[0];
  std::size_t voxels = 0;
  std::size_t points = 0;
  for (const io::VoxelFrame& frame : stream.voxels)
    voxels += frame.size();
  std::size_t outside = 0;
  for (const auto& cloud : clouds)
    for (const pcl::PointXYZI& point : cloud)
      ++(std::isnan(point.x) ? outside : point.z >= 1.8f ? points : outside);
  outside -= clouds.size();
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
  expectText(output,
             std::to_string(points) + " points in " + std::to_string(voxels) +
                 " voxels of 0.1 m (");
  expectText(output,
             text(static_cast<double>(points) / static_cast<double>(voxels), 1) +
                 " points a voxel)");
  expectText(output, "3 points left out as not finite");
  expectText(output, std::to_string(outside) + " points left out beyond box or grid");
  // Three frames at 4 Hz take 0.75 s.
  expectText(output, text(bytes, 0) + " bytes (" + text(bytes / 0.75, 0) + " bytes/s)");
  expectText(output,
             "ratio " + text(16.0 * static_cast<double>(points) / bytes, 1) +
                 " against 16 bytes a point");
}

TEST(ProgramEncode, CloudThatSeemsToBeInMillimetresIsNoticed)
{
  const TestFolder folder;
  pcl::PointCloud<pcl::PointXYZ> cloud = roomPoints();
  pcl::io::savePCDFileBinary(folder / "metres.pcd", cloud);
  expectRun(folder, "encode metres.pcd -o x.pcxi");
  for (pcl::PointXYZ& point : cloud)
    point.getVector3fMap() *= 1000.0f;
  pcl::io::savePCDFileBinary(folder / "mm.pcd", cloud);
  const ProgramRun result = run(folder, "encode mm.pcd -o x.pcxi --overwrite");
  EXPECT_EQ(result.status, 0);
  expectText(result.errors, "if that is in millimetres, --resolution 10 makes voxels");
}

TEST(ProgramDecode, SaysWhyHardlyAnyOutlierIsFound)
{
  const TestFolder folder;
  writeClouds(folder, "room", roomClouds(3));
  expectRun(folder, "encode room -o native.mcap -r 0.1");
  const ProgramRun native = run(folder, "decode native.mcap -o a --remove-outliers");
  EXPECT_EQ(native.status, 0);
  expectText(native.errors, "only voxels that are seldom occupied are noise");
  expectRun(folder, "encode room -o none.pcxi -r 0.1 -l none");
  const ProgramRun none = run(folder, "decode none.pcxi -o b --remove-outliers");
  EXPECT_EQ(none.status, 0);
  expectText(none.errors, "only voxels that are seldom occupied are noise");
}

TEST(ProgramHelp, UnknownCommandsAndUnitsAreExplained)
{
  const TestFolder folder;
  expectFailure(folder,
                "encod x.pcd -o x.pcxi",
                2,
                "there is no command 'encod'; there are encode, decode, info");
  expectFailure(folder,
                "encode x.pcd -o x.pcxi --resolution 5cm",
                2,
                "'5cm' is no number: edge of a voxel, metres, such as 0.05");
}

} // namespace test
} // namespace tools
} // namespace pcl_ext
