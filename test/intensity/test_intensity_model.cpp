// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/intensity/intensity_model.h>

#include "support/float_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace {

using pcl_ext::AzureKinectNfovUnbinned;
using pcl_ext::CountIntensity;
using pcl_ext::CountLaw;
using pcl_ext::IntensityModel;
using pcl_ext::IntensityUnit;
using pcl_ext::KinectV1;
using pcl_ext::KinectV2;
using pcl_ext::LinearLaw;
using pcl_ext::NativeIntensity;
using pcl_ext::NativeLaw;
using pcl_ext::pixelFootprint;
using pcl_ext::QuadraticLaw;
using pcl_ext::RuntimeSensor;
using pcl_ext::UnspecifiedSensor;
using pcl_ext::test::infinity;
using pcl_ext::test::not_a_number;

// What a model promises at compile time, so that generic code can branch on it.
static_assert(IntensityModel<KinectV2, CountLaw>::unit == IntensityUnit::Points, "");
static_assert(IntensityModel<KinectV2, QuadraticLaw>::unit == IntensityUnit::Share, "");
static_assert(IntensityModel<KinectV2, LinearLaw>::unit == IntensityUnit::Share, "");
static_assert(NativeIntensity::unit == IntensityUnit::Native, "");
static_assert(!CountIntensity::uses_depth && !CountIntensity::uses_native, "");
static_assert(!NativeIntensity::uses_depth && NativeIntensity::uses_native, "");
static_assert(IntensityModel<KinectV1, LinearLaw>::uses_depth, "");
static_assert(!IntensityModel<KinectV1, LinearLaw>::uses_native, "");
static_assert(IntensityModel<KinectV1, QuadraticLaw>::uses_depth, "");
static_assert(!IntensityModel<KinectV1, QuadraticLaw>::uses_native, "");
static_assert(std::is_same<NativeIntensity::Law, NativeLaw>::value, "");
static_assert(std::is_same<CountIntensity::Sensor, UnspecifiedSensor>::value, "");
// A resolution must not turn into a model unasked.
static_assert(!std::is_convertible<double, CountIntensity>::value, "");
static_assert(std::is_constructible<CountIntensity, double>::value, "");
// A sensor without figures of its own cannot be left out.
static_assert(
    !std::is_constructible<IntensityModel<RuntimeSensor, LinearLaw>, double>::value,
    "");

/** \brief c = 4 tan(FOV_x / 2) tan(FOV_y / 2) / (W H), the paper's formula, in more
 * digits than the library has. */
long double
paperFootprint(long double fov_x_deg,
               long double fov_y_deg,
               long double columns,
               long double rows)
{
  const long double pi = std::acos(-1.0L);
  return 4.0L * std::tan(fov_x_deg / 2.0L * pi / 180.0L) *
         std::tan(fov_y_deg / 2.0L * pi / 180.0L) / (columns * rows);
}

void
expectRelativelyNear(double value, long double expected, long double tolerance)
{
  EXPECT_LE(std::fabs(static_cast<long double>(value) / expected - 1.0L), tolerance)
      << value << " instead of " << static_cast<double>(expected);
}

std::string
messageOfRefusal(double fov_x, double fov_y, unsigned int columns, unsigned int rows)
{
  try {
    const RuntimeSensor sensor(fov_x, fov_y, columns, rows);
    ADD_FAILURE() << "accepted " << fov_x << " x " << fov_y << " degrees, " << columns
                  << " x " << rows << " pixels";
  }
  catch (const std::invalid_argument& refusal) {
    return refusal.what();
  }
  catch (...) {
    ADD_FAILURE() << "threw something else than std::invalid_argument";
  }
  return {};
}

TEST(Sensor, PixelFootprintsFollowThePapersFormulaWithTheDataSheets)
{
  EXPECT_NEAR(pixelFootprint(KinectV2()), 7.532e-6, 0.0005e-6);
  expectRelativelyNear(
      pixelFootprint(KinectV2()), paperFootprint(70.6L, 60.0L, 512.0L, 424.0L), 1e-14L);
  expectRelativelyNear(
      pixelFootprint(KinectV1()), paperFootprint(57.0L, 43.0L, 640.0L, 480.0L), 1e-14L);
  expectRelativelyNear(pixelFootprint(AzureKinectNfovUnbinned()),
                       paperFootprint(75.0L, 65.0L, 640.0L, 576.0L),
                       1e-14L);
}

TEST(Sensor, RuntimeSensorWithKinectFiguresIsTheKinect)
{
  const RuntimeSensor sensor = pcl_ext::runtimeSensor(KinectV2());
  EXPECT_EQ(sensor.fov_x_deg, 70.6);
  EXPECT_EQ(sensor.fov_y_deg, 60.0);
  EXPECT_EQ(pixelFootprint(sensor), pixelFootprint(KinectV2()));
  const IntensityModel<RuntimeSensor, QuadraticLaw> runtime(0.04, sensor);
  const IntensityModel<KinectV2, QuadraticLaw> compiled(0.04);
  EXPECT_EQ(runtime.cutOffDepth(), compiled.cutOffDepth());
  for (float depth = 0.0f; depth < 20.0f; depth += 0.37f)
    EXPECT_EQ(runtime(depth), compiled(depth)) << depth;
  EXPECT_EQ(runtime.sensor().columns, 512u);
  EXPECT_EQ(runtime.sensor().rows, 424u);
}

TEST(Sensor, RuntimeSensorRefusesWhatIsOutsideOfItsRange)
{
  EXPECT_NO_THROW(RuntimeSensor(1e-6, 1e-6, 1, 1));
  EXPECT_NO_THROW(RuntimeSensor(179.999, 179.999, 4294967295u, 4294967295u));
  for (const double bad : {0.0,
                           -1.0,
                           180.0,
                           360.0,
                           -std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::infinity(),
                           std::numeric_limits<double>::quiet_NaN()}) {
    const std::string horizontal = messageOfRefusal(bad, 60.0, 512, 424);
    EXPECT_NE(horizontal.find("field of view"), std::string::npos) << horizontal;
    EXPECT_NE(horizontal.find(std::to_string(bad)), std::string::npos) << horizontal;
    const std::string vertical = messageOfRefusal(70.6, bad, 512, 424);
    EXPECT_NE(vertical.find("field of view"), std::string::npos) << vertical;
  }
  EXPECT_NE(messageOfRefusal(70.6, 60.0, 0, 424).find("column"), std::string::npos);
  EXPECT_NE(messageOfRefusal(70.6, 60.0, 512, 0).find("row"), std::string::npos);
}

TEST(IntensityModel, KinectV2HasThePapersCutOffDepth)
{
  const IntensityModel<KinectV2, QuadraticLaw> model(0.04);
  EXPECT_NEAR(model.cutOffDepth(), 14.57, 0.005);
  expectRelativelyNear(model.cutOffDepth(),
                       0.04L / std::sqrt(paperFootprint(70.6L, 60.0L, 512.0L, 424.0L)),
                       1e-14L);
  EXPECT_EQ(model.resolution(), 0.04);
}

TEST(IntensityModel, LawsFollowTheirFormulasUpToTheCutOffDepth)
{
  for (const double resolution : {0.005, 0.01, 0.04, 0.1}) {
    const long double footprint = paperFootprint(75.0L, 65.0L, 640.0L, 576.0L);
    const auto edge = static_cast<long double>(resolution);
    const long double cut_off = edge / std::sqrt(footprint);
    const IntensityModel<AzureKinectNfovUnbinned, QuadraticLaw> quadratic(resolution);
    const IntensityModel<AzureKinectNfovUnbinned, LinearLaw> linear(resolution);
    const IntensityModel<AzureKinectNfovUnbinned, CountLaw> count(resolution);
    for (int step = 1; step < 100; ++step) {
      const auto depth = static_cast<float>(cut_off * 0.01L * step);
      const auto exact_depth = static_cast<long double>(depth);
      const long double points = edge * edge / (footprint * exact_depth * exact_depth);
      expectRelativelyNear(
          quadratic.pointsPerVoxelFace(static_cast<double>(depth)), points, 1e-12L);
      expectRelativelyNear(static_cast<double>(quadratic(depth)), 1.0L / points, 1e-6L);
      expectRelativelyNear(
          static_cast<double>(linear(depth)), exact_depth / cut_off, 1e-6L);
      EXPECT_EQ(count(depth), 1.0f);
    }
  }
}

TEST(IntensityModel, LawsOfDepthAreZeroBehindTheSensorAndOneBeyondTheCutOffDepth)
{
  const IntensityModel<KinectV2, QuadraticLaw> quadratic(0.04);
  const IntensityModel<KinectV2, LinearLaw> linear(0.04);
  const CountIntensity count(0.04);
  constexpr float most = std::numeric_limits<float>::max();
  const auto cut_off = static_cast<float>(quadratic.cutOffDepth());
  EXPECT_LT(quadratic(0.999f * cut_off), 1.0f);
  EXPECT_LT(linear(0.999f * cut_off), 1.0f);
  for (const float depth : {1.001f * cut_off, 100.0f * cut_off, most, infinity}) {
    EXPECT_EQ(quadratic(depth), 1.0f) << depth;
    EXPECT_EQ(linear(depth), 1.0f) << depth;
  }
  for (const float depth : {0.0f, -0.0f, -1e-30f, -1.0f, -most, -infinity}) {
    EXPECT_EQ(quadratic(depth), 0.0f) << depth;
    EXPECT_EQ(linear(depth), 0.0f) << depth;
    EXPECT_EQ(count(depth), 1.0f) << depth;
  }
  EXPECT_TRUE(std::isnan(quadratic(not_a_number)));
  EXPECT_TRUE(std::isnan(linear(not_a_number)));
  for (const float native : {-1.0f, 255.0f, infinity, not_a_number}) { // is not used
    EXPECT_EQ(quadratic(2.0f, native), quadratic(2.0f));
    EXPECT_EQ(linear(2.0f, native), linear(2.0f));
    EXPECT_EQ(count(not_a_number, native), 1.0f);
  }
}

TEST(IntensityModel, NativeLawKeepsAndScalesTheSensorsIntensity)
{
  const NativeIntensity as_is(0.01);
  for (const float native : {0.0f, 0.25f, 65535.0f, -3.5f, 1e30f})
    EXPECT_EQ(as_is(2.0f, native), native);
  const NativeIntensity scaled(0.01, UnspecifiedSensor(), NativeLaw{1.0f / 257.0f});
  EXPECT_FLOAT_EQ(scaled(2.0f, 65535.0f), 255.0f);
  EXPECT_EQ(as_is(2.0f), 0.0f);
  EXPECT_EQ(as_is(not_a_number, 7.5f), 7.5f);
  EXPECT_TRUE(std::isnan(as_is(1.0f, not_a_number)));
}

TEST(IntensityModel, WithoutDepthThereIsNoCutOff)
{
  EXPECT_EQ(CountIntensity(0.04).cutOffDepth(),
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(NativeIntensity(0.04).cutOffDepth(),
            std::numeric_limits<double>::infinity());
}

/** \brief A sensor of a user, by the contract alone. */
struct LineScanner {
  static constexpr double fov_x_deg = 120.0;
  static constexpr double fov_y_deg = 2.0;
  static constexpr unsigned int columns = 1080;
  static constexpr unsigned int rows = 4;
};

/** \brief A law of a user, with a parameter, that uses depth and native at once. */
struct RangeCorrectedLaw {
  static constexpr IntensityUnit unit = IntensityUnit::Native;
  static constexpr bool uses_depth = true;
  static constexpr bool uses_native = true;

  float gain = 1.0f;

  float
  operator()(float relative_depth, float native) const
  {
    return gain * native * relative_depth * relative_depth;
  }
};

TEST(IntensityModel, TakesSensorAndLawOfAUser)
{
  using Model = IntensityModel<LineScanner, RangeCorrectedLaw>;
  static_assert(Model::unit == IntensityUnit::Native, "");
  static_assert(Model::uses_depth && Model::uses_native, "");
  const Model model(0.1, LineScanner(), RangeCorrectedLaw{3.0f});
  const long double cut_off =
      0.1L / std::sqrt(paperFootprint(120.0L, 2.0L, 1080.0L, 4.0L));
  expectRelativelyNear(model.cutOffDepth(), cut_off, 1e-14L);
  const auto half_way = static_cast<float>(cut_off / 2.0L);
  EXPECT_NEAR(model(half_way, 40.0f), 30.0f, 1e-4f);
  EXPECT_EQ(model(infinity, 40.0f), 120.0f);
}

/** \brief Shows what a law that does not ask for the depth is given. */
struct RelativeDepthProbe {
  static constexpr IntensityUnit unit = IntensityUnit::Share;
  static constexpr bool uses_depth = false;
  static constexpr bool uses_native = false;

  float
  operator()(float relative_depth, float /*native*/) const
  {
    return relative_depth;
  }
};

TEST(IntensityModel, LawsThatDoNotAskForDepthGetZero)
{
  const IntensityModel<UnspecifiedSensor, RelativeDepthProbe> model(0.04);
  for (const float depth : {-5.0f, 0.0f, 3.0f, infinity, -infinity, not_a_number})
    EXPECT_EQ(model(depth), 0.0f) << depth;
}

} // namespace
