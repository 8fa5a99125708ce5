// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/point_cloud_messages.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

using Bytes = std::vector<std::uint8_t>;

PointCloudMessage
smallCloud()
{
  PointCloudMessage cloud;
  cloud.stamp = std::chrono::seconds(258) + Time(3);
  cloud.frame_id = "map";
  cloud.height = 1;
  cloud.width = 2;
  cloud.fields = {{"x", 0, 7, 1}};
  cloud.point_step = 4;
  cloud.row_step = 8;
  cloud.bytes = {1, 2, 3, 4, 5, 6, 7, 8};
  cloud.is_dense = true;
  return cloud;
}

/** \brief The bytes of the small cloud, written by hand from the rules of CDR.
 * \param[in] is_big_endian order of the bytes of numbers
 * \param[in] is_delimited structures and sequences of them have their sizes before them
 */
Bytes
smallCloudInCdr(bool is_big_endian, bool is_delimited = false)
{
  Bytes bytes = {
      0, std::uint8_t((is_delimited ? 8 : 0) + (is_big_endian ? 0 : 1)), 0, 0};
  const auto number = [&](std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
      bytes.push_back(
          static_cast<std::uint8_t>(value >> 8 * (is_big_endian ? 3 - i : i)));
  };
  const auto raw = [&](const Bytes& values) {
    bytes.insert(bytes.end(), values.begin(), values.end());
  };
  const auto begin = [&](std::uint32_t size) {
    if (is_delimited)
      number(size);
  };
  begin(89);   // the message
  begin(20);   // header
  begin(8);    // stamp
  number(258); // seconds
  number(3);   // nanoseconds
  number(4);   // frame_id with its 0
  raw({'m', 'a', 'p', 0});
  number(1); // height
  number(2); // width
  begin(28); // fields
  number(1);
  begin(20); // a field
  number(2);
  raw({'x', 0, 0, 0}); // and two bytes of alignment
  number(0);           // offset
  raw({7, 0, 0, 0});   // datatype, and three bytes of alignment
  number(1);           // count
  raw({0, 0, 0, 0});   // is_bigendian, and three bytes of alignment
  number(4);           // point_step
  number(8);           // row_step
  number(8);           // bytes
  raw({1, 2, 3, 4, 5, 6, 7, 8});
  raw({1}); // is_dense
  return bytes;
}

} // namespace

TEST(PointCloudMessages, HaveATypeOfSeveralNames)
{
  for (const char* name : {"sensor_msgs/msg/PointCloud2",
                           "sensor_msgs/PointCloud2",
                           "sensor_msgs::msg::dds_::PointCloud2_"}) {
    McapChannel channel = pointCloudChannel("/points");
    channel.schema.name = name;
    EXPECT_TRUE(isPointCloud(channel)) << name;
  }
}

TEST(PointCloudMessages, AreWrittenInCdr)
{
  Bytes bytes = {9, 9};
  writePointCloud(smallCloud(), false, bytes);
  EXPECT_EQ(bytes, smallCloudInCdr(false));
}

TEST(PointCloudMessages, AreReadInBothByteOrdersAndAllVersionsOfCdr)
{
  for (const bool is_big_endian : {false, true})
    for (const auto& [is_delimited, version] :
         {std::pair(false, 0), {false, 6}, {true, 0}}) {
      Bytes bytes = smallCloudInCdr(is_big_endian, is_delimited);
      bytes[1] = static_cast<std::uint8_t>(bytes[1] + version);
      PointCloudMessage cloud;
      const RecordingStatus status =
          readPointCloud(bytes.data(), bytes.size(), false, cloud);
      ASSERT_TRUE(status.ok()) << status;
      Bytes again;
      writePointCloud(cloud, false, again);
      EXPECT_EQ(again, smallCloudInCdr(false));
      for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_EQ(readPointCloud(bytes.data(), size, false, cloud).code(),
                  RecordingCode::Damaged)
            << size;
        EXPECT_TRUE(cloud.bytes.empty());
      }
    }
}

TEST(PointCloudMessages, OfOtherEncodingsAreRefused)
{
  const Bytes bytes = smallCloudInCdr(false);
  PointCloudMessage cloud;
  for (const int encoding : {2, 3, 5, 10, 11, 255}) {
    Bytes other = bytes;
    other[1] = static_cast<std::uint8_t>(encoding);
    EXPECT_FALSE(readPointCloud(other.data(), other.size(), false, cloud).ok());
  }
  EXPECT_FALSE(readPointCloud(bytes.data(), bytes.size(), true, cloud).ok());
}

TEST(PointCloudMessages, CountsBeyondTheBytesTakeNoMemory)
{
  // The numbers of fields, of characters and of bytes are 2^32 - 1 in turn.
  for (const std::size_t place : {12u, 28u, 32u, 64u}) {
    Bytes bytes = smallCloudInCdr(false);
    for (std::size_t i = 0; i < 4; ++i)
      bytes[place + i] = 255;
    PointCloudMessage cloud;
    EXPECT_FALSE(readPointCloud(bytes.data(), bytes.size(), false, cloud).ok())
        << place;
    EXPECT_LT(cloud.fields.capacity(), 10u);
  }
}

TEST(PointCloudMessages, CompressedCloudsHaveAFormat)
{
  for (const std::size_t size : {0u, 1u, 2u, 3u, 4u, 1000u}) {
    PointCloudMessage cloud = smallCloud();
    cloud.bytes.assign(size, 7);
    cloud.format = "pcl_ext";
    Bytes bytes;
    writePointCloud(cloud, true, bytes);
    PointCloudMessage read;
    ASSERT_TRUE(readPointCloud(bytes.data(), bytes.size(), true, read).ok());
    EXPECT_EQ(read.format, "pcl_ext");
    EXPECT_EQ(read.bytes, cloud.bytes);
  }
}

TEST(PointCloudMessages, StampsBefore1970AreKeptAndThoseOutOfRangeAre0)
{
  const Time first = std::chrono::seconds(-(std::int64_t{1} << 31));
  const Time behind_last = std::chrono::seconds(std::int64_t{1} << 32);
  for (const auto& [stamp, kept] : {std::pair(Time(0), Time(0)),
                                    {Time(-1), Time(-1)},
                                    {Time(-1'000'000'000), Time(-1'000'000'000)},
                                    {Time(-1'500'000'000), Time(-1'500'000'000)},
                                    {first, first},
                                    {first - Time(1), Time(0)},
                                    {behind_last, Time(0)}}) {
    PointCloudMessage cloud = smallCloud();
    cloud.stamp = stamp;
    Bytes bytes;
    writePointCloud(cloud, false, bytes);
    // sec and nanosec of builtin_interfaces/Time, after four bytes of the encapsulation
    EXPECT_LT(bytes[8] | bytes[9] << 8 | bytes[10] << 16 | bytes[11] << 24,
              1'000'000'000);
    ASSERT_TRUE(readPointCloud(bytes.data(), bytes.size(), false, cloud).ok());
    EXPECT_EQ(cloud.stamp, kept);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test
