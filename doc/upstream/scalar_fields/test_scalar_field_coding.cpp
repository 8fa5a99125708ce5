/*
 * SPDX-License-Identifier: BSD-3-Clause
 *
 *  Point Cloud Library (PCL) - www.pointclouds.org
 *  Copyright (c) 2014-, Open Perception Inc.
 *
 *  All rights reserved
 */

#include <pcl/compression/compression_profiles.h>
#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/console/print.h>
#include <pcl/test/gtest.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

const std::string header_identifier = "<PCL-OCT-COMPRESSED>";
const float nan_value = std::numeric_limits<float>::quiet_NaN();
const float infinity = std::numeric_limits<float>::infinity();

template <typename PointT>
using Compression = pcl::io::OctreePointCloudCompression<PointT>;

template <typename PointT>
using Cloud = pcl::PointCloud<PointT>;

using Voxel = std::array<int, 3>;

template <typename PointT>
Compression<PointT>
makeEncoder(bool voxel_grid, double resolution = 0.25)
{
  return {pcl::io::MANUAL_CONFIGURATION,
          false,
          voxel_grid ? resolution : resolution / 4,
          resolution,
          voxel_grid};
}

template <typename PointT>
std::string
encode(Compression<PointT>& encoder, const Cloud<PointT>& cloud)
{
  std::ostringstream stream;
  encoder.encodePointCloud(cloud.makeShared(), stream);
  return stream.str();
}

template <typename PointT>
Cloud<PointT>
decode(Compression<PointT>& decoder, const std::string& bytes)
{
  std::istringstream stream(bytes);
  typename Cloud<PointT>::Ptr cloud(new Cloud<PointT>);
  decoder.decodePointCloud(stream, cloud);
  return *cloud;
}

/** A cloud and what is in it, without the help of an octree: the octree puts its grid
 * on the first point, which therefore stands alone, and each other point is well inside
 * of its voxel. */
struct GridCloud {
  Cloud<pcl::PointXYZI> points;
  std::map<Voxel, std::vector<float>> intensities;
  float lowest;
  float highest;
};

GridCloud
makeGridCloud(float resolution, std::mt19937& random)
{
  GridCloud cloud;
  std::uniform_int_distribution<int> index(2, 13), count(1, 4);
  std::uniform_real_distribution<float> offset(0.2f, 0.8f), intensity(-50.0f, 3000.0f);
  cloud.points.push_back({0.0f, 0.0f, 0.0f, 7.0f});
  cloud.lowest = cloud.highest = 7.0f;
  for (int i = 0; i < 300; ++i) {
    const Voxel voxel{index(random), index(random), index(random)};
    for (int j = count(random); j > 0; --j) {
      const float value = intensity(random);
      cloud.points.push_back(
          {(static_cast<float>(voxel[0]) + offset(random)) * resolution,
           (static_cast<float>(voxel[1]) + offset(random)) * resolution,
           (static_cast<float>(voxel[2]) + offset(random)) * resolution,
           value});
      cloud.intensities[voxel].push_back(value);
      cloud.lowest = std::min(cloud.lowest, value);
      cloud.highest = std::max(cloud.highest, value);
    }
  }
  return cloud;
}

std::map<Voxel, std::vector<float>>
intensitiesOfVoxels(const Cloud<pcl::PointXYZI>& cloud, float resolution)
{
  std::map<Voxel, std::vector<float>> intensities;
  for (const auto& point : cloud) {
    const Voxel voxel{static_cast<int>(std::floor(point.x / resolution)),
                      static_cast<int>(std::floor(point.y / resolution)),
                      static_cast<int>(std::floor(point.z / resolution))};
    if (voxel[0] > 0) // not the first point
      intensities[voxel].push_back(point.intensity);
  }
  return intensities;
}

void
expectIntensities(const GridCloud& cloud,
                  const Cloud<pcl::PointXYZI>& decoded,
                  float resolution,
                  bool voxel_grid,
                  int bit_depth)
{
  const float steps = static_cast<float>((1 << bit_depth) - 1);
  const float tolerance = 0.5001f * (cloud.highest - cloud.lowest) / steps + 1e-3f;
  auto voxels = intensitiesOfVoxels(decoded, resolution);
  ASSERT_EQ(voxels.size(), cloud.intensities.size());
  for (auto [voxel, expected] : cloud.intensities) {
    std::vector<float>& intensities = voxels[voxel];
    if (voxel_grid)
      expected = {std::accumulate(expected.begin(), expected.end(), 0.0f) /
                  static_cast<float>(expected.size())};
    std::sort(expected.begin(), expected.end());
    std::sort(intensities.begin(), intensities.end());
    ASSERT_EQ(intensities.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_NEAR(intensities[i], expected[i], tolerance);
  }
}

bool
isIntraFrame(const std::string& bytes)
{
  const std::size_t frame_id = bytes.find(header_identifier) + header_identifier.size();
  return bytes[frame_id + sizeof(std::uint32_t)] != 0;
}

/** Points in a row of voxels of 0.25, with the given intensities. */
Cloud<pcl::PointXYZI>
makeRow(const std::vector<float>& intensities, std::size_t points_per_voxel)
{
  Cloud<pcl::PointXYZI> cloud;
  for (std::size_t i = 0; i < intensities.size(); ++i) {
    const auto voxel = static_cast<float>(i / points_per_voxel);
    cloud.push_back({0.25f * voxel + 0.125f, 0.125f, 0.125f, intensities[i]});
  }
  return cloud;
}

std::vector<float>
roundTripOfRow(const std::vector<float>& intensities,
               bool voxel_grid,
               std::size_t points_per_voxel,
               unsigned char bit_depth = 16)
{
  auto encoder = makeEncoder<pcl::PointXYZI>(voxel_grid);
  encoder.setScalarFields({"intensity"}, bit_depth);
  Compression<pcl::PointXYZI> decoder;
  const auto cloud =
      decode(decoder, encode(encoder, makeRow(intensities, points_per_voxel)));
  std::vector<std::pair<float, float>> by_position;
  for (const auto& point : cloud)
    by_position.emplace_back(point.x, point.intensity);
  std::stable_sort(by_position.begin(),
                   by_position.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<float> decoded(by_position.size());
  std::transform(by_position.begin(),
                 by_position.end(),
                 decoded.begin(),
                 [](const auto& point) { return point.second; });
  return decoded;
}

/** The coded fields of a frame, with their identifier and size. */
std::string
fieldsOf(const std::string& bytes)
{
  return bytes.substr(0, bytes.find(header_identifier));
}

/** A frame without its fields. */
std::string
frameOf(const std::string& bytes)
{
  return bytes.substr(bytes.find(header_identifier));
}

template <typename T>
std::string
asBytes(const T& value)
{
  return {reinterpret_cast<const char*>(&value), sizeof(value)};
}

/** Coded fields of the given content. */
std::string
makeFields(const std::string& content)
{
  return "<PCL-OCT-SCALAR-FIELDS>" +
         asBytes(static_cast<std::uint32_t>(content.size())) + content;
}

/** The start of a content: the field intensity up to the count of its averages. */
std::string
startOfContent(std::uint32_t steps)
{
  const std::string name = "intensity";
  return asBytes(std::uint32_t{1}) + asBytes(static_cast<std::uint32_t>(name.size())) +
         name + asBytes(1.0) + asBytes(2.0) + asBytes(steps);
}

using Table = std::array<std::uint32_t, 257>;

/** A table of frequencies, added up, in which all bytes are equally frequent. */
Table
makeFrequencies()
{
  Table table;
  std::iota(table.begin(), table.end(), 0u);
  return table;
}

/** Decodes damaged fields together with a whole frame of 4 points in 2 voxels. */
void
expectNoIntensities(const std::string& fields)
{
  for (const bool voxel_grid : {false, true}) {
    auto encoder = makeEncoder<pcl::PointXYZI>(voxel_grid);
    const auto bytes = encode(encoder, makeRow({1.0f, 2.0f, 3.0f, 4.5f}, 2));
    Compression<pcl::PointXYZI> decoder;
    const auto decoded = decode(decoder, fields + frameOf(bytes));
    EXPECT_EQ(decoded.size(), voxel_grid ? 2u : 4u);
    for (const auto& point : decoded)
      EXPECT_EQ(point.intensity, 0.0f);
  }
}

std::uint64_t
fnv1a(const std::string& bytes)
{
  std::uint64_t hash = 14695981039346656037u;
  for (const char byte : bytes)
    hash = (hash ^ static_cast<std::uint8_t>(byte)) * 1099511628211u;
  return hash;
}

/** Hash of three frames. All coordinates and sizes are sums of few powers of 2, so that
 * each platform computes the same bytes. */
template <typename PointT>
std::uint64_t
hashOfStream(bool voxel_grid)
{
  auto encoder = makeEncoder<PointT>(voxel_grid);
  std::string bytes;
  for (unsigned frame = 0; frame < 3; ++frame) {
    Cloud<PointT> cloud;
    for (unsigned i = 0; i < 400; ++i) {
      const unsigned mixed = (i * 2654435761u) >> 8;
      PointT point;
      point.x = static_cast<float>(mixed % 64 + frame) / 32.0f;
      point.y = static_cast<float>(mixed / 64 % 64) / 32.0f;
      point.z = static_cast<float>(mixed / 4096 % 64) / 32.0f;
      if constexpr (pcl::traits::has_color<PointT>::value) {
        point.r = static_cast<std::uint8_t>(mixed);
        point.g = static_cast<std::uint8_t>(mixed >> 3);
        point.b = static_cast<std::uint8_t>(mixed >> 5);
      }
      cloud.push_back(point);
    }
    bytes += encode(encoder, cloud);
  }
  return fnv1a(bytes);
}

} // namespace

TEST(ScalarFieldCoding, IntensitiesInAllProfiles)
{
  std::mt19937 random(1);
  for (int i = 0; i < pcl::io::COMPRESSION_PROFILE_COUNT; ++i) {
    SCOPED_TRACE(i);
    const auto profile = static_cast<pcl::io::compression_Profiles_e>(i);
    const auto resolution =
        static_cast<float>(pcl::io::compressionProfiles_[i].octreeResolution);
    const bool voxel_grid = pcl::io::compressionProfiles_[i].doVoxelGridDownSampling;
    Compression<pcl::PointXYZI> encoder(profile), decoder;
    int intra_frames = 0;
    for (int frame = 0; frame < 5; ++frame) {
      const GridCloud cloud = makeGridCloud(resolution, random);
      const std::string bytes = encode(encoder, cloud.points);
      intra_frames += isIntraFrame(bytes);
      expectIntensities(cloud, decode(decoder, bytes), resolution, voxel_grid, 16);
    }
    EXPECT_GT(intra_frames, 0);
    EXPECT_LT(intra_frames, 5);
  }
}

TEST(ScalarFieldCoding, BitDepth)
{
  std::mt19937 random(2);
  std::size_t size_before = 0;
  for (const int bit_depth : {2, 8, 9, 16}) {
    SCOPED_TRACE(bit_depth);
    for (const bool voxel_grid : {false, true}) {
      auto encoder = makeEncoder<pcl::PointXYZI>(voxel_grid, 0.5);
      encoder.setScalarFields({"intensity"}, static_cast<unsigned char>(bit_depth));
      Compression<pcl::PointXYZI> decoder;
      const GridCloud cloud = makeGridCloud(0.5f, random);
      const std::string bytes = encode(encoder, cloud.points);
      expectIntensities(cloud, decode(decoder, bytes), 0.5f, voxel_grid, bit_depth);
      if (!voxel_grid) {
        EXPECT_GT(bytes.size(), size_before);
        size_before = bytes.size();
      }
    }
  }
}

TEST(ScalarFieldCoding, WholeNumbersAreExact)
{
  for (const auto& [lowest, highest, bit_depth] :
       std::vector<std::array<int, 3>>{{0, 255, 8},
                                       {0, 200, 8},
                                       {0, 254, 8},
                                       {-100, 100, 8},
                                       {5, 5, 8},
                                       {0, 3, 2},
                                       {0, 255, 16},
                                       {0, 254, 16},
                                       {-100, 100, 16},
                                       {16000000, 16000511, 9},
                                       {28005, 45830, 16},
                                       {0, 65535, 16}}) {
    SCOPED_TRACE(testing::Message() << lowest << " to " << highest);
    std::vector<float> intensities;
    for (int value = lowest; value < highest; value += (highest - lowest) / 300 + 1)
      intensities.push_back(static_cast<float>(value));
    while (intensities.size() % 4 != 0 || intensities.empty())
      intensities.push_back(static_cast<float>(highest));
    const auto bits = static_cast<unsigned char>(bit_depth);
    EXPECT_EQ(roundTripOfRow(intensities, true, 1, bits), intensities);
    EXPECT_EQ(roundTripOfRow(intensities, false, 4, bits), intensities);

    if (bit_depth == 16 && highest - lowest < 65535) { // one more level is needed
      intensities[1] = nan_value;
      auto decoded = roundTripOfRow(intensities, false, 4, bits);
      ASSERT_EQ(decoded.size(), intensities.size());
      EXPECT_TRUE(std::isnan(decoded[1]));
      decoded[1] = intensities[1] = 0.0f;
      EXPECT_EQ(decoded, intensities);
    }
  }
}

// The intensities of issue 6272.
TEST(ScalarFieldCoding, WholeNumbersOf16Bits)
{
  const std::vector<float> intensities{
      29512, 29206, 34296, 45830, 35847, 28070, 28005, 31260, 34471};
  EXPECT_EQ(roundTripOfRow(intensities, false, 1), intensities);
  EXPECT_EQ(roundTripOfRow(intensities, false, 3), intensities);
  EXPECT_EQ(roundTripOfRow(intensities, true, 1), intensities);
  const auto decoded = roundTripOfRow(intensities, true, 1, 8);
  ASSERT_EQ(decoded.size(), intensities.size());
  EXPECT_NE(decoded, intensities);
  for (std::size_t i = 0; i < intensities.size(); ++i)
    EXPECT_NEAR(decoded[i], intensities[i], 17825.0 / 255 / 2 + 0.01);
}

// The number of bits is the most that is used.
TEST(ScalarFieldCoding, SmallRangeNeedsOneByte)
{
  std::vector<float> intensities(256);
  std::iota(intensities.begin(), intensities.end(), 0.0f);
  auto of_8_bits = makeEncoder<pcl::PointXYZI>(false);
  auto of_16_bits = makeEncoder<pcl::PointXYZI>(false);
  of_8_bits.setScalarFields({"intensity"}, 8);
  const std::string bytes = encode(of_8_bits, makeRow(intensities, 4));
  EXPECT_EQ(encode(of_16_bits, makeRow(intensities, 4)), bytes);
  EXPECT_LT(fieldsOf(bytes).size(), 3u * 1028u); // each byte of a level has a table
}

TEST(ScalarFieldCoding, AveragesOfWholeNumbersAreRounded)
{
  EXPECT_EQ(roundTripOfRow({10.0f, 11.5f, 20.0f, 20.25f}, true, 2).size(), 2u);
  EXPECT_NEAR(roundTripOfRow({10.0f, 11.5f, 20.0f, 20.25f}, true, 2)[0], 10.75f, 1e-3f);
  EXPECT_EQ(roundTripOfRow({10.0f, 12.0f, 20.0f, 23.0f, 24.0f, 24.0f}, true, 2),
            (std::vector<float>{11.0f, 22.0f, 24.0f}));
}

TEST(ScalarFieldCoding, ConstantIntensities)
{
  const std::vector<float> intensities(6, 0.1f);
  EXPECT_EQ(roundTripOfRow(intensities, false, 2), intensities);
  EXPECT_EQ(roundTripOfRow(intensities, true, 2), std::vector<float>(3, 0.1f));
}

TEST(ScalarFieldCoding, ValuesThatAreNotFinite)
{
  const std::vector<float> intensities{
      10.0f, nan_value, 20.0f, infinity, -infinity, nan_value};
  const auto points = roundTripOfRow(intensities, false, 2);
  ASSERT_EQ(points.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    if (std::isfinite(intensities[i]))
      EXPECT_EQ(points[i], intensities[i]);
    else
      EXPECT_TRUE(std::isnan(points[i])) << points[i];
  }

  const auto voxels = roundTripOfRow(intensities, true, 2);
  ASSERT_EQ(voxels.size(), 3u);
  EXPECT_EQ(voxels[0], 10.0f);
  EXPECT_EQ(voxels[1], 20.0f);
  EXPECT_TRUE(std::isnan(voxels[2]));

  const auto none = roundTripOfRow({nan_value, infinity, -infinity}, false, 1);
  ASSERT_EQ(none.size(), 3u);
  EXPECT_TRUE(
      std::all_of(none.begin(), none.end(), [](float v) { return std::isnan(v); }));
}

// A point that is not in the octree has no part in the scale.
TEST(ScalarFieldCoding, InvalidPoints)
{
  auto cloud = makeRow({0.0f, 255.0f, 100.0f}, 1);
  cloud.push_back({nan_value, 0.0f, 0.0f, 1e9f});
  auto encoder = makeEncoder<pcl::PointXYZI>(true);
  Compression<pcl::PointXYZI> decoder;
  const auto decoded = decode(decoder, encode(encoder, cloud));
  ASSERT_EQ(decoded.size(), 3u);
  for (const float intensity : {0.0f, 255.0f, 100.0f})
    EXPECT_TRUE(std::any_of(decoded.begin(), decoded.end(), [&](const auto& point) {
      return point.intensity == intensity;
    })) << intensity;
}

// The hashes are those of streams written before scalar fields were coded.
TEST(ScalarFieldCoding, OtherStreamsAreAsBefore)
{
  const std::uint16_t one = 1;
  if (reinterpret_cast<const char*>(&one)[0] != 1)
    GTEST_SKIP() << "streams have the byte order of the machine";
  EXPECT_EQ(hashOfStream<pcl::PointXYZ>(false), 0x9a9937921d65271cu);
  EXPECT_EQ(hashOfStream<pcl::PointXYZ>(true), 0xac60d9d97cafc92cu);
  EXPECT_EQ(hashOfStream<pcl::PointXYZRGB>(false), 0x0ba6392b9df31eb2u);
  EXPECT_EQ(hashOfStream<pcl::PointXYZRGB>(true), 0x42dadf209d94e597u);
}

TEST(ScalarFieldCoding, StreamsWithoutFields)
{
  for (const bool voxel_grid : {false, true}) {
    const auto cloud = makeRow({3.0f, 4.0f, 5.0f, 6.0f}, 2);
    Cloud<pcl::PointXYZ> positions;
    for (const auto& point : cloud)
      positions.push_back({point.x, point.y, point.z});
    auto with_fields = makeEncoder<pcl::PointXYZI>(voxel_grid);
    auto without_fields = makeEncoder<pcl::PointXYZI>(voxel_grid);
    auto without_intensity = makeEncoder<pcl::PointXYZ>(voxel_grid);
    without_fields.setScalarFields({});

    Compression<pcl::PointXYZI> decoder;
    EXPECT_NE(decode(decoder, encode(with_fields, cloud))[0].intensity, 0.0f);
    const std::string bytes = encode(without_fields, cloud);
    EXPECT_EQ(bytes, encode(without_intensity, positions));
    const auto decoded = decode(decoder, bytes);
    EXPECT_EQ(decoded.size(), voxel_grid ? 2u : 4u);
    for (const auto& point : decoded)
      EXPECT_EQ(point.intensity, 0.0f); // not that of the frame before
  }
}

TEST(ScalarFieldCoding, StreamThatEndsBeforeTheHeader)
{
  auto encoder = makeEncoder<pcl::PointXYZI>(false);
  const std::string bytes = encode(encoder, makeRow({1.0f, 2.0f, 3.0f, 4.0f}, 2));
  const std::size_t end = bytes.find(header_identifier) + header_identifier.size();
  ASSERT_LT(end, bytes.size());
  for (std::size_t size = 0; size < end; ++size) {
    Compression<pcl::PointXYZI> decoder;
    EXPECT_TRUE(decode(decoder, bytes.substr(0, size)).empty()) << size;
  }
}

// Fields that are cut off, with and without the right size, before a whole frame.
TEST(ScalarFieldCoding, FieldsThatEndTooEarly)
{
  for (const std::size_t points_per_voxel : {1, 2}) {
    auto encoder = makeEncoder<pcl::PointXYZI>(false);
    const std::string bytes =
        encode(encoder, makeRow({1.0f, 2.5f, nan_value, 4.0f}, points_per_voxel));
    const std::string fields = fieldsOf(bytes);
    const std::size_t start = makeFields("").size();
    ASSERT_GT(fields.size(), start + 2 * 1028);
    for (std::size_t size = start; size < fields.size(); ++size)
      expectNoIntensities(makeFields(fields.substr(start, size - start)));
    const std::size_t start_of_size = start - sizeof(std::uint32_t);
    for (std::size_t size = 0; size < start_of_size; ++size)
      expectNoIntensities(fields.substr(0, size));

    // the frame is taken for the rest of the fields
    for (std::size_t size = start_of_size; size < fields.size(); ++size) {
      Compression<pcl::PointXYZI> decoder;
      EXPECT_TRUE(decode(decoder, fields.substr(0, size) + frameOf(bytes)).empty());
    }
    EXPECT_EQ(makeFields(fields.substr(start)), fields);
  }
}

TEST(ScalarFieldCoding, FieldsWithImpossibleCounts)
{
  const std::string frequencies = asBytes(makeFrequencies());
  const std::string no_levels = asBytes(std::uint64_t{0});
  for (const std::uint64_t count : {std::uint64_t{1},
                                    std::uint64_t{1000},
                                    std::uint64_t{1} << 20,
                                    (std::uint64_t{1} << 31) - 1,
                                    std::uint64_t{1} << 31,
                                    std::uint64_t{1} << 40,
                                    std::numeric_limits<std::uint64_t>::max()})
    for (const std::uint32_t steps : {0u, 255u, 65535u, 0xFFFFFFFFu}) {
      SCOPED_TRACE(testing::Message() << count << " levels of " << steps << " steps");
      const std::string content = startOfContent(steps);
      expectNoIntensities(makeFields(content + asBytes(count)));
      expectNoIntensities(makeFields(content + asBytes(count) + no_levels));
      expectNoIntensities(makeFields(content + no_levels + asBytes(count)));
      if (count > 1)
        expectNoIntensities(makeFields(content + asBytes(count) + frequencies +
                                       std::string(5000, '\0')));
    }

  // numbers of fields and sizes of names and fields
  const std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
  expectNoIntensities(makeFields(asBytes(most)));
  expectNoIntensities(makeFields(asBytes(most) + std::string(5000, '\0')));
  expectNoIntensities(makeFields(asBytes(std::uint32_t{1}) + asBytes(most)));
  expectNoIntensities(
      makeFields(asBytes(std::uint32_t{1}) + asBytes(most) + std::string(5000, 'a')));
  Compression<pcl::PointXYZI> decoder;
  EXPECT_TRUE(
      decode(decoder, makeFields("").substr(0, 23) + asBytes(most) + "abc").empty());
}

TEST(ScalarFieldCoding, FieldsWithImpossibleFrequencies)
{
  const Table growing = makeFrequencies();
  Table zeros{}, first_is_not_0 = growing, too_large = growing, two_equal = growing,
                 falling = growing;
  std::iota(first_is_not_0.begin(), first_is_not_0.end(), 1u);
  too_large.back() = 1u << 16;
  two_equal[200] = two_equal[201];
  std::reverse(falling.begin(), falling.end());
  const auto content_with = [](const Table& table) {
    const std::string levels =
        asBytes(std::uint64_t{2}) + asBytes(table) + std::string(20, '\0');
    return startOfContent(255) + levels + asBytes(std::uint64_t{0});
  };
  for (const Table& table : {zeros, first_is_not_0, too_large, two_equal, falling})
    expectNoIntensities(makeFields(content_with(table)));

  // a right table at the end
  const std::string levels = asBytes(std::uint64_t{2}) + asBytes(growing);
  for (const std::size_t size : {0, 1, 2, 3})
    expectNoIntensities(
        makeFields(startOfContent(255) + levels + std::string(size, '\0')));
}

TEST(ScalarFieldCoding, FieldsOfAnotherFrame)
{
  for (const bool voxel_grid : {false, true}) {
    const auto bytes_of_row = [voxel_grid](std::size_t voxels, std::size_t points) {
      auto encoder = makeEncoder<pcl::PointXYZI>(voxel_grid);
      return encode(encoder, makeRow(std::vector<float>(voxels * points, 5), points));
    };
    const auto count_intensities = [](const Cloud<pcl::PointXYZI>& cloud) {
      return std::count_if(cloud.begin(), cloud.end(), [](const auto& point) {
        return point.intensity == 5.0f;
      });
    };
    const std::string one_voxel = bytes_of_row(1, 3);
    const std::string three_voxels = bytes_of_row(3, 3);
    const std::string single_points = bytes_of_row(3, 1);

    Compression<pcl::PointXYZI> decoder;
    auto decoded = decode(decoder, fieldsOf(one_voxel) + frameOf(three_voxels));
    EXPECT_EQ(decoded.size(), voxel_grid ? 3u : 9u);
    EXPECT_EQ(count_intensities(decoded), voxel_grid ? 1 : 3);

    decoded = decode(decoder, fieldsOf(single_points) + frameOf(three_voxels));
    EXPECT_EQ(decoded.size(), voxel_grid ? 3u : 9u);
    EXPECT_EQ(count_intensities(decoded), voxel_grid ? 3 : 0);

    // more values than the frame has points are for another frame
    decoded = decode(decoder, fieldsOf(three_voxels) + frameOf(one_voxel));
    EXPECT_EQ(decoded.size(), voxel_grid ? 1u : 3u);
    EXPECT_EQ(count_intensities(decoded), voxel_grid ? 1 : 0);
    // what is left is not for the next frame
    EXPECT_EQ(count_intensities(decode(decoder, frameOf(three_voxels))), 0);

    // also if the stream ended between the fields and their frame
    EXPECT_TRUE(decode(decoder, fieldsOf(three_voxels)).empty());
    EXPECT_EQ(count_intensities(decode(decoder, frameOf(three_voxels))), 0);
  }
}

TEST(ScalarFieldCoding, WarningsOfSetScalarFields)
{
  std::vector<std::string> warnings;
  pcl::console::setCallback([&warnings](const pcl::console::LogRecord& record) {
    if (record.level == pcl::console::L_WARN)
      warnings.push_back(record.message);
  });
  Compression<pcl::PointXYZI> compression;
  Compression<pcl::PointXYZ> without_intensity;
  compression.setScalarFields({"intensity"});
  compression.setScalarFields({"intensity"}, 2);
  compression.setScalarFields({"intensity"}, 16);
  compression.setScalarFields({});
  EXPECT_TRUE(warnings.empty());
  compression.setScalarFields({"intensity", "ring"});
  without_intensity.setScalarFields({"intensity", "x"});
  compression.setScalarFields({"intensity"}, 1);
  compression.setScalarFields({"intensity"}, 17);
  pcl::console::setCallback(nullptr);
  const std::vector<std::string> expected{
      "'ring'", "'intensity'", "'x'", "is 1! Using 2.", "is 17! Using 16."};
  ASSERT_EQ(warnings.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NE(warnings[i].find(expected[i]), std::string::npos) << warnings[i];
}

int
main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  return (RUN_ALL_TESTS());
}
