// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/nodes/impl/message_layouts.h>

#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <tuple>
#include <vector>

namespace {

using namespace pcl_ext::nodes;
using pcl_ext::io::isLayout;
using pcl_ext::io::MessageLayout;
using Field = pcl::PCLPointField;
using Place = std::tuple<std::string, std::uint32_t, std::uint8_t, std::uint32_t>;

pcl::PCLPointCloud2
cloudOf(const std::vector<Place>& fields, std::uint32_t point_step, std::uint32_t width)
{
  pcl::PCLPointCloud2 cloud;
  for (const Place& place : fields) {
    Field& field = cloud.fields.emplace_back();
    std::tie(field.name, field.offset, field.datatype, field.count) = place;
  }
  cloud.point_step = point_step;
  cloud.width = width;
  cloud.height = 1;
  cloud.row_step = point_step * width;
  cloud.data.resize(cloud.row_step);
  return cloud;
}

std::vector<Place>
placesOf(const pcl::PCLPointCloud2& cloud)
{
  std::vector<Place> places;
  for (const Field& field : cloud.fields)
    places.emplace_back(field.name, field.offset, field.datatype, field.count);
  return places;
}

std::vector<Place>
placesOf(const MessageLayout& layout)
{
  std::vector<Place> places;
  for (const auto& field : layout.fields)
    places.emplace_back(
        field.name, field.offset, static_cast<std::uint8_t>(field.type), field.count);
  return places;
}

const std::vector<Place> xyz = {{"x", 0, Field::FLOAT32, 1},
                                {"y", 4, Field::FLOAT32, 1},
                                {"z", 8, Field::FLOAT32, 1}};

TEST(MessageLayouts, OfAColourAndOfAnAdditionalField)
{
  std::vector<Place> places = xyz;
  places.emplace_back("rgba", 16, Field::UINT32, 1);
  const MessageLayout layout = messageLayoutOf(cloudOf(places, 20, 1));
  std::vector<Place> packed = xyz;
  packed.emplace_back("intensity", 12, Field::FLOAT32, 1);
  packed.emplace_back("rgb", 16, Field::FLOAT32, 1);
  pcl::PCLPointCloud2 cloud = cloudOf(packed, 20, 1);
  for (std::uint8_t i = 0; i < 20; ++i)
    cloud.data[i] = i;
  EXPECT_EQ(arrange(layout, cloud), "");
  places.emplace_back("intensity", 20, Field::FLOAT32, 1);
  EXPECT_EQ(placesOf(cloud), places);
  const std::vector<std::uint8_t> expected = {
      0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 0, 0, 0, 16, 17, 18, 19, 12, 13, 14, 15};
  EXPECT_EQ(cloud.data, expected);
}

TEST(MessageLayouts, ThatTakeTooMuchMemoryAreNotMade)
{
  MessageLayout layout = messageLayoutOf(cloudOf({xyz[0]}, 4096, 1));
  pcl::PCLPointCloud2 cloud = cloudOf({xyz[0]}, 4, 1u << 14); // 64 MiB
  pcl::PCLPointCloud2 larger = cloudOf({xyz[0]}, 4, (1u << 14) + 1);
  EXPECT_EQ(arrange(layout, cloud), "");
  EXPECT_EQ(cloud.data.size(), std::size_t{64} << 20);
  EXPECT_EQ(arrange(layout, larger), "it would take 64 MiB");
  EXPECT_EQ(larger.point_step, 4u);
}

TEST(MessageLayouts, PaddingIsThatOfRows)
{
  // As some programs have it: a count of 0; a row_step of a single row.
  pcl::PCLPointCloud2 cloud = cloudOf({{"x", 0, Field::FLOAT32, 0}}, 16, 10);
  cloud.row_step = 1000;
  EXPECT_EQ(messageLayoutOf(cloud).row_padding, 0u);
  EXPECT_EQ(placesOf(messageLayoutOf(cloud)), std::vector<Place>{xyz[0]});
  cloud.height = 2;
  cloud.data.resize(320); // without gaps, whatever row_step says
  EXPECT_EQ(messageLayoutOf(cloud).row_padding, 0u);
  cloud.data.resize(2000);
  const MessageLayout layout = messageLayoutOf(cloud);
  EXPECT_EQ(layout.row_padding, 840u);
  for (const std::uint32_t height : {1u, 3u}) {
    pcl::PCLPointCloud2 decoded = cloudOf({xyz[0]}, 4, 2);
    decoded.height = height;
    decoded.data.assign(8 * height, 7);
    EXPECT_EQ(arrange(layout, decoded), "");
    EXPECT_EQ(decoded.row_step, height == 1 ? 32u : 872u);
    ASSERT_EQ(decoded.data.size(), std::size_t{height} * decoded.row_step);
    for (std::size_t i = 0; i < decoded.data.size(); ++i)
      EXPECT_EQ(decoded.data[i],
                i % decoded.row_step < 32 && i % decoded.row_step % 16 < 4 ? 7 : 0);
  }
}

TEST(MessageLayouts, NumbersOutsideOfATypeAreLimited)
{
  const MessageLayout layout =
      messageLayoutOf(cloudOf({{"a", 0, Field::UINT8, 3}}, 4, 1));
  pcl::PCLPointCloud2 cloud = cloudOf({{"a", 0, Field::FLOAT32, 3}}, 12, 1);
  const float numbers[3] = {-5.0f, 300.0f, std::nanf("")};
  std::memcpy(cloud.data.data(), numbers, 12);
  std::size_t limited = 0;
  EXPECT_EQ(arrange(layout, cloud, &limited), "");
  EXPECT_EQ(cloud.data, (std::vector<std::uint8_t>{0, 255, 0, 0}));
  EXPECT_EQ(limited, 2u); // as NaN is no number
  // The largest whole number, which floats have not.
  const MessageLayout whole =
      messageLayoutOf(cloudOf({{"a", 0, Field::INT32, 1}}, 4, 1));
  pcl::PCLPointCloud2 largest = cloudOf({{"a", 0, Field::FLOAT32, 1}}, 4, 1);
  const float number = 2147483648.0f;
  std::memcpy(largest.data.data(), &number, 4);
  EXPECT_EQ(arrange(whole, largest, &limited), "");
  EXPECT_EQ(largest.data, (std::vector<std::uint8_t>{255, 255, 255, 127}));
  EXPECT_EQ(limited, 0u);
}

TEST(MessageLayouts, CoordinatesBecomeRealAndAreNotNarrowed)
{
  MessageLayout layout = messageLayoutOf(cloudOf({{"x", 0, Field::INT16, 1},
                                                  {"y", 2, Field::INT16, 1},
                                                  {"z", 4, Field::UINT8, 1},
                                                  {"ring", 5, Field::UINT8, 1},
                                                  {"long", 0, 10, 1},
                                                  {"_", 0, Field::UINT8, 1},
                                                  {"beyond", 6, Field::UINT16, 1}},
                                                 7,
                                                 1));
  EXPECT_EQ(layout.point_step, 19u);
  EXPECT_EQ(placesOf(layout),
            (std::vector<Place>{{"x", 7, Field::FLOAT32, 1},
                                {"y", 11, Field::FLOAT32, 1},
                                {"z", 15, Field::FLOAT32, 1},
                                {"ring", 5, Field::UINT8, 1}}));
  pcl::PCLPointCloud2 cloud = cloudOf({{"x", 0, Field::FLOAT64, 1}}, 8, 1);
  EXPECT_EQ(arrange(layout, cloud), "coordinates need FLOAT64 now");
  EXPECT_EQ(cloud.point_step, 8u);
}

TEST(MessageLayouts, ThatAreNoneAreNotTaken)
{
  const MessageLayout good = messageLayoutOf(cloudOf(xyz, 12, 1));
  ASSERT_TRUE(isLayout(good));
  EXPECT_FALSE(isLayout(MessageLayout()));
  MessageLayout layout = good;
  layout.point_step = 11;
  EXPECT_FALSE(isLayout(layout));
  layout = good;
  layout.fields.resize(146, good.fields[0]); // 7 bytes each
  layout.fields.pop_back();
  EXPECT_TRUE(isLayout(layout));
  layout.fields.push_back(good.fields[0]);
  EXPECT_FALSE(isLayout(layout));
}

} // namespace
