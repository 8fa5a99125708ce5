#include "noise/labelled_scans.h"
#include "support/test_folder.h"

#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::noise;
namespace fs = std::filesystem;

/** \brief An empty folder that is removed with the object. */
class Folder {
public:
  fs::path
  operator/(const std::string& name) const
  {
    const fs::path path = folder_ / name;
    fs::create_directories(path.parent_path());
    return path;
  }

  std::string
  path() const
  {
    return folder_ / "";
  }

private:
  pcl_ext::recording::test::TestFolder folder_;
};

template <typename NumberT>
void
write(const fs::path& path, const std::vector<NumberT>& numbers)
{
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(numbers.data()),
             static_cast<std::streamsize>(numbers.size() * sizeof(NumberT)));
}

const std::vector<float> two_points = {1, 2, 3, 0.5f, 4, 5, 6, 0.25f};

LabelledScan
scanOf(const std::string& folder, std::size_t index = 0, LabelMeanings meanings = {})
{
  LabelledScan scan;
  ScansOfFolder(folder, std::move(meanings)).read(index, scan);
  return scan;
}

/** \brief What reading a folder's first scan fails with. */
std::string
failureOf(const std::string& folder)
{
  try {
    scanOf(folder);
  }
  catch (const std::runtime_error& error) {
    return error.what();
  }
  return "it was read";
}

TEST(LabelledScans, FilesAreFoundInAllLayoutsInTheOrderOfTheirNumbers)
{
  const std::array<std::array<std::string, 2>, 3> layouts = {
      {{"", ""}, {"velodyne/", "labels/"}, {"snow_velodyne/", "snow_labels/"}}};
  for (const auto& [scans, labels] : layouts) {
    const Folder folder;
    write(folder / (scans + "10.bin"), two_points);
    write<std::uint32_t>(folder / (labels + "10.label"), {1, 0});
    write<float>(folder / (scans + "9.bin"), {7, 8, 9, 0.5f});
    write<std::uint32_t>(folder / (labels + "9.label"), {0});
    EXPECT_EQ(ScansOfFolder(folder.path(), {}).size(), 2u);
    EXPECT_EQ(scanOf(folder.path()).name, "9") << scans;
    EXPECT_EQ(scanOf(folder.path()).cloud[0].z, 9.0f) << scans;
    const LabelledScan scan = scanOf(folder.path(), 1);
    ASSERT_EQ(scan.cloud.size(), 2u);
    EXPECT_EQ(scan.cloud[1].y, 5.0f);
    EXPECT_EQ(scan.cloud[1].intensity, 0.25f);
    EXPECT_EQ(scan.classes,
              (std::vector<PointClass>{PointClass::Noise, PointClass::Surface}));
  }
}

TEST(LabelledScans, TheClassIsTheLowerHalfOfALabel)
{
  const Folder folder;
  write(folder / "a.bin", two_points);
  // An instance in the upper half is no class.
  write<std::uint32_t>(folder / "a.label", {0x00010000u | 40u, 0xffff0000u | 110u});
  EXPECT_EQ(scanOf(folder.path()).classes,
            (std::vector<PointClass>{PointClass::Surface, PointClass::Noise}));
}

TEST(LabelledScans, MeaningsOfLabels)
{
  LabelMeanings meanings;
  meanings.ignored = {0, 1};
  meanings.persons = {30, 110};
  EXPECT_EQ(meanings.classOf(0), PointClass::Ignored);
  EXPECT_EQ(meanings.classOf(1), PointClass::Ignored); // before noise
  EXPECT_EQ(meanings.classOf(110), PointClass::Noise); // before persons
  EXPECT_EQ(meanings.classOf(30), PointClass::Person);
  EXPECT_EQ(meanings.classOf(80), PointClass::Pole);
  EXPECT_EQ(meanings.classOf(40), PointClass::Surface);
  EXPECT_EQ(LabelMeanings().classOf(0), PointClass::Surface);
}

TEST(LabelledScans, MissingReturnsHaveNoCoordinates)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Folder folder;
  write<float>(folder / "a.bin", {0,   0,  0,  0.5f, // no return
                                  -1,  -1, -1, -1, // of an image without a return there
                                  -1,  -1, -1, 0.5f, // a point
                                  nan, 1,  1,  1,    //
                                  0,   0,  1,  0});  // a point
  write<std::uint32_t>(folder / "a.label", {1, 1, 1, 1, 1});
  const LabelledScan scan = scanOf(folder.path());
  const PointClass missing = PointClass::Missing;
  const PointClass noise = PointClass::Noise;
  EXPECT_EQ(scan.classes,
            (std::vector<PointClass>{missing, missing, noise, missing, noise}));
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    EXPECT_EQ(std::isnan(scan.cloud[i].z), scan.classes[i] == missing) << i;
  EXPECT_EQ(scan.index_of_return, (std::vector<std::size_t>{2, 4}));
  ASSERT_EQ(scan.returns->size(), 2u);
  EXPECT_EQ((*scan.returns)[1].z, 1.0f);
}

TEST(LabelledScans, LabelsOfPcdFilesAreTheirField)
{
  pcl::PointCloud<pcl::PointXYZL> points(2, 1);
  points[0].x = points[1].x = 5.0f;
  points[0].label = 110;
  points[1].label = 0x50000u + 30u;
  const Folder folder;
  pcl::io::savePCDFileBinary((folder / "a.pcd").string(), points);
  const LabelledScan scan = scanOf(folder.path());
  EXPECT_EQ(scan.classes,
            (std::vector<PointClass>{PointClass::Noise, PointClass::Person}));
  EXPECT_EQ(scan.cloud[1].x, 5.0f);
  EXPECT_EQ(scan.cloud[1].intensity, 0.0f);

  pcl::PointCloud<pcl::PointXYZ> unlabelled(1, 1);
  pcl::io::savePCDFileBinary((folder / "a.pcd").string(), unlabelled);
  EXPECT_NE(failureOf(folder.path()).find("a.pcd': it has no field 'label'"),
            std::string::npos)
      << failureOf(folder.path());
}

TEST(LabelledScans, WrongSizesAreNamedWithTheirNumbers)
{
  const auto names = [](const std::string& message,
                        const std::vector<std::string>& words) {
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << message;
  };
  const Folder folder;
  write(folder / "a.bin", two_points);
  for (const std::size_t labels : {0, 1, 3}) {
    write(folder / "a.label", std::vector<std::uint32_t>(labels));
    names(failureOf(folder.path()),
          {"a.label' has " + std::to_string(4 * labels) + " bytes",
           "2 points",
           "8 bytes"});
  }
  write<std::uint8_t>(folder / "a.label", {1, 2, 3, 4, 5, 6, 7});
  names(failureOf(folder.path()), {"a.label' has 7 bytes"});
  write<std::uint32_t>(folder / "a.label", {0, 0});
  write<std::uint8_t>(folder / "a.bin", std::vector<std::uint8_t>(33));
  names(failureOf(folder.path()), {"a.bin'", "33", "multiple of 16"});
}

TEST(LabelledScans, FilesOfImagesHaveRows)
{
  const Folder folder;
  write<float>(folder / "a.bin", std::vector<float>(4 * 6, 1.0f));
  write(folder / "a.label", std::vector<std::uint32_t>(6));
  LabelledScan scan;
  ScansOfFolder(folder.path(), {}, 2).read(0, scan);
  EXPECT_EQ(scan.cloud.width, 3u);
  EXPECT_EQ(scan.cloud.height, 2u);
  try {
    ScansOfFolder(folder.path(), {}, 4).read(0, scan);
    ADD_FAILURE() << "it was read";
  }
  catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("a.bin' has 6 points"), std::string::npos)
        << error.what();
  }
}

TEST(LabelledScans, FoldersWithoutLabelledScansAreRefused)
{
  const Folder folder;
  EXPECT_NE(failureOf(folder.path()).find("has no labelled scans"), std::string::npos);
  EXPECT_NE(failureOf(folder.path() + "/a").find("is no folder"), std::string::npos);
  write(folder / "a.bin", two_points);
  EXPECT_NE(failureOf(folder.path()).find("a.bin' has no labels"), std::string::npos);
}

} // namespace
