/** \file
 * Fields of files and recordings through the program and back.
 */
#include "tools/program.h"

#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace tools {
namespace test {

namespace {

/** \brief A cloud with a ring (UINT16) and a time (FLOAT64) after the coordinates, as a
 * PCD file has it. */
pcl::PCLPointCloud2
cloudWithRings()
{
  pcl::PCLPointCloud2 cloud;
  const std::vector<std::pair<std::string, std::uint8_t>> fields = {
      {"x", pcl::PCLPointField::FLOAT32},
      {"y", pcl::PCLPointField::FLOAT32},
      {"z", pcl::PCLPointField::FLOAT32},
      {"ring", pcl::PCLPointField::UINT16},
      {"time:gps", pcl::PCLPointField::FLOAT64}};
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

/** \brief All that points have from the fourth field on. */
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

/** \brief A folder with such a cloud in clouds/0.pcd. */
class ProgramFields : public ::testing::Test {
protected:
  ProgramFields()
  {
    std::filesystem::create_directories(folder_ / "clouds");
    EXPECT_EQ(pcl::PCDWriter().writeBinary(folder_ / "clouds/0.pcd", cloudWithRings()),
              0);
  }

  TestFolder folder_;
};

} // namespace

TEST_F(ProgramFields, ComeBackInFilesAndInMessages)
{
  expectRun(folder_, "encode clouds -o x.mcap -r 0.1 --keep-point-counts --fields all");
  expectRun(folder_, "decode x.mcap -o out");
  expectRun(folder_, "decode x.mcap -o messages.mcap");
  // The messages are as good as the files.
  expectRun(folder_,
            "encode messages.mcap -o y.mcap -r 0.1 --keep-point-counts --fields all");
  expectRun(folder_, "decode y.mcap -o again");
  const pcl::PCLPointCloud2 sent = cloudWithRings();
  for (const char* file : {"out/000000.pcd", "again/000000.pcd"}) {
    pcl::PCLPointCloud2 received;
    ASSERT_EQ(pcl::io::loadPCDFile(folder_ / file, received), 0) << file;
    ASSERT_EQ(received.fields.size(), sent.fields.size());
    for (std::size_t i = 0; i < sent.fields.size(); ++i) {
      EXPECT_EQ(received.fields[i].name, sent.fields[i].name);
      EXPECT_EQ(received.fields[i].datatype, sent.fields[i].datatype);
    }
    EXPECT_EQ(furtherBytes(received), furtherBytes(sent)) << file;
  }
}

TEST_F(ProgramFields, AreNamedByInfo)
{
  expectRun(folder_, "encode clouds -o x.pcxi --fields time:gps:0.01,ring");
  const ProgramRun table = expectRun(folder_, "info x.pcxi");
  EXPECT_NE(table.output.find("field time:gps, field ring"), std::string::npos)
      << table.output;
  const ProgramRun json = expectRun(folder_, "info --json x.pcxi");
  EXPECT_NE(json.output.find("\"name\": \"time:gps\""), std::string::npos);
  EXPECT_NE(json.output.find("\"type\": \"float64\""), std::string::npos);
  EXPECT_NE(json.output.find("\"step\": 0.01"), std::string::npos);
}

TEST_F(ProgramFields, ThatAreLeftOutAreNamedWithTheOption)
{
  const ProgramRun without = run(folder_, "encode clouds -o x.pcxi --fields ring");
  EXPECT_EQ(without.status, 0);
  EXPECT_NE((without.output + without.errors)
                .find("fields that are left out: time:gps; --fields keeps fields"),
            std::string::npos)
      << without.output << without.errors;
}

TEST_F(ProgramFields, OfMistakenOptionsAreRefused)
{
  expectFailure(folder_,
                "encode clouds -o x.pcxi --fields ,",
                2,
                "--fields is ','; it must be names");
  expectFailure(folder_,
                "encode clouds -o x.pcxi --fields ring:0",
                2,
                "--fields is 'ring:0'; it must be names");
  expectFailure(folder_,
                "encode clouds -o x.pcxi --fields ring:a",
                2,
                "--fields is 'ring:a'; it");
  expectFailure(folder_,
                "encode clouds -o x.pcxi --fields ring --format published",
                2,
                "--fields is set; it must be empty in the published layout");
  expectFailure(folder_,
                "encode clouds -o x.pcxi --fields ring --temporal-filter",
                2,
                "--fields is set; it must be empty with --temporal-filter");
  const ProgramRun missing = run(folder_, "encode clouds -o x.pcxi --fields label");
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.errors.find(
                "the cloud has no field 'label' to keep; it has: 'ring', 'time:gps'"),
            std::string::npos)
      << missing.errors;
}

} // namespace test
} // namespace tools
} // namespace pcl_ext
