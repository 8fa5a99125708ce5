// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>

#include "support/status_codes.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;
using pcl_ext::IntensityUnit;

struct LidarPoint {
  float x, y, z;
  std::uint16_t ring;
  std::int8_t label;
  std::uint8_t flags[3];
  float intensity;
  double time;
};

PointView
viewOf(const std::vector<LidarPoint>& points)
{
  PointView view;
  view.count = points.size();
  view.coordinates = &points.front().x;
  view.coordinate_stride = sizeof(LidarPoint);
  const LidarPoint& first = points.front();
  view.fields = {{{"ring", FieldType::UInt16}, &first.ring, sizeof(first)},
                 {{"label", FieldType::Int8}, &first.label, sizeof(first)},
                 {{"flags", FieldType::UInt8, 3}, first.flags, sizeof(first)},
                 {{"intensity", FieldType::Float32}, &first.intensity, sizeof(first)},
                 {{"time", FieldType::Float64}, &first.time, sizeof(first)}};
  return view;
}

/** \brief A turn of a lidar in a room; some points are not finite. */
std::vector<LidarPoint>
turnOf(unsigned int seed)
{
  std::mt19937_64 random(seed);
  std::vector<LidarPoint> points;
  for (unsigned int column = 0; column < 360; ++column)
    for (std::uint16_t ring = 0; ring < 16; ++ring) {
      LidarPoint point{};
      const double azimuth = column * 0.0174533;
      const double elevation = (ring - 8) * 0.03;
      const double range = 3.0 + std::cos(3 * azimuth) + 0.01 * uniform(random, -1, 1);
      point.x = static_cast<float>(range * std::cos(azimuth) * std::cos(elevation));
      point.y = static_cast<float>(range * std::sin(azimuth) * std::cos(elevation));
      point.z = static_cast<float>(range * std::sin(elevation));
      if (below(random, 50) == 0)
        point.x = std::numeric_limits<float>::quiet_NaN();
      point.ring = ring;
      point.label = static_cast<std::int8_t>(column / 60 - 3);
      for (std::uint8_t& flag : point.flags)
        flag = static_cast<std::uint8_t>(below(random, 3));
      point.intensity = static_cast<float>(below(random, 256));
      point.time = 1.6e9 + seed * 0.1 + column * 1e-4 + ring * 2.3e-6;
      points.push_back(point);
    }
  return points;
}

using Index = std::array<std::int64_t, 3>;

Index
voxelOf(const LidarPoint& point, double resolution)
{
  const auto index = [resolution](float coordinate) {
    return static_cast<std::int64_t>(
        std::floor(static_cast<double>(coordinate) / resolution));
  };
  return {index(point.x), index(point.y), index(point.z)};
}

/** \brief The voxel of each point of a frame, in its order. */
std::vector<Index>
voxelsOf(const VoxelFrame& frame)
{
  std::vector<Index> voxels;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame.keys[i]);
    const Index index = {std::int64_t{position.x} + frame.grid.first_index[0],
                         std::int64_t{position.y} + frame.grid.first_index[1],
                         std::int64_t{position.z} + frame.grid.first_index[2]};
    voxels.insert(
        voxels.end(), frame.has_point_counts ? frame.point_counts[i] : 1, index);
  }
  return voxels;
}

class Fields : public ::testing::Test {
protected:
  Fields()
  {
    settings_.resolution = 0.05;
    settings_.keep_points = true;
  }

  CompressionStatus
  send(const std::vector<LidarPoint>& points)
  {
    if (!encoder_)
      encoder_.emplace(settings_, IntensityUnit::None);
    const CompressionStatus status = encoder_->encode(viewOf(points), {}, bytes_);
    return status.ok() ? decoder_.decode(bytes_.data(), bytes_.size(), decoded_)
                       : status;
  }

  const FrameField&
  field(const std::string& name) const
  {
    for (const FrameField& field : decoded_.fields)
      if (field.name == name)
        return field;
    throw std::out_of_range(name);
  }

  EncoderSettings settings_;
  std::optional<CloudEncoder> encoder_;
  FrameDecoder decoder_;
  Bytes bytes_;
  VoxelFrame decoded_;
};

/** \brief All that a point has, to be compared; flags are three values. */
struct SentPoint {
  SentPoint(const LidarPoint& point, const std::array<double, 3>& place)
  : values{point.time,
           point.ring,
           point.label,
           {point.flags[0], point.flags[1], point.flags[2]},
           point.intensity}
  , position(place)
  {}

  std::tuple<double, std::uint16_t, std::int8_t, std::array<int, 3>, float> values;
  std::array<double, 3> position;

  bool
  operator<(const SentPoint& other) const
  {
    return values < other.values;
  }
};

TEST_F(Fields, OfPointsComeBackExactlyWithTheirPoints)
{
  settings_.fields = {{all_fields}};
  for (unsigned int seed = 0; seed < 4; ++seed) {
    const std::vector<LidarPoint> points = turnOf(seed);
    ASSERT_TRUE(send(points).ok());
    ASSERT_EQ(decoded_.fields.size(), 5u);
    std::vector<SentPoint> sent;
    for (const LidarPoint& point : points)
      if (std::isfinite(point.x))
        sent.push_back({point, {point.x, point.y, point.z}});
    std::vector<SentPoint> received;
    forEachPoint(
        decoded_,
        [&](std::size_t i, double x, double y, double z, float, const VoxelColour&) {
          LidarPoint point{};
          fieldValue(field("ring"), field("ring").numbers[i], &point.ring);
          fieldValue(field("label"), field("label").numbers[i], &point.label);
          for (std::size_t k = 0; k < 3; ++k)
            fieldValue(
                field("flags"), field("flags").numbers[3 * i + k], &point.flags[k]);
          fieldValue(
              field("intensity"), field("intensity").numbers[i], &point.intensity);
          fieldValue(field("time"), field("time").numbers[i], &point.time);
          received.push_back({point, {x, y, z}});
        });
    std::sort(sent.begin(), sent.end());
    std::sort(received.begin(), received.end());
    ASSERT_EQ(received.size(), sent.size());
    for (std::size_t i = 0; i < sent.size(); ++i) {
      ASSERT_EQ(received[i].values, sent[i].values);
      for (std::size_t axis = 0; axis < 3; ++axis)
        ASSERT_NEAR(received[i].position[axis],
                    sent[i].position[axis],
                    0.5001 * settings_.resolution);
    }
  }
}

TEST_F(Fields, OfPointsOfAVoxelAscendWithTheFirstOne)
{
  settings_.fields = {{all_fields}};
  encoder_.emplace(settings_, IntensityUnit::Points); // without which they are scans
  const std::vector<LidarPoint> points = turnOf(0);
  ASSERT_TRUE(encoder_->encode(viewOf(points), {}, bytes_).ok());
  ASSERT_TRUE(decoder_.decode(bytes_.data(), bytes_.size(), decoded_).ok());
  ASSERT_FALSE(decoded_.points.areThere());
  const std::vector<Index> voxels = voxelsOf(decoded_);
  ASSERT_EQ(voxels.size(), decoded_.pointCount());
  for (std::size_t i = 1; i < voxels.size(); ++i)
    EXPECT_TRUE(voxels[i] != voxels[i - 1] ||
                field("ring").numbers[i] >= field("ring").numbers[i - 1]);
}

TEST_F(Fields, OfVoxelsAreMeansAndOfIntegersTheMostFrequent)
{
  settings_.fields = {{"intensity"}, {"ring"}};
  settings_.keep_points = false;
  const std::vector<LidarPoint> points = turnOf(7);
  ASSERT_TRUE(send(points).ok());
  std::map<Index, std::vector<LidarPoint>> of_voxel;
  for (const LidarPoint& point : points)
    if (std::isfinite(point.x))
      of_voxel[voxelOf(point, settings_.resolution)].push_back(point);
  const std::vector<Index> voxels = voxelsOf(decoded_);
  ASSERT_EQ(voxels.size(), of_voxel.size());
  std::size_t with_several = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const std::vector<LidarPoint>& inside = of_voxel.at(voxels[i]);
    with_several += inside.size() > 1 ? 1 : 0;
    double sum = 0.0;
    std::map<std::uint16_t, std::size_t> counts;
    for (const LidarPoint& point : inside) {
      sum += static_cast<double>(point.intensity);
      ++counts[point.ring];
    }
    const auto most = std::max_element(
        counts.begin(), counts.end(), [](const auto& one, const auto& other) {
          return one.second < other.second; // the first of equals: the lowest ring
        });
    float intensity = 0.0f;
    fieldValue(field("intensity"), field("intensity").numbers[i], &intensity);
    EXPECT_EQ(intensity, static_cast<float>(sum / static_cast<double>(inside.size())));
    EXPECT_EQ(field("ring").numbers[i], most->first);
  }
  EXPECT_GT(with_several, 100u);
}

TEST_F(Fields, OfVoxelsHaveNoNaNInTheirMeans)
{
  settings_.fields = {{"intensity"}};
  settings_.keep_points = false;
  settings_.resolution = 1.0;
  std::vector<LidarPoint> points(3, turnOf(0).front());
  points[0].intensity = std::numeric_limits<float>::quiet_NaN();
  points[1].intensity = 2.0f;
  points[2].intensity = 4.0f;
  const auto mean = [&](std::size_t count) {
    EXPECT_TRUE(
        send({points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count)})
            .ok());
    return fieldValue(field("intensity"), field("intensity").numbers.at(0));
  };
  EXPECT_EQ(mean(3), 3.0);
  points[1].intensity = points[0].intensity;
  EXPECT_TRUE(std::isnan(mean(2)));
}

TEST_F(Fields, OfVoxelsWithSeveralIntegersAreThoseOfOnePoint)
{
  settings_.fields = {{"flags"}};
  settings_.keep_points = false;
  settings_.resolution = 1.0;
  std::vector<LidarPoint> points(5, turnOf(0).front());
  const std::uint8_t flags[][3] = {
      {1, 0, 0}, {1, 0, 0}, {2, 9, 0}, {3, 9, 0}, {4, 9, 0}};
  for (std::size_t i = 0; i < points.size(); ++i)
    std::copy_n(flags[i], 3, points[i].flags);
  ASSERT_TRUE(send(points).ok());
  EXPECT_EQ(field("flags").numbers, (std::vector<std::uint64_t>{1, 0, 0}));
}

TEST_F(Fields, OfVoxelsThatAreColoursAreMeansOfChannels)
{
  settings_.keep_points = false;
  settings_.resolution = 1.0;
  std::vector<LidarPoint> points(3, turnOf(0).front());
  const std::uint32_t colours[] = {0xff0a0000, 0xff0aff10, 0xff0a0020};
  for (const FieldType type : {FieldType::Float32, FieldType::UInt32}) {
    for (std::size_t i = 0; i < points.size(); ++i)
      std::memcpy(&points[i].intensity, &colours[i], sizeof(colours[i]));
    settings_.fields = {{"rgb"}};
    PointView view = viewOf(points);
    view.fields[3].description = {"rgb", type};
    CloudEncoder encoder(settings_, IntensityUnit::None);
    ASSERT_TRUE(encoder.encode(view, {}, bytes_).ok());
    FrameDecoder decoder;
    ASSERT_TRUE(decoder.decode(bytes_.data(), bytes_.size(), decoded_).ok());
    ASSERT_EQ(field("rgb").numbers.size(), 1u);
    std::uint32_t colour = 0;
    fieldValue(field("rgb"), field("rgb").numbers[0], &colour);
    EXPECT_EQ(colour, 0xff0a5510u);
  }
}

TEST_F(Fields, WithAStepAreWithinHalfOfIt)
{
  settings_.fields = {{"ring"}, {"time", 1e-5}, {"intensity", 10.0}};
  const std::vector<LidarPoint> points = turnOf(3);
  ASSERT_TRUE(send(points).ok());
  // Ring and the step of the time tell the points apart.
  std::map<std::pair<int, std::int64_t>, LidarPoint> sent;
  for (const LidarPoint& point : points)
    sent[{point.ring, std::llround(point.time * 1e4 - point.ring * 0.023)}] = point;
  ASSERT_EQ(sent.size(), points.size());
  for (std::size_t i = 0; i < field("ring").numbers.size(); ++i) {
    const auto ring = static_cast<int>(field("ring").numbers[i]);
    const double time = fieldValue(field("time"), field("time").numbers[i]);
    const LidarPoint& point = sent.at({ring, std::llround(time * 1e4 - ring * 0.023)});
    EXPECT_LE(std::abs(time - point.time), 5.5e-6); // doubles are 2.4e-7 apart there
    float intensity = 0.0f;
    fieldValue(field("intensity"), field("intensity").numbers[i], &intensity);
    EXPECT_LE(std::abs(intensity - point.intensity), 5.0f);
    EXPECT_EQ(std::fmod(intensity, 10.0f), 0.0f);
  }
}

TEST_F(Fields, AreDescribedByAnIFrame)
{
  settings_.fields = {{"time", 0.25}, {"flags"}};
  ASSERT_TRUE(send(turnOf(0)).ok());
  const FrameDescription description = describeFrame(bytes_.data(), bytes_.size());
  ASSERT_EQ(description.fields.size(), 2u);
  EXPECT_EQ(description.fields[0].name, "time");
  EXPECT_EQ(description.fields[0].type, FieldType::Float64);
  EXPECT_EQ(description.fields[0].step, 0.25);
  EXPECT_EQ(description.fields[1].name, "flags");
  EXPECT_EQ(description.fields[1].count, 3u);
}

TEST_F(Fields, AreWithTheLayoutOfTheirMessages)
{
  MessageLayout layout;
  layout.fields.resize(2);
  layout.fields[0].name = "ring";
  layout.fields[0].type = FieldType::UInt16;
  layout.fields[0].offset = 30;
  layout.fields[1].name = "x";
  layout.point_step = 32;
  layout.row_padding = 7;
  settings_.fields = {{"ring"}};
  for (const bool has_order : {false, true}) { // voxels and scans
    settings_.keep_points = settings_.keep_order = has_order;
    encoder_.emplace(settings_, IntensityUnit::None);
    decoder_ = FrameDecoder();
    CloudInfo info;
    const auto sendOne = [&](const MessageLayout* of_cloud, bool is_i_frame) {
      info.layout =
          of_cloud != nullptr ? std::make_shared<MessageLayout>(*of_cloud) : nullptr;
      const std::vector<LidarPoint> points = turnOf(0);
      ASSERT_TRUE(encoder_->encode(viewOf(points), info, bytes_).ok());
      ASSERT_TRUE(decoder_.decode(bytes_.data(), bytes_.size(), decoded_).ok());
      EXPECT_EQ(decoder_.statistics().is_i_frame, is_i_frame);
      EXPECT_EQ(decoded_.points.areThere(), has_order);
      ASSERT_EQ(decoded_.layout != nullptr, of_cloud != nullptr);
      EXPECT_TRUE(of_cloud == nullptr || *decoded_.layout == *of_cloud);
    };
    MessageLayout other = layout;
    other.fields.pop_back();
    sendOne(&layout, true);
    sendOne(&layout, false);
    sendOne(&other, true);
    sendOne(&other, false);
    sendOne(nullptr, true);
    other.point_step = 31; // in the middle of ring
    info.layout = std::make_shared<MessageLayout>(other);
    const std::vector<LidarPoint> points = turnOf(0);
    EXPECT_EQ(encoder_->encode(viewOf(points), info, bytes_).code(),
              CompressionCode::InvalidInput);
    sendOne(nullptr, false);
  }
}

TEST_F(Fields, ThatACloudLacksAreAnError)
{
  settings_.fields = {{"reflectivity"}};
  const CompressionStatus status = send(turnOf(0));
  EXPECT_EQ(status.code(), CompressionCode::InvalidInput);
  EXPECT_EQ(status.message(),
            "the cloud has no field 'reflectivity' to keep; it has: 'ring', 'label', "
            "'flags', 'intensity', 'time'");
}

TEST_F(Fields, OfTooManyStepsAreAnError)
{
  settings_.fields = {{"ring"}, {"time", 4e-7}}; // 1.6e9 s are 4.0e15 steps
  EXPECT_TRUE(send(turnOf(0)).ok());
  for (const bool keeps_points : {true, false}) {
    settings_.keep_points = keeps_points;
    settings_.fields.back().step = 3.5e-7; // 4.57e15, and 2^52 is 4.50e15
    for (const double sign : {1.0, -1.0}) {
      std::vector<LidarPoint> points = turnOf(0);
      for (LidarPoint& point : points)
        point.time *= sign;
      encoder_.reset();
      const CompressionStatus status = send(points);
      EXPECT_EQ(status.code(), CompressionCode::InvalidInput);
      EXPECT_EQ(status.message(),
                "field 'time' has a value of 2^52 steps or more: it needs a larger "
                "step, or none");
    }
  }
}

TEST_F(Fields, OfIntegersNeedWholeSteps)
{
  // Multiples of 1.5 would be rounded once more: 5 is 3 of them, and so 4.
  settings_.fields = {{"time", 0.5}, {"ring", 1.5}};
  const CompressionStatus status = send(turnOf(0));
  EXPECT_EQ(status.code(), CompressionCode::InvalidInput);
  EXPECT_EQ(status.message(),
            "field 'ring' cannot be kept: its values are integers and its step is 1.5; "
            "it must be a whole number, or 0 for exact values");
  settings_.fields.back().step = 3.0;
  encoder_.reset();
  ASSERT_TRUE(send(turnOf(0)).ok());
  for (const std::uint64_t number : field("ring").numbers)
    EXPECT_EQ(std::fmod(fieldValue(field("ring"), number), 3.0), 0.0);
}

/** \brief The names of the fields of a turn's frame, or why there is none.
 * \param[in] settings of the fields
 * \param[in] name that of the flags
 * \param[in] count their values
 */
std::string
keptFields(const std::vector<FieldSetting>& settings,
           const std::string& name,
           std::uint32_t count)
{
  EncoderSettings of_encoder;
  of_encoder.resolution = 0.05;
  of_encoder.keep_points = true;
  of_encoder.fields = settings;
  const std::vector<LidarPoint> points = turnOf(0);
  PointView view = viewOf(points);
  view.fields[2].description.name = name;
  view.fields[2].description.count = count;
  CloudEncoder encoder(of_encoder, IntensityUnit::None);
  VoxelFrame frame;
  const CompressionStatus status =
      encoder.voxelize(view, pcl_ext::WorldPose::Identity(), frame);
  EXPECT_EQ(status.code(),
            status.ok() ? CompressionCode::Ok : CompressionCode::InvalidInput);
  std::string names = status.message();
  for (const FrameField& field : frame.fields)
    names += field.name + ' ';
  return names;
}

TEST(DescribedFields, ThatCannotBeKeptAreLeftOutOfAllAndAnErrorWhereTheyAreNamed)
{
  const FieldSetting all{all_fields};
  const std::string without = "ring label intensity time ";
  EXPECT_EQ(keptFields({all}, "all", 3), "ring label all intensity time ");
  EXPECT_EQ(keptFields({{"time"}, all}, "all", 3), "time ring label all intensity ");
  const std::string long_name(65, 'n');
  EXPECT_EQ(keptFields({all}, long_name, 3), without);
  EXPECT_EQ(keptFields({all}, "", 3), without);
  EXPECT_EQ(keptFields({all}, "flags", 4097), without);
  EXPECT_EQ(keptFields({{long_name}}, long_name, 3),
            "field '" + long_name +
                "' cannot be kept: its name has 65 bytes; it must have 1 to 64");
  EXPECT_EQ(keptFields({{"flags"}}, "flags", 4097),
            "field 'flags' cannot be kept: a point has 4097 values of it; it must have "
            "1 to 4096");
  EXPECT_EQ(keptFields({all}, "flags", 4093),
            "too many fields: 5 with 4097 values a point; at most 64 with 4096 values "
            "can be kept");
}

TEST_F(Fields, BeyondTheLimitOfDecodersAreTold)
{
  settings_.fields = {{"flags"}};
  ASSERT_TRUE(send(turnOf(0)).ok());
  const std::size_t values = decoded_.fieldValueCount();
  settings_.decoder_limits.max_field_values = values - 1;
  encoder_.emplace(settings_, IntensityUnit::None);
  const std::vector<LidarPoint> points = turnOf(0);
  EXPECT_EQ(
      encoder_->encode(viewOf(points), {}, bytes_).message(),
      "the frame needs a decoder with decoder_limits.max_field_values of at least " +
          std::to_string(values) + "; that of the settings is " +
          std::to_string(values - 1));
}

} // namespace
