// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>

#include "stream/frame_warnings.h"
#include "support/float_values.h"
#include "support/point_views.h"
#include "support/text_parts.h"

#include <gtest/gtest.h>

#include <array>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;
using pcl_ext::IntensityUnit;
using pcl_ext::io::test::viewOf;
using pcl_ext::test::hasPart;
using pcl_ext::test::not_a_number;

using Points = std::vector<std::array<float, 4>>;

/** \brief The warning of a frame, or nothing. */
std::string
warningOf(const IntensityCompressionSettings& settings,
          IntensityUnit unit,
          const PointView& view)
{
  CloudEncoder encoder(settings, unit);
  std::vector<std::uint8_t> bytes;
  const CompressionStatus status = encoder.encode(view, {}, bytes);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_FALSE(bytes.empty());
  EXPECT_EQ(status.hasWarning(), !status.message().empty());
  return status.message();
}

/** \brief The same of native intensities. */
std::string
warningOf(const IntensityCompressionSettings& settings, const Points& points)
{
  return warningOf(settings, IntensityUnit::Native, viewOf(points));
}

IntensityCompressionSettings
settingsAt(double resolution)
{
  IntensityCompressionSettings settings;
  settings.resolution = resolution;
  return settings;
}

/** \brief Points a metre apart from each other with intensities. */
template <typename IntensityT>
Points
rowOf(int count, IntensityT intensity)
{
  Points points;
  for (int i = 0; i < count; ++i)
    points.push_back({static_cast<float>(i), 0.0f, 1.0f, intensity(i)});
  return points;
}

TEST(CompressionStatus, IsPrintedAsItsMessageAndNoNumber)
{
  const auto printed = [](const CompressionStatus& status) {
    std::ostringstream stream;
    stream << status;
    return stream.str();
  };
  EXPECT_EQ(printed({}), "ok");
  EXPECT_EQ(printed({CompressionCode::Corrupt, "a byte"}), "a byte");
  EXPECT_EQ(printed({CompressionCode::Corrupt, ""}), "failed");
  static_assert(!std::is_convertible_v<CompressionStatus, bool>, "explicit only");
  static_assert(std::is_constructible_v<bool, CompressionStatus>, "in conditions");
}

TEST(FrameWarnings, CloudWithoutAFinitePointIsMentioned)
{
  Points points(3, {not_a_number, 0.0f, 0.0f, 1.0f});
  EXPECT_TRUE(hasPart(warningOf(settingsAt(0.1), IntensityUnit::None, viewOf(points)),
                      "3 of 3 points are NaN or infinite: the frame is empty"));
  // Single ones are what depth cameras have where they see nothing.
  points[1][0] = 0.0f;
  for (const IntensityUnit unit : {IntensityUnit::Native, IntensityUnit::None})
    EXPECT_EQ(warningOf(settingsAt(0.1), unit, viewOf(points)), "");
}

TEST(FrameWarnings, PointsOutsideTheGridTellWhatHoldsThem)
{
  // 290 m wide; a grid of voxels of 0.1 mm is 210 m wide.
  Points points;
  for (int i = -145; i <= 145; ++i)
    points.push_back({static_cast<float>(i) + 0.00003f, 0.0f, 1.0f, 7.0f});
  const IntensityCompressionSettings settings = settingsAt(1e-4);
  const std::string warning = warningOf(settings, points);
  EXPECT_TRUE(hasPart(
      warning,
      "82 of 291 points are more than 2^20 voxels from the grid's origin and were left "
      "out: the cloud is 290 m wide, a grid of voxels of 0.0001 m at most 209.715 m: "
      "use coarsen_wide_clouds, a resolution of 0.00014 m or more, or a bounding_box "
      "around the points to keep"));
  EXPECT_FALSE(hasPart(warning, "origin amid"));
  // Shares of a voxel's face do not coarsen.
  EXPECT_FALSE(hasPart(warningOf(settings, IntensityUnit::Share, viewOf(points)),
                       "coarsen_wide_clouds"));
}

TEST(FrameWarnings, PointsOutsideTheGridOfAnOriginTellThatAnotherOneHoldsThem)
{
  Points points;
  for (int i = 0; i < 100; ++i)
    points.push_back({50.00003f + static_cast<float>(i), 0.0f, 1.0f, 7.0f});
  IntensityCompressionSettings settings = settingsAt(1e-4);
  settings.origin = {0.0, 0.0, 0.0};
  EXPECT_TRUE(hasPart(warningOf(settings, points),
                      "45 of 100 points are more than 2^20 voxels from the grid's "
                      "origin and were left out: set origin amid the points"));
  settings.origin = {100.0, 0.0, 0.0};
  EXPECT_EQ(warningOf(settings, points), "");
  // Wider than the grid, and around an origin.
  points.push_back({-150.0f, 0.0f, 1.0f, 7.0f});
  settings.origin = {0.0, 0.0, 0.0};
  EXPECT_TRUE(
      hasPart(warningOf(settings, points), "a resolution of 0.00015 m or more"));
  settings.resolution = 0.00015;
  EXPECT_EQ(warningOf(settings, points), "");
}

TEST(FrameWarnings, PointsThatNoResolutionHoldsAreForABox)
{
  Points points = rowOf(3, [](int) { return 7.0f; });
  points[2][0] = 1e30f;
  const std::string warning = warningOf(settingsAt(0.01), points);
  EXPECT_TRUE(hasPart(warning, "use a bounding_box around the points to keep"));
  EXPECT_FALSE(hasPart(warning, "resolution"));
}

TEST(FrameWarnings, PointsOutsideTheBoxAndIntensitiesThatAreNotFinite)
{
  const Points points = rowOf(3, [](int i) { return i < 1 ? not_a_number : 0.5f; });
  IntensityCompressionSettings settings = settingsAt(0.01);
  settings.bounding_box = BoundingBox{{-1.0, -1.0, 0.0}, {1.5, 1.0, 2.0}};
  const std::string warning = warningOf(settings, points);
  EXPECT_TRUE(hasPart(warning, "1 of 3 points are outside the bounding box"));
  EXPECT_TRUE(hasPart(warning, "1 of 3 points have an intensity that is not finite"));
}

TEST(FrameWarnings, SaturatedIntensitiesButForShares)
{
  const Points points = rowOf(2, [](int i) { return i == 0 ? 300.0f : 0.5f; });
  IntensityCompressionSettings settings = settingsAt(0.01);
  settings.intensity_range = 255.0f;
  const char* const words = "1 of 2 voxels have an intensity beyond the scale";
  EXPECT_TRUE(hasPart(warningOf(settings, points), words));
  settings.format = StreamFormat::Published;
  EXPECT_TRUE(hasPart(warningOf(settings, points), words));
  EXPECT_TRUE(hasPart(warningOf(settings, points), "set aggregation to the mean"));
  settings.aggregation = Aggregation::Mean;
  EXPECT_TRUE(hasPart(warningOf(settings, points), words));
  EXPECT_FALSE(hasPart(warningOf(settings, points), "aggregation"));
  EXPECT_EQ(warningOf(settingsAt(0.01), IntensityUnit::Share, viewOf(points)), "");
}

TEST(FrameWarnings, FewIntensitiesBeyondAnAutomaticScale)
{
  Points points = rowOf(1000, [](int i) { return static_cast<float>(i % 200); });
  const IntensityCompressionSettings settings = settingsAt(0.01);
  EXPECT_EQ(warningOf(settings, points), "");
  points.back()[3] = -9999.0f;
  EXPECT_TRUE(hasPart(
      warningOf(settings, points),
      "1 of 1000 voxels have an intensity beyond the scale and were set to its end: "
      "they are few, and far from the others or above what their exact step holds; "
      "remove lost returns, or hold all with an intensity_range above 0 that none of "
      "them exceeds"));
}

TEST(FrameWarnings, IntensitiesThatVanish)
{
  Points points = rowOf(10, [](int i) { return 0.04f * static_cast<float>(i); });
  IntensityCompressionSettings settings = settingsAt(0.01);
  EXPECT_EQ(warningOf(settings, points), "");
  settings.format = StreamFormat::Published;
  EXPECT_TRUE(hasPart(warningOf(settings, points),
                      "9 of 10 voxels have an intensity of less than half a step"));
  points[5][3] = 1e9f;
  EXPECT_TRUE(hasPart(warningOf(settingsAt(0.01), points),
                      "8 of 10 voxels have an intensity of less than half a step"));
}

TEST(FrameWarnings, CountsThatVanish)
{
  // Some voxels have far more points than the others.
  Points points = rowOf(63, [](int i) { return i < 60 ? 1.0f : 300000.0f; });
  IntensityCompressionSettings settings = settingsAt(0.01);
  const auto warning = [&] {
    return warningOf(settings, IntensityUnit::Points, viewOf(points));
  };
  EXPECT_TRUE(hasPart(
      warning(),
      "60 of 63 voxels have an intensity of less than half a step of the scale, which "
      "became 0: set intensity_range to what most of them have"));
  points = rowOf(63, [](int i) { return i < 60 ? 1.0f : 300.0f; });
  EXPECT_EQ(warning(), "");
  settings.intensity_bits = 4;
  settings.intensity_range = 300.0f;
  EXPECT_TRUE(
      hasPart(warning(),
              "which became 0: use a smaller intensity_range or more intensity_bits"));
}

TEST(FrameWarnings, IntensitiesThatVanishByARangeThatIsTooLarge)
{
  // A tenth of them; on an automatic scale that is not told.
  const Points points = rowOf(100, [](int i) { return i < 10 ? 0.001f : 0.9f; });
  for (const auto& [unit, remedy] :
       {std::pair(IntensityUnit::Points, "use a smaller intensity_range or more"),
        std::pair(IntensityUnit::Share,
                  "set intensity_range to 1, which is a whole")}) {
    IntensityCompressionSettings settings = settingsAt(0.01);
    settings.intensity_bits = 8;
    EXPECT_EQ(warningOf(settings, unit, viewOf(points)), "");
    settings.intensity_range = 2.0f;
    EXPECT_TRUE(hasPart(warningOf(settings, unit, viewOf(points)),
                        "10 of 100 voxels have an intensity of less than half a step "
                        "of the scale, which became 0: " +
                            std::string(remedy)));
  }
}

TEST(FrameWarnings, IntensitiesOfScansAreThoseOfPoints)
{
  FrameStatistics statistics;
  statistics.voxelization.voxels = 10;
  statistics.voxelization.intensities_out_of_range = 2;
  statistics.voxelization.intensities_vanished = 8;
  for (const bool has_points : {true, false}) {
    statistics.coding.has_points = has_points;
    const std::string text =
        frameWarning(
            statistics, IntensityCompressionSettings(), IntensityUnit::Native, {})
            .withIds();
    const std::string what = has_points ? " of 10 points have an intensity "
                                        : " of 10 voxels have an intensity ";
    EXPECT_TRUE(hasPart(text, '2' + what + "beyond"));
    EXPECT_TRUE(hasPart(text, '8' + what + "of less"));
  }
}

TEST(FrameWarnings, ColoursInThePublishedLayout)
{
  const Points points = rowOf(2, [](int) { return 3.0f; });
  PointView view = viewOf(points);
  view.colours = points.data();
  view.colour_stride = sizeof(points.front());
  IntensityCompressionSettings settings = settingsAt(0.01);
  EXPECT_EQ(warningOf(settings, IntensityUnit::Native, view), "");
  settings.format = StreamFormat::Published;
  EXPECT_TRUE(hasPart(warningOf(settings, IntensityUnit::Native, view),
                      "2 of 2 points have a colour"));
  settings.colour_bits = 0;
  EXPECT_EQ(warningOf(settings, IntensityUnit::Native, view), "");
}

TEST(FrameWarnings, FramesThatDecodersOfTheSameSettingsRefuse)
{
  const DecoderLimits limits;
  FrameStatistics statistics;
  LimitedCounts counts;
  IntensityCompressionSettings settings;
  const auto warning = [&] {
    const std::string text =
        frameWarning(statistics, settings, IntensityUnit::None, {}, counts).withIds();
    EXPECT_EQ(exceedsLimits(statistics, settings, counts), !text.empty());
    return text;
  };
  statistics.coding.voxels = limits.free_voxels;
  statistics.coding.bytes = limits.max_frame_bytes;
  statistics.voxelization.points_used = (1u << 24) + 1;
  EXPECT_EQ(warning(), "");
  settings.keep_points = true;
  EXPECT_TRUE(hasPart(warning(), "decoder_limits.max_points of at least 16777217"));
  counts.bytes_since_i_frame = (1u << 16) + 1;
  EXPECT_EQ(warning(), "");

  statistics.coding.voxels = limits.free_voxels + 1;
  ++statistics.coding.bytes;
  EXPECT_TRUE(hasPart(
      warning(), "free_voxels of at least 8388609; that of the settings is 8388608; "));
  EXPECT_TRUE(hasPart(warning(), "max_frame_bytes of at least 268435457"));
  --statistics.coding.bytes;
  counts.bytes_since_i_frame = limits.free_voxels / 64 + 1;
  EXPECT_EQ(warning(), "");
  counts.blocks = 8 * counts.bytes_since_i_frame + 1;
  EXPECT_TRUE(hasPart(warning(), "free_voxels of at least "));
  settings.decoder_limits.max_voxels = statistics.coding.voxels - 1;
  EXPECT_TRUE(hasPart(warning(), "max_voxels of at least "));
}

} // namespace
