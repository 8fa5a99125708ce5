// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/point_cloud_messages.h"
#include "tools/cloud_bags.h"
#include "tools/program.h"
#ifdef PCL_EXT_HAS_SQLITE
#include "support/database_bags.h"
#endif

#include <pcl/PCLPointField.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>

namespace pcl_ext::tools::test {

namespace {

namespace fs = std::filesystem;

using recording::McapChannel;
using recording::McapMessage;
using recording::PointCloudMessage;
using recording::Time;

constexpr std::size_t width = 16;
constexpr std::size_t height = 4;

/** \brief A wall in 4 rows, two metres away: x, y, z, intensity. */
PointCloudMessage
wall(std::size_t i)
{
  PointCloudMessage message;
  message.stamp = std::chrono::seconds(100) + std::chrono::milliseconds(100 * i);
  message.frame_id = "lidar";
  message.width = width;
  message.height = height;
  message.fields = {
      {"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 12, 7, 1}};
  message.point_step = 16;
  message.row_step = 16 * width;
  message.is_dense = true;
  for (std::size_t point = 0; point < width * height; ++point) {
    const float numbers[] = {2.0f,
                             0.5f * static_cast<float>(point % width),
                             0.5f * static_cast<float>(point / width),
                             static_cast<float>(point)};
    const auto* const bytes = reinterpret_cast<const std::uint8_t*>(numbers);
    message.bytes.insert(message.bytes.end(), bytes, bytes + sizeof(numbers));
  }
  return message;
}

using Change = std::function<void(PointCloudMessage&)>;

McapMessage
messageOf(std::size_t i, const Change& change = {})
{
  PointCloudMessage cloud = wall(i);
  if (change)
    change(cloud);
  McapMessage message;
  message.log_time = message.publish_time = Time(5'000'000'000 + 100'000'000 * i);
  recording::writePointCloud(cloud, false, message.bytes);
  return message;
}

void
writeWalls(const std::string& path, const Change& change = {})
{
  writeMcap(path,
            {recording::pointCloudChannel("/points")},
            {messageOf(0, change), messageOf(1, change)});
}

} // namespace

/** \brief Bags of two walls, kept point by point. */
class ProgramForeignBags : public ProgramTest {
protected:
  /** \brief Encodes a bag, and decodes it.
   * \return what encode said
   */
  std::string
  expectWalls(const std::string& bag,
              const std::string& options = "",
              std::size_t walls = 2)
  {
    const ProgramRun encoded = run("encode '" + bag +
                                   "' -o small.mcap --overwrite --keep-points "
                                   "--keep-order -r 0.01 " +
                                   options);
    EXPECT_EQ(encoded.status, 0) << encoded.errors;
    EXPECT_EQ(run("decode small.mcap -o again.mcap --overwrite").status, 0);
    clouds = cloudsOf(folder / "again.mcap");
    EXPECT_EQ(clouds.size(), walls);
    for (const PointCloudMessage& cloud : clouds)
      expectWall(cloud);
    return encoded.errors;
  }

  /** \brief Expects the coordinates of wall(), to half an edge of 0.01 m. */
  static void
  expectWall(const PointCloudMessage& cloud)
  {
    ASSERT_EQ(std::size_t{cloud.width} * cloud.height, width * height);
    const PointCloudMessage expected = wall(0);
    for (std::size_t point = 0; point < width * height; ++point)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        float number = 0.0f;
        float wanted = 0.0f;
        std::memcpy(&number,
                    &cloud.bytes[point * cloud.point_step + cloud.fields[axis].offset],
                    4);
        std::memcpy(&wanted, &expected.bytes[16 * point + 4 * axis], 4);
        ASSERT_NEAR(number, wanted, 0.00501) << "point " << point << ", " << axis;
      }
  }

  static std::uint32_t
  colourOf(const PointCloudMessage& cloud, std::size_t point)
  {
    EXPECT_EQ(cloud.fields.back().name, "rgb");
    std::uint32_t colour = 0;
    std::memcpy(&colour,
                &cloud.bytes[point * cloud.point_step + cloud.fields.back().offset],
                sizeof(colour));
    return colour & 0xffffff;
  }

  std::vector<PointCloudMessage> clouds; // decoded
};

TEST_F(ProgramForeignBags, DoNotChangeWithoutARemark)
{
  const auto row_step = [](std::uint32_t step) -> Change {
    return [step](PointCloudMessage& cloud) { cloud.row_step = step; };
  };
  const auto coloured = [](const char* name, std::uint8_t alpha) -> Change {
    return [=](PointCloudMessage& cloud) {
      cloud.fields.back() = {name, 12, pcl::PCLPointField::UINT32, 1};
      for (std::size_t point = 0; point < width * height; ++point)
        cloud.bytes[16 * point + 15] = point == 9 ? alpha : 0xff;
    };
  };
  struct Row {
    const char* remark;
    Change change;
    bool is_said = true;
  };
  const Row rows[] = {
      {"row_step does not fit the rows", row_step(0)},
      {"row_step does not fit the rows", row_step(16 * 640)}, // of another image
      {"row_step does not fit", // with more bytes behind one row
       [](PointCloudMessage& cloud) {
         cloud.width *= cloud.height;
         cloud.height = 1;
         cloud.row_step = 0;
         cloud.bytes.push_back(0);
       }},
      {"fields that are left out: another x",
       [](PointCloudMessage& cloud) {
         cloud.fields.push_back({"x", 12, 7, 1});
       }},
      {"fields that are left out: those without a name",
       [](PointCloudMessage& cloud) {
         for (int i = 0; i < 5; ++i)
           cloud.fields.insert(cloud.fields.begin(), {"", 0, 0, 0});
       }},
      {"fields that are left out: intensity",
       [](PointCloudMessage& cloud) { cloud.fields[3].offset = 16; }},
      {"fields that are left out: intensity",
       [](PointCloudMessage& cloud) { cloud.fields[3].datatype = 77; }},
      {"fields that are left out: rgb",
       [](PointCloudMessage& cloud) {
         cloud.fields.push_back({"rgb", 12, 2, 1});
       }},
      {"fields that are left out: rgb",
       [](PointCloudMessage& cloud) {
         cloud.fields.push_back({"rgb", 4000, 7, 1});
       }},
      {"fields that are left out: the alpha of rgba", coloured("rgba", 0x80)},
      {"the alpha of rgb", coloured("rgba", 0xff), false},
      {"the alpha of rgb", coloured("rgb", 0x80), false},
      {"the bytes of its numbers are in the other order",
       [](PointCloudMessage& cloud) {
         cloud.is_bigendian = true;
         for (std::size_t i = 0; i < cloud.bytes.size(); i += 4)
           std::reverse(&cloud.bytes[i], &cloud.bytes[i] + 4);
       }},
      {"its fields X, Y, Z are taken as x, y, z",
       [](PointCloudMessage& cloud) {
         for (std::size_t axis = 0; axis < 3; ++axis)
           cloud.fields[axis].name = "XYZ"[axis];
       }},
      {"the one column of points is kept as one row",
       [](PointCloudMessage& cloud) {
         cloud.height *= cloud.width;
         cloud.width = 1;
         cloud.row_step = 16;
       }},
      {"the bytes behind the last row are not used",
       [](PointCloudMessage& cloud) { cloud.bytes.resize(cloud.bytes.size() + 16); }},
      {"the order of the points takes none of the ", [](PointCloudMessage&) {}}};
  std::size_t jobs = 0; // 1 and 2 in turns, as threads read layouts, too
  for (const Row& row : rows) {
    writeWalls(folder / "bag.mcap", row.change);
    const std::string said =
        expectWalls("bag.mcap", "--jobs " + std::to_string(1 + jobs++ % 2));
    const std::size_t at = said.find(row.remark);
    EXPECT_EQ(at != std::string::npos, row.is_said) << row.remark << said;
    if (row.is_said) {
      EXPECT_TRUE(hasPart(said, std::string("/points: ") + row.remark));
      EXPECT_EQ(said.find(row.remark, at + 1), std::string::npos) << said; // once
    }
  }
  writeWalls(folder / "bag.mcap",
             [](PointCloudMessage& cloud) { cloud.fields[2].offset = 16; });
  expectRemark("encode bag.mcap -o x.mcap", "'z' ends at byte 20 of a point of 16", 1);
  // Where another row_step is no explanation.
  writeWalls(folder / "bag.mcap", [](PointCloudMessage& cloud) {
    cloud.row_step = 0;
    cloud.bytes.push_back(0);
  });
  expectRemark("encode bag.mcap -o x.mcap", "invalid layout", 1);
}

TEST_F(ProgramForeignBags, MayHaveColoursAsChannelsWhichAreFieldsWhereTheyAreKept)
{
  writeWalls(folder / "bag.mcap", [](PointCloudMessage& cloud) {
    cloud.fields[3] = {"b", 12, 2, 1};
    cloud.fields.push_back({"g", 13, 2, 1});
    cloud.fields.push_back({"r", 14, 2, 1});
    for (std::size_t point = 0; point < width * height; ++point) {
      cloud.bytes[16 * point + 12] = static_cast<std::uint8_t>(point);
      cloud.bytes[16 * point + 13] = 0x80;
      cloud.bytes[16 * point + 14] = 0x10;
    }
  });
  EXPECT_TRUE(hasPart(expectWalls("bag.mcap", "--colour-bits 8"),
                      "/points: its fields r, g, b (uint8) are taken as its colour"));
  ASSERT_EQ(clouds.size(), 2u);
  for (std::size_t point = 0; point < width * height; ++point)
    EXPECT_EQ(colourOf(clouds[0], point), 0x108000u + point);
  for (const char* const fields : {"all", "r,g,b"}) {
    expectWalls("bag.mcap", std::string("--fields ") + fields);
    ASSERT_EQ(clouds.size(), 2u);
    EXPECT_EQ(clouds[0].fields.size(), 6u);
    EXPECT_EQ(clouds[0].point_step, 16u);
    EXPECT_EQ(clouds[0].bytes[16 * 5 + 12], 5);
    EXPECT_EQ(clouds[0].bytes[16 * 5 + 14], 0x10);
  }
}

TEST_F(ProgramForeignBags, MayLackIntensitiesInSomeMessages)
{
  const Change drop = [](PointCloudMessage& cloud) {
    cloud.fields.pop_back();
    // Rows with gaps.
    std::vector<std::uint8_t> bytes;
    for (std::size_t row = 0; row < height; ++row) {
      const auto begin =
          cloud.bytes.begin() + static_cast<std::ptrdiff_t>(row * cloud.row_step);
      bytes.insert(bytes.end(), begin, begin + cloud.row_step);
      bytes.resize(bytes.size() + 8);
    }
    cloud.row_step += 8;
    cloud.bytes = bytes;
  };
  writeMcap(folder / "bag.mcap",
            {recording::pointCloudChannel("/points")},
            {messageOf(0), messageOf(1, drop), messageOf(2)});
  EXPECT_TRUE(hasPart(expectWalls("bag.mcap", "", 3),
                      "/points, frame 1: its points get the intensity 0"));
}

TEST_F(ProgramForeignBags, HaveOneScaleOfColoursInAStream)
{
  // r, g and b as float32 in place of x, y and z, which follow.
  const auto coloured = [](float blue) -> Change {
    return [blue](PointCloudMessage& cloud) {
      std::vector<std::uint8_t> bytes;
      const float colour[] = {0.0f, 0.5f, blue};
      const auto* const first = reinterpret_cast<const std::uint8_t*>(colour);
      for (std::size_t i = 0; i < width * height; ++i) {
        const auto point = cloud.bytes.begin() + static_cast<std::ptrdiff_t>(16 * i);
        bytes.insert(bytes.end(), point, point + 16);
        bytes.insert(bytes.end(), first, first + sizeof(colour));
      }
      cloud.bytes = bytes;
      cloud.point_step = 28;
      cloud.row_step = 28 * width;
      cloud.fields.push_back({"r", 16, 7, 1});
      cloud.fields.push_back({"g", 20, 7, 1});
      cloud.fields.push_back({"b", 24, 7, 1});
    };
  };
  writeMcap(folder / "bag.mcap",
            {recording::pointCloudChannel("/points")},
            {messageOf(0, coloured(1.0f)), messageOf(1, coloured(1.5f))});
  for (const char* const jobs : {"1", "4"}) {
    const std::string said =
        expectWalls("bag.mcap", std::string("--colour-bits 8 --jobs ") + jobs);
    EXPECT_TRUE(hasPart(said,
                        "/points, frame 1: its fields r, g, b have larger values than "
                        "the first colours of the stream"));
    for (const PointCloudMessage& cloud : clouds)
      EXPECT_EQ(colourOf(cloud, 0), 0x0080ffu);
  }
}

TEST_F(ProgramForeignBags, KeepEmptyFrameIdsAndStampsOf0AndBefore1970)
{
  const std::vector<Time> stamps = {Time(0), Time(-1'500'000'000), Time(-1)};
  std::vector<McapMessage> messages;
  for (const Time stamp : stamps)
    messages.push_back(messageOf(messages.size(), [stamp](PointCloudMessage& cloud) {
      cloud.stamp = stamp;
      cloud.frame_id.clear();
    }));
  writeMcap(folder / "bag.mcap", {recording::pointCloudChannel("/points")}, messages);
  expectWalls("bag.mcap", "", 3);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    EXPECT_EQ(clouds[i].stamp, stamps.at(i));
    EXPECT_EQ(clouds[i].frame_id, "");
  }
}

TEST_F(ProgramForeignBags, MayBeOneFileInAFolder)
{
  for (const std::string name :
       {"x/rosbag2_2024_05_01-10_00_00_0.mcap", "y/some.mcap", "z/SOME.MCAP"}) {
    const std::string bag = fs::path(name).parent_path().string();
    fs::create_directories(folder / bag);
    writeWalls(folder / name);
    expectWalls(bag);
  }
  // Parts of a bag are one where the output takes one; else they may be bags.
  fs::create_directories(folder / "parts");
  for (std::size_t part = 0; part < 12; ++part)
    writeMcap((folder / "parts/run_") + std::to_string(part) + ".mcap",
              {recording::pointCloudChannel("/points")},
              {messageOf(part)});
  EXPECT_TRUE(
      hasPart(expectWalls("parts", "", 12),
              "'parts' has no metadata.yaml; its files are read as parts of one"));
  EXPECT_EQ(run("encode parts -o each").status, 0);
  EXPECT_TRUE(fs::exists(folder / "each/run_11.mcap"));
  fs::remove(folder / "parts/run_3.mcap");
  expectFailure("encode parts -o y.mcap", 2, "takes one bag");
  // A folder of recordings gets one of each bag in a folder, also of one.
  EXPECT_EQ(run("encode y -o made -r 0.05").status, 0);
  EXPECT_TRUE(fs::exists(folder / "made/some.mcap"));
}

TEST_F(ProgramForeignBags, WithCloudsOfOtherTypesAreNotWithoutClouds)
{
  McapChannel channel = recording::pointCloudChannel("/livox/lidar");
  channel.schema = {"livox_ros_driver2/msg/CustomMsg", "ros2msg", "uint64 timebase\n"};
  writeMcap(folder / "bag.mcap", {channel}, {messageOf(0)});
  expectFailure("encode bag.mcap -o y.mcap",
                1,
                "the clouds of /livox/lidar in 'bag.mcap' are "
                "livox_ros_driver2/msg/CustomMsg in the encoding 'cdr'");
  McapMessage livox = messageOf(1);
  livox.channel = 1;
  writeMcap(folder / "both.mcap",
            {recording::pointCloudChannel("/points"), channel},
            {messageOf(0), livox});
  EXPECT_TRUE(hasPart(expectWalls("both.mcap", "", 1),
                      "/livox/lidar: messages of the type "
                      "livox_ros_driver2/msg/CustomMsg are not encoded"));
  expectRemark("encode both.mcap -o x.pcxi",
               "left out: 1 message of other topics, and the log times");
  EXPECT_FALSE(hasPart(run("encode both.mcap -o y.pcxi --topics /points").errors,
                       "left out: 1 message"));
}

TEST_F(ProgramForeignBags, ThatHaveNoEndAreIncomplete)
{
  writeWalls(folder / "bag.mcap");
  const Bytes bytes = bytesOf(folder / "bag.mcap");
  // A footer record and the magic are the last ones.
  writeBytes(folder / "bag.mcap", {bytes.begin(), bytes.end() - 37});
  expectFailure(
      "encode bag.mcap -q -o x.mcap",
      1,
      "the recorder of 'bag.mcap' did not complete it; all that is in it was read");
  EXPECT_EQ(decode(folder / "x.mcap").at(0).frames.size(), 2u);
  // Recordings survive it, which is said.
  const Bytes recording = bytesOf(folder / "x.mcap");
  writeBytes(folder / "x.mcap", {recording.begin(), recording.end() - 37});
  for (const std::string command : {"decode", "cut", "merge"}) {
    const ProgramRun result = run(command + " x.mcap -o z.mcap --overwrite");
    EXPECT_EQ(result.status, 0);
    EXPECT_TRUE(hasPart(result.errors, "x.mcap was not finished")) << command;
  }
  // A part is complete, and metadata.yaml counts more.
  fs::create_directories(folder / "bag");
  writeBytes(folder / "bag/bag_0.mcap", bytes);
  writeText(folder / "bag/metadata.yaml",
            "rosbag2_bagfile_information:\n  message_count: 99\n");
  expectFailure(
      "encode bag -q -o y.mcap", 1, "metadata.yaml: it counts 99 messages, and ");
}

#ifdef PCL_EXT_HAS_SQLITE
using recording::test::DatabaseBag;

TEST_F(ProgramForeignBags, OfTheStorageSqlite3BecomeMcap)
{
  fs::create_directories(folder / "bag");
  for (std::size_t part = 0; part < 3; ++part) {
    DatabaseBag bag(folder / ("bag/bag_" + std::to_string(part) + ".db3"));
    bag.addTopic(1, "/points", "sensor_msgs/msg/PointCloud2", "");
    bag.addTopic(2, "/imu", "sensor_msgs/msg/Imu", "");
    bag.addMessage(1, messageOf(part).log_time.count(), messageOf(part).bytes);
    bag.addMessage(2, messageOf(part).log_time.count() + 1, Bytes(20 + part, 7));
  }
  EXPECT_TRUE(hasPart(expectWalls("bag", "", 3),
                      "'bag' has the storage sqlite3; bags are written as MCAP"));
  for (std::size_t i = 0; i < clouds.size(); ++i)
    EXPECT_EQ(clouds[i].stamp, wall(i).stamp);
  // In a folder of bags each is one, also one that is compressed.
  fs::create_directories(folder / "bags");
  fs::copy_file(folder / "bag/bag_0.db3", folder / "bags/a.db3");
  writeBytes(folder / "bags/b.db3.zstd",
             recording::test::compressed(bytesOf(folder / "bag/bag_0.db3")));
  EXPECT_EQ(run("encode bags -o made").status, 0);
  EXPECT_TRUE(fs::exists(folder / "made/a.mcap"));
  EXPECT_TRUE(fs::exists(folder / "made/b.mcap"));
  expectWalls("bags/b.db3.zstd", "", 1);
  EXPECT_EQ(runShell("cat bags/a.db3 | $P encode - -o piped.mcap").status, 0);
  // Its copy needs a place.
  const ProgramRun placeless =
      runShell("TMPDIR=nowhere $P encode bags/b.db3.zstd -o x");
  EXPECT_EQ(placeless.status, 1);
  EXPECT_TRUE(hasPart(placeless.errors, "name a folder for it in TMPDIR"));
  // What is lost of a database has no place in the file.
  {
    DatabaseBag bag(folder / "lost.db3");
    bag.addTopic(1, "/points", "sensor_msgs/msg/PointCloud2", "");
    bag.addMessage(1, 5, messageOf(0).bytes);
    bag.addMessage(7, 6, messageOf(0).bytes);
  }
  expectRemark("encode lost.db3 -o lost.mcap",
               "encode: lost.db3: 1 messages are of no topic\n",
               1);
}
#endif

} // namespace pcl_ext::tools::test
