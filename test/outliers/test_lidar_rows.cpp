// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/filters/point_outlier_removal.h>

#include "support/lidar_room.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;
using io::FieldType;
using test::LidarRoom;
using test::LidarScan;

constexpr float not_judged = std::numeric_limits<float>::infinity();

std::vector<float>
judged(const io::PointView& points)
{
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  const OutlierRemovalStatus status = removal.score(points, log_odds);
  EXPECT_TRUE(status.ok()) << status.message();
  return log_odds;
}

LidarScan
snowyScan(double waviness = 0.0)
{
  LidarRoom room;
  room.snow = 0.05;
  room.has_person = true;
  room.waviness = waviness;
  return room.scan();
}

/** \brief Pixels that have a return, row after row, each from azimuth 0 on. */
std::vector<std::size_t>
returnsOf(const LidarScan& scan)
{
  std::vector<std::size_t> pixels;
  for (std::size_t row = 0; row < scan.height; ++row)
    for (std::size_t i = 0; i < scan.width; ++i)
      if (const std::size_t pixel =
              row * scan.width + (i + scan.width / 2) % scan.width;
          scan.ranges[pixel] > 0.0f)
        pixels.push_back(pixel);
  return pixels;
}

/** \brief A cloud without rows and columns, of pixels of a scan in any order. */
class Unorganised {
public:
  Unorganised(const LidarScan& scan, const std::vector<std::size_t>& pixels)
  {
    for (const std::size_t pixel : pixels)
      add(&scan.coordinates[3 * pixel]);
  }

  void
  add(const float* point)
  {
    coordinates_.insert(coordinates_.end(), point, point + 3);
  }

  std::vector<float>&
  coordinates()
  {
    return coordinates_;
  }

  template <typename NumberT>
  void
  setRings(const std::vector<int>& rings, FieldType type)
  {
    bytes_.resize(rings.size() * sizeof(NumberT));
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const auto ring = static_cast<NumberT>(rings[i]);
      std::memcpy(bytes_.data() + i * sizeof(ring), &ring, sizeof(ring));
    }
    ring_ = {{"ring", type}, nullptr, sizeof(NumberT)};
  }

  io::PointView
  view()
  {
    io::PointView points;
    points.count = coordinates_.size() / 3;
    points.coordinates = coordinates_.data();
    points.coordinate_stride = 3 * sizeof(float);
    if (ring_.stride > 0) {
      ring_.first = bytes_.data();
      points.fields = {ring_};
    }
    return points;
  }

private:
  std::vector<float> coordinates_;
  std::vector<unsigned char> bytes_;
  io::FieldView ring_;
};

std::vector<float>
at(const std::vector<float>& log_odds, const std::vector<std::size_t>& pixels)
{
  std::vector<float> chosen;
  for (const std::size_t pixel : pixels)
    chosen.push_back(log_odds[pixel]);
  return chosen;
}

/** \brief The rows of pixels. */
std::vector<int>
rowsOf(const LidarScan& scan, const std::vector<std::size_t>& pixels)
{
  std::vector<int> rows;
  for (const std::size_t pixel : pixels)
    rows.push_back(static_cast<int>(pixel / scan.width));
  return rows;
}

std::vector<std::size_t>
allPixelsOf(const LidarScan& scan)
{
  std::vector<std::size_t> pixels(scan.size());
  std::iota(pixels.begin(), pixels.end(), 0u);
  return pixels;
}

std::vector<std::size_t>
shuffled(std::vector<std::size_t> pixels)
{
  std::mt19937 generator(3);
  std::shuffle(pixels.begin(), pixels.end(), generator);
  return pixels;
}

TEST(LidarRows, RingsOfAnyTypeNumberAndOrderAreRowsOfAnImage)
{
  const LidarScan scan = snowyScan();
  const std::vector<float> expected = judged(scan.view());
  const std::vector<std::size_t> pixels = shuffled(returnsOf(scan));
  // Lasers of some sensors are not numbered from one side to the other, and some have
  // none of the numbers.
  std::vector<int> rings = rowsOf(scan, pixels);
  for (int& ring : rings)
    ring = 5 * (ring * 7 % 24) + 2;
  Unorganised cloud(scan, pixels);
  const auto expect_same = [&](auto number, FieldType type) {
    cloud.setRings<decltype(number)>(rings, type);
    EXPECT_EQ(judged(cloud.view()), at(expected, pixels)) << static_cast<int>(type);
  };
  expect_same(std::int8_t{}, FieldType::Int8);
  expect_same(std::uint8_t{}, FieldType::UInt8);
  expect_same(std::int16_t{}, FieldType::Int16);
  expect_same(std::uint16_t{}, FieldType::UInt16);
  expect_same(std::int32_t{}, FieldType::Int32);
  expect_same(std::uint32_t{}, FieldType::UInt32);
  expect_same(float{}, FieldType::Float32);
  expect_same(double{}, FieldType::Float64);
}

TEST(LidarRows, AreToldByElevationsInAnyOrderOfPoints)
{
  const LidarScan scan = snowyScan();
  const std::vector<std::size_t> pixels = shuffled(returnsOf(scan));
  Unorganised cloud(scan, pixels);
  EXPECT_EQ(judged(cloud.view()), at(judged(scan.view()), pixels));
}

TEST(LidarRows, AreToldFromPointsThatAreNotNear)
{
  const LidarScan scan = snowyScan();
  Unorganised cloud(scan, shuffled(returnsOf(scan)));
  // On the sensor's own vehicle, where lasers that are beside each other see anything.
  for (int i = 0; i < 400; ++i) {
    const float azimuth = 0.157f * static_cast<float>(i);
    const float slope = -0.25f + 0.0013f * static_cast<float>(i);
    const float point[] = {
        0.3f * std::cos(azimuth), 0.3f * std::sin(azimuth), 0.3f * slope};
    cloud.add(point);
  }
  judged(cloud.view());
}

TEST(LidarRows, AreToldByTurnsWhereSlopesOverlap)
{
  // Neighbours overlap, but a row has nearly the same slope nearly everywhere.
  const LidarScan scan = snowyScan(1.0);
  const std::vector<float> expected = judged(scan.view());
  // Rows begin ahead or behind.
  const std::vector<std::size_t> ahead = returnsOf(scan);
  std::vector<std::size_t> behind = ahead;
  std::sort(behind.begin(), behind.end());
  for (const auto& pixels : {ahead, behind}) {
    Unorganised cloud(scan, pixels);
    EXPECT_EQ(judged(cloud.view()), at(expected, pixels));
  }
  Unorganised other_order(scan, shuffled(ahead));
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  EXPECT_EQ(removal.score(other_order.view(), log_odds).code(),
            OutlierRemovalCode::NoImage);
}

TEST(LidarRows, ColumnsOfTheCloudDoNotMatter)
{
  // Rows begin anywhere, run either way, and are from the top down.
  const LidarScan scan = snowyScan();
  const std::vector<float> expected = judged(scan.view());
  std::vector<std::size_t> pixels;
  for (std::uint32_t row = scan.height; row-- > 0;)
    for (std::uint32_t i = 0; i < scan.width; ++i)
      pixels.push_back(std::size_t{row} * scan.width +
                       (17 * row + (row % 2 == 0 ? i : scan.width - i)) % scan.width);
  Unorganised cloud(scan, pixels);
  io::PointView points = cloud.view();
  points.image = {scan.width, scan.height};
  EXPECT_EQ(judged(points), at(expected, pixels));
  // Points of some of the pixels, which say where they are; in double precision.
  const std::vector<std::size_t> some = shuffled(returnsOf(scan));
  const std::vector<std::uint32_t> numbers(some.begin(), some.end());
  std::vector<double> doubles;
  for (const std::size_t pixel : some)
    for (std::size_t axis = 0; axis < 3; ++axis)
      doubles.push_back(static_cast<double>(scan.coordinates[3 * pixel + axis]));
  points = io::PointView();
  points.count = some.size();
  points.double_coordinates = doubles.data();
  points.coordinate_stride = 3 * sizeof(double);
  points.image = {scan.width, scan.height};
  points.pixels = numbers.data();
  EXPECT_EQ(judged(points), at(expected, some));
}

TEST(LidarRows, APointAboveTheSensorDoesNotMoveItsRow)
{
  LidarScan scan = snowyScan();
  const std::vector<float> expected = judged(scan.view());
  // In the place of a missing one, so that all others keep their columns.
  std::size_t pixel = std::size_t{scan.width} * 3 + 100;
  while (scan.ranges[pixel] > 0.0f)
    ++pixel;
  const std::size_t column = pixel % scan.width;
  const double azimuth = LidarRoom().azimuth(static_cast<std::uint32_t>(column));
  scan.coordinates[3 * pixel] = static_cast<float>(1e-5 * std::cos(azimuth));
  scan.coordinates[3 * pixel + 1] = static_cast<float>(1e-5 * std::sin(azimuth));
  scan.coordinates[3 * pixel + 2] = 5.0f;
  const std::vector<float> log_odds = judged(scan.view());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (i % scan.width + 4 < column || i % scan.width > column + 4) {
      EXPECT_EQ(log_odds[i], expected[i]) << i;
    }
  }
}

TEST(LidarRows, MissingPointsMayHaveAnyRing)
{
  const LidarScan scan = snowyScan();
  const std::vector<std::size_t> all = allPixelsOf(scan);
  std::vector<int> rings = rowsOf(scan, all);
  for (std::size_t i = 0; i < rings.size(); ++i)
    if (scan.ranges[i] == 0.0f)
      rings[i] = i % 2 == 0 ? -1 : 65535;
  Unorganised cloud(scan, all);
  cloud.setRings<std::int32_t>(rings, FieldType::Int32);
  EXPECT_EQ(judged(cloud.view()), judged(scan.view()));
}

TEST(LidarRows, OfTwoEchoesInOneDirectionTheNearestIsJudged)
{
  const LidarScan scan = snowyScan();
  const std::vector<float> expected = judged(scan.view());
  const std::vector<std::size_t> pixels = returnsOf(scan);
  Unorganised cloud(scan, {});
  std::vector<int> rings;
  std::vector<float> all_expected;
  for (const std::size_t pixel : pixels) {
    const float* const point = &scan.coordinates[3 * pixel];
    const auto add = [&](const float* position, float log_odds) {
      cloud.add(position);
      rings.push_back(static_cast<int>(pixel / scan.width));
      all_expected.push_back(log_odds);
    };
    // An echo from further away, before or behind it, which rounding turns to either
    // side, and drivers' second copies of a single echo.
    const float times = 1.7f;
    const float farther[] = {times * point[0], times * point[1], times * point[2]};
    if (pixel % 4 == 1)
      add(farther, not_judged);
    add(point, expected[pixel]);
    if (pixel % 4 == 2)
      add(farther, not_judged);
    if (pixel % 4 == 3)
      add(point, expected[pixel]);
  }
  cloud.setRings<std::uint16_t>(rings, FieldType::UInt16);
  EXPECT_EQ(judged(cloud.view()), all_expected);
}

TEST(LidarRows, AFirstCloudOfFewPointsDoesNotDecideForTheStream)
{
  LidarRoom room;
  room.has_person = true;
  const LidarScan scan = room.scan();
  std::vector<std::size_t> few;
  std::mt19937 generator(5);
  for (const std::size_t pixel : returnsOf(scan))
    // Of each third row, and of the uppermost one, so that rings seem to be complete.
    if ((pixel / scan.width % 3 == 0 || pixel / scan.width + 1 == scan.height) &&
        generator() % 8 == 0)
      few.push_back(pixel);
  const std::vector<std::size_t> all = returnsOf(scan);
  for (const bool has_rings : {false, true}) {
    PointOutlierRemovalSettings settings;
    settings.use_history = false;
    PointOutlierRemoval removal(settings);
    for (const auto& pixels : {few, all}) {
      Unorganised cloud(scan, pixels);
      if (has_rings)
        cloud.setRings<std::uint8_t>(rowsOf(scan, pixels), FieldType::UInt8);
      std::vector<float> log_odds;
      ASSERT_TRUE(removal.score(cloud.view(), log_odds).ok());
      if (pixels.size() == all.size()) {
        EXPECT_EQ(log_odds, at(judged(scan.view()), all)) << has_rings;
      }
    }
  }
}

void
expectNoImage(const io::PointView& points, const std::string& what)
{
  PointOutlierRemoval removal;
  std::vector<float> log_odds = {1.0f};
  const OutlierRemovalStatus status = removal.score(points, log_odds);
  EXPECT_EQ(status.code(), OutlierRemovalCode::NoImage) << what;
  EXPECT_EQ(
      status.message(),
      "no point was judged: neither rows and columns, nor a field 'ring', nor the "
      "directions of the points tell the rows of a lidar that turns around z; "
      "points must be in the sensor's coordinates");
  EXPECT_EQ(status.removed, 0u);
  EXPECT_EQ(log_odds, std::vector<float>(points.count, not_judged)) << what;
}

TEST(LidarRows, CamerasHaveNone)
{
  // Degrees across and down: of depth cameras, held upright and not, and a wide one.
  for (const auto& [across, down] : std::vector<std::pair<double, double>>{
           {70, 60}, {87, 58}, {58, 87}, {40, 110}, {110, 40}, {75, 65}}) {
    constexpr std::uint32_t width = 160;
    constexpr std::uint32_t height = 120;
    for (const bool is_optical : {true, false}) { // or of the body
      LidarScan scan;
      scan.width = width;
      scan.height = height;
      scan.ranges.resize(std::size_t{width} * height);
      for (std::uint32_t v = 0; v < height; ++v)
        for (std::uint32_t u = 0; u < width; ++u) {
          const double x =
              std::tan(across * M_PI / 360.0) * (2.0 * (u + 0.5) / width - 1.0);
          const double y =
              std::tan(down * M_PI / 360.0) * (2.0 * (v + 0.5) / height - 1.0);
          const double depth = 2.0 + 0.3 * x + (u > 80 ? 0.5 : 0.0);
          for (const double number :
               {is_optical ? x : 1.0, is_optical ? y : -x, is_optical ? 1.0 : -y})
            scan.coordinates.push_back(static_cast<float>(depth * number));
        }
      const std::string name = std::to_string(across) + " x " + std::to_string(down);
      expectNoImage(scan.view(), name);
      io::PointView points = scan.view();
      points.image = {};
      expectNoImage(points, name + " unorganised");
    }
  }
}

TEST(LidarRows, AreLookedForInEachSixteenthCloudWhereThereWereNone)
{
  const LidarScan scan = snowyScan();
  PointOutlierRemoval removal;
  std::vector<float> log_odds;
  const auto is_judged = [&](const io::PointView& points) {
    return removal.score(points, log_odds).ok();
  };
  std::mt19937 generator(3);
  std::vector<float> anywhere(3000);
  for (float& number : anywhere)
    number = 0.01f * static_cast<float>(generator() % 2000) - 10.0f;
  io::PointView without_rows;
  without_rows.count = anywhere.size() / 3;
  without_rows.coordinates = anywhere.data();
  without_rows.coordinate_stride = 3 * sizeof(float);
  // Clouds of hardly any points are none of the three, however many.
  io::PointView nearly_empty = without_rows;
  nearly_empty.count = 999;
  for (int i = 0; i < 9; ++i)
    EXPECT_FALSE(is_judged(nearly_empty));
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(is_judged(without_rows));
    EXPECT_TRUE(i == 2 || is_judged(scan.view()));
  }
  for (int i = 0; i < 2; ++i)
    EXPECT_FALSE(is_judged(without_rows));
  for (int i = 0; i < 15; ++i) {
    EXPECT_FALSE(is_judged(scan.view()));
    EXPECT_EQ(log_odds, std::vector<float>(scan.size(), not_judged));
  }
  EXPECT_TRUE(is_judged(scan.view()));
  EXPECT_TRUE(is_judged(scan.view()));
}

TEST(LidarRows, CloudsWithoutPointsHaveNone)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const float number : {nan, not_judged, 0.0f, 1e30f, 1e-40f}) {
    LidarScan scan;
    scan.width = 64;
    scan.height = 8;
    scan.coordinates.assign(std::size_t{64} * 8 * 3, number);
    scan.ranges.assign(std::size_t{64} * 8, 0.0f);
    io::PointView points = scan.view();
    expectNoImage(points, std::to_string(number));
    points.image = {};
    expectNoImage(points, "unorganised " + std::to_string(number));
    const std::vector<std::size_t> all = allPixelsOf(scan);
    Unorganised cloud(scan, all);
    cloud.setRings<std::uint8_t>(rowsOf(scan, all), FieldType::UInt8);
    expectNoImage(cloud.view(), "rings " + std::to_string(number));
  }
  const LidarScan scan = snowyScan();
  const std::vector<std::size_t> pixels = returnsOf(scan);
  for (const std::size_t count : {0u, 1u, 2u, 100u}) {
    Unorganised cloud(scan, {pixels.begin(), pixels.begin() + count});
    expectNoImage(cloud.view(), std::to_string(count));
    std::vector<int> rings(count, 3);
    cloud.setRings<std::uint8_t>(rings, FieldType::UInt8);
    expectNoImage(cloud.view(), "one ring " + std::to_string(count));
  }
}

TEST(LidarRows, RowsThatNoLidarHasAreToldByDirections)
{
  const LidarScan scan = snowyScan();
  const std::vector<std::size_t> pixels = returnsOf(scan);
  Unorganised cloud(scan, pixels);
  const std::vector<float> expected = judged(cloud.view());
  const auto expect_as_without = [&](const io::PointView& points,
                                     const std::string& what) {
    EXPECT_EQ(judged(points), expected) << what;
  };
  std::vector<int> rings = rowsOf(scan, pixels);
  for (const int ring : {-1, 1024, 65536, 1000000000}) {
    rings[7] = ring;
    cloud.setRings<std::int32_t>(rings, FieldType::Int32);
    expect_as_without(cloud.view(), std::to_string(ring));
  }
  std::vector<double> halves(rings.begin(), rings.end());
  halves[7] = 3.5;
  cloud.setRings<double>(rings, FieldType::Float64);
  io::PointView points = cloud.view();
  points.fields[0].first = halves.data();
  expect_as_without(points, "half a ring");
  // Images whose size is not that of the cloud.
  points = scan.view();
  points.image = {scan.width, scan.height + 1};
  EXPECT_EQ(judged(points), judged(scan.view())) << "a row more";
  points = scan.view();
  std::vector<std::uint32_t> numbers(scan.size());
  std::iota(numbers.begin(), numbers.end(), scan.width);
  points.pixels = numbers.data();
  EXPECT_EQ(judged(points), judged(scan.view())) << "pixels beyond the image";
  // Rings of other points, and columns that are called rows.
  std::mt19937 generator(7);
  for (int& ring : rings)
    ring = static_cast<int>(generator() % scan.height);
  cloud.setRings<std::int32_t>(rings, FieldType::Int32);
  expect_as_without(cloud.view(), "rings of others");
  LidarScan turned = scan;
  std::swap(turned.width, turned.height);
  std::vector<float> turned_expected(scan.size());
  const std::vector<float> all_expected = judged(scan.view());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::size_t pixel = i % scan.width * scan.height + i / scan.width;
    std::copy_n(&scan.coordinates[3 * i], 3, &turned.coordinates[3 * pixel]);
    turned_expected[pixel] = all_expected[i];
  }
  EXPECT_EQ(judged(turned.view()), turned_expected);
  // Many rows of few columns would need an image much larger than the cloud.
  LidarScan tall;
  tall.width = 16;
  tall.height = 2000;
  tall.ranges.resize(std::size_t{16} * 2000);
  for (std::uint32_t row = 0; row < tall.height; ++row)
    for (std::uint32_t column = 0; column < tall.width; ++column) {
      const double azimuth = column * M_PI / 8.0 + (column % 2 == 0 ? 0.0 : -0.39);
      for (const double number :
           {std::cos(azimuth), std::sin(azimuth), row / 2000.0 - 0.5})
        tall.coordinates.push_back(static_cast<float>(number));
    }
  expectNoImage(tall.view(), "2000 rows");
}

} // namespace
