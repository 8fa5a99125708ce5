// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/status.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cfloat>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::io;

using Settings = IntensityCompressionSettings;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr float float_infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_float = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t largest_size = std::numeric_limits<std::size_t>::max();

void
expectAccepted(const Settings& settings)
{
  const CompressionStatus status = checkSettings(settings);
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(status.code(), CompressionCode::Ok);
  EXPECT_TRUE(status.message().empty()) << status.message();
}

/** \brief Expects a refusal whose message names something. */
void
expectRefused(const std::string& name, const Settings& settings)
{
  const CompressionStatus status = checkSettings(settings);
  EXPECT_FALSE(status.ok());
  EXPECT_EQ(static_cast<int>(status.code()),
            static_cast<int>(CompressionCode::InvalidSettings));
  EXPECT_NE(status.message().find(name), std::string::npos)
      << "'" << name << "' is not in: " << status.message();
}

Settings
publishedSettings()
{
  Settings settings;
  settings.format = StreamFormat::Published;
  return settings;
}

template <typename NumberT>
using Values = std::vector<NumberT>;

template <typename GroupT, typename NumberT>
void
expectAccepted(NumberT GroupT::*field,
               const Values<NumberT>& values,
               Settings settings = Settings())
{
  for (const NumberT value : values) {
    SCOPED_TRACE(testing::PrintToString(value));
    settings.*field = value;
    expectAccepted(settings);
  }
}

template <typename GroupT, typename NumberT>
void
expectRefused(const std::string& name,
              NumberT GroupT::*field,
              const Values<NumberT>& values,
              Settings settings = Settings())
{
  for (const NumberT value : values) {
    SCOPED_TRACE(testing::PrintToString(value));
    settings.*field = value;
    expectRefused(name, settings);
  }
}

Values<unsigned int>
bitsUpTo(unsigned int last)
{
  Values<unsigned int> values;
  for (unsigned int bits = 0; bits <= last; ++bits)
    values.push_back(bits);
  return values;
}

TEST(CompressionSettings, DefaultsAreTheDocumentedOnesAndValid)
{
  const Settings settings;
  EXPECT_EQ(settings.resolution, 0.01);
  EXPECT_EQ(settings.i_frame_rate, 30u);
  EXPECT_EQ(settings.first_frame_number, 1u);
  EXPECT_EQ(settings.effort, Effort::Fast);
  EXPECT_EQ(settings.format, StreamFormat::Version1);
  EXPECT_EQ(settings.aggregation, Aggregation::Automatic);
  EXPECT_EQ(settings.intensity_range, 0.0f);
  EXPECT_EQ(settings.intensity_bits, 0u);
  EXPECT_EQ(settings.intensity_curve, IntensityCurve::Linear);
  EXPECT_FALSE(settings.bounding_box.has_value());
  EXPECT_FALSE(settings.sensor_pose.has_value());
  EXPECT_FALSE(settings.carry_header);
  EXPECT_FALSE(settings.retain_octree);
  EXPECT_FALSE(settings.show_statistics);
  EXPECT_EQ(settings.decoder_limits.max_frame_bytes, std::size_t{1} << 28);
  EXPECT_EQ(settings.decoder_limits.max_voxels, std::size_t{1} << 26);
  EXPECT_EQ(settings.decoder_limits.free_voxels, std::size_t{1} << 23);
  EXPECT_TRUE(checkSettings(settings).ok());
  EXPECT_TRUE(checkSettings(publishedSettings()).ok());
}

TEST(CompressionSettings, ResolutionMustBeALength)
{
  expectAccepted(&Settings::resolution, {1e-6, 0.001, 0.04, 1.0, 1000.0, 1e6});
  expectRefused("resolution",
                &Settings::resolution,
                {0.0,
                 -0.0,
                 -0.01,
                 9.9e-7,
                 1.01e6,
                 1e39,
                 DBL_MAX,
                 infinity,
                 -infinity,
                 not_a_number});
}

TEST(CompressionSettings, IFrameRatesAndSwitchesAreFree)
{
  expectAccepted(&Settings::i_frame_rate, {0u, 1u, 2u, 30u, 4294967295u});
  expectAccepted(&Settings::temporal_filter, {0u, 2u, 8u, 64u});
  expectAccepted(&Settings::temporal_filter, {8u}, publishedSettings());
  expectRefused("temporal_filter", &Settings::temporal_filter, {1u, 65u, 4294967295u});
  Settings filtered;
  filtered.temporal_filter = 8;
  expectRefused("keep_point_counts", &Settings::keep_point_counts, {true}, filtered);
  expectAccepted(&Settings::retain_octree, {true});
  expectAccepted(&Settings::retain_octree, {true}, publishedSettings());
  expectAccepted(&Settings::show_statistics, {true});
  expectAccepted(&Settings::carry_header, {true});
}

TEST(CompressionSettings, BudgetsMustBeInTheirRanges)
{
  const auto fault = [](auto RateSettings::*field, auto value) {
    Settings settings;
    settings.*field = value;
    return checkSettings(settings).message();
  };
  expectAccepted(&Settings::max_rate, {0.0, 1e3, 1e12});
  expectRefused("max_rate",
                &Settings::max_rate,
                {-1.0, 999.0, 1.01e12, infinity, -infinity, not_a_number});
  EXPECT_EQ(fault(&RateSettings::max_rate, 500.0),
            "max_rate is 500; it must be 1e3 to 1e12 bits a second, or 0 for no "
            "limit");
  expectAccepted(&Settings::rate_buffer, {0.01, 1.0});
  expectRefused(
      "rate_buffer", &Settings::rate_buffer, {0.0, 0.009, 1.01, -0.25, not_a_number});
  EXPECT_EQ(fault(&RateSettings::rate_buffer, 2.0),
            "rate_buffer is 2; it must be 0.01 to 1 seconds");
  expectAccepted(&Settings::max_encode_ms, {0.0, 0.1, 1e4});
  expectRefused("max_encode_ms",
                &Settings::max_encode_ms,
                {0.09, 1.01e4, -1.0, infinity, not_a_number});
  EXPECT_EQ(fault(&RateSettings::max_encode_ms, 2e4),
            "max_encode_ms is 20000; it must be 0.1 to 1e4 milliseconds, or 0 for "
            "no limit");
  expectAccepted(&Settings::rate_temporal_filter, {0u, 2u, 64u});
  expectRefused("rate_temporal_filter", &Settings::rate_temporal_filter, {1u, 65u});
  EXPECT_EQ(fault(&RateSettings::rate_temporal_filter, 1u),
            "rate_temporal_filter is 1; it must be 2 to 64 frames, or 0 for none");
  expectAccepted(&Settings::rate_doublings, {0u, 8u});
  EXPECT_EQ(fault(&RateSettings::rate_doublings, 9u),
            "rate_doublings is 9; it must be 0 to 8");
  expectAccepted(&Settings::rate_sent_share, {0.1, 1.0});
  EXPECT_EQ(fault(&RateSettings::rate_sent_share, 0.0),
            "rate_sent_share is 0; it must be 0.1 to 1");
}

TEST(CompressionSettings, EffortAndAggregationMustBeEnumerators)
{
  expectAccepted(&Settings::effort, {Effort::Fast, Effort::Balanced, Effort::Small});
  for (const int effort : {-1, 3, 7, 255})
    expectRefused("effort", &Settings::effort, {static_cast<Effort>(effort)});
  const Values<Aggregation> aggregations{
      Aggregation::Automatic, Aggregation::Sum, Aggregation::Mean};
  expectAccepted(&Settings::aggregation, aggregations);
  expectAccepted(&Settings::aggregation, aggregations, publishedSettings());
}

TEST(CompressionSettings, IntensityRangeMustBeZeroOrPositive)
{
  expectAccepted(&Settings::intensity_range,
                 {0.0f, -0.0f, 1e-3f, 1.0f, 65535.0f, FLT_MAX});
  expectRefused("intensity_range",
                &Settings::intensity_range,
                {-1e-30f, -1.0f, float_infinity, -float_infinity, not_a_float});
}

TEST(CompressionSettings, IntensityBitsMustBeAtMostSixteen)
{
  expectAccepted(&Settings::intensity_bits, bitsUpTo(16));
  expectRefused("intensity_bits", &Settings::intensity_bits, {17u, 32u, 4294967295u});
  Settings companded;
  companded.intensity_curve = IntensityCurve::Companded;
  expectAccepted(&Settings::intensity_bits, bitsUpTo(16), companded);
}

TEST(CompressionSettings, PublishedLayoutHasEightBitsALinearScaleAndNoHeader)
{
  const Settings published = publishedSettings();
  expectAccepted(&Settings::intensity_bits, {8u}, published);
  for (unsigned int bits = 1; bits <= 16; ++bits)
    if (bits != 8)
      expectRefused("intensity_bits", &Settings::intensity_bits, {bits}, published);
  expectAccepted(&Settings::intensity_range, {255.0f}, published);
  expectRefused(
      "intensity_range", &Settings::intensity_range, {1e-3f, 1.0f, 256.0f}, published);
  expectRefused("intensity_curve",
                &Settings::intensity_curve,
                {IntensityCurve::Companded},
                published);
  expectRefused("carry_header", &Settings::carry_header, {true}, published);
  expectRefused("keep_point_counts", &Settings::keep_point_counts, {true}, published);
}

TEST(CompressionSettings, BoundingBoxMustHaveAnExtentOnEachAxis)
{
  const BoundingBox good{{-1.0, -2.0, -3.0}, {1.0, 2.0, 3.0}};
  for (Settings settings : {Settings(), publishedSettings()}) {
    settings.bounding_box = good;
    expectAccepted(settings);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const double min :
           {good.max[axis], good.max[axis] + 0.5, infinity, -infinity, not_a_number}) {
        settings.bounding_box = good;
        settings.bounding_box->min[axis] = min;
        expectRefused("bounding_box", settings);
      }
      for (const double max :
           {good.min[axis], good.min[axis] - 0.5, infinity, -infinity, not_a_number}) {
        settings.bounding_box = good;
        settings.bounding_box->max[axis] = max;
        expectRefused("bounding_box", settings);
      }
    }
  }
}

TEST(CompressionSettings, BoundingBoxMayBeUpToTheGridsWidth)
{
  const double most_voxels = 2097151.0; // 2^21 - 1
  Settings settings;
  settings.resolution = 0.5;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    settings.bounding_box = BoundingBox{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
    double& min = settings.bounding_box->min[axis];
    double& max = settings.bounding_box->max[axis];
    min = -1048576.0 * 0.5;
    max = min + most_voxels * 0.5;
    expectAccepted(settings);
    max += 0.5;
    expectRefused("bounding_box", settings);
    for (const double far : {1e300, DBL_MAX}) {
      min = -far;
      max = far;
      expectRefused("bounding_box", settings);
    }
  }
  settings.bounding_box = BoundingBox{{-50.0, -50.0, -50.0}, {50.0, 50.0, 50.0}};
  expectAccepted(&Settings::resolution, {0.001}, settings);
  expectRefused("bounding_box", &Settings::resolution, {0.00001}, settings);
}

TEST(CompressionSettings, SensorPoseMustBeFiniteAndRigid)
{
  using Pose = Eigen::Isometry3f;
  Pose pose = Pose::Identity();
  pose.translate(Eigen::Vector3f(1.0f, 2.0f, 3.0f));
  pose.rotate(Eigen::AngleAxisf(0.7f, Eigen::Vector3f::UnitX()));
  Settings settings;
  settings.sensor_pose = pose;
  expectAccepted(settings);
  for (const float bad : {not_a_float, float_infinity}) {
    settings.sensor_pose = pose;
    settings.sensor_pose->linear()(2, 1) = bad;
    expectRefused("sensor_pose", settings);
    settings.sensor_pose = pose;
    settings.sensor_pose->translation().z() = bad;
    expectRefused("sensor_pose", settings);
  }
  // As SensorPreprocessor demands it: a stretched optical axis stretches the depth.
  for (const float stretch : {2.0f, 0.0f}) {
    settings.sensor_pose = Pose::Identity();
    settings.sensor_pose->linear() *= stretch;
    expectRefused("sensor_pose", settings);
  }
}

TEST(CompressionSettings, DecoderLimitsMustBeAboveZero)
{
  Settings settings;
  for (const std::size_t limit : {std::size_t{1}, largest_size}) {
    settings.decoder_limits.max_frame_bytes = limit;
    settings.decoder_limits.max_voxels = limit;
    expectAccepted(settings);
  }
  settings = Settings();
  settings.decoder_limits.max_frame_bytes = 0;
  expectRefused("max_frame_bytes", settings);
  settings = Settings();
  settings.decoder_limits.max_voxels = 0;
  expectRefused("max_voxels", settings);
  settings = Settings();
  settings.decoder_limits.free_voxels = 0;
  expectRefused("free_voxels", settings);
}

TEST(CompressionSettings, MessagesShowTheValue)
{
  expectRefused("-0.25", &Settings::resolution, {-0.25});
  expectRefused("17", &Settings::intensity_bits, {17u});
  expectRefused("-3.5", &Settings::intensity_range, {-3.5f});
}

} // namespace
