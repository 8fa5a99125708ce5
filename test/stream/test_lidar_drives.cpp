// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/frame_decoder.h>

#include "support/point_views.h"
#include "support/voxel_frames.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

/** \brief A lidar in a hall of 40 m x 20 m x 6 m, 1.5 m above its floor. */
struct Lidar {
  int columns = 512;                                       ///< of a turn
  bool is_row_by_row = true;                               ///< else as its lasers fire
  WorldPose pose = WorldPose::Identity();                  ///< sensor -> coordinates
  Eigen::Vector3d place = Eigen::Vector3d::Zero();         ///< in the hall, metres
  std::function<bool(int, const Eigen::Vector3d&)> keeps = ///< ring, in the sensor's
      [](int, const Eigen::Vector3d&) { return true; };    ///< coordinates
};

struct HallCloud {
  std::vector<std::array<double, 3>> points;
  std::vector<std::uint8_t> rings;

  PointView
  view() const
  {
    PointView view = io::test::viewOf(points);
    view.fields = {{{"ring", FieldType::UInt8}, rings.data(), 1}};
    return view;
  }
};

HallCloud
cloudOf(const Lidar& lidar, unsigned int seed)
{
  std::mt19937_64 random(seed);
  constexpr int rows = 32;
  std::array<HallCloud, rows> of_rows;
  HallCloud fired;
  for (int column = 0; column < lidar.columns; ++column)
    for (int row = 0; row < rows; ++row) {
      if (below(random, 10) == 0)
        continue;
      const double azimuth =
          -2.0 * M_PI * column / lidar.columns + 0.02 * std::sin(1.7 * row);
      const double elevation = 0.022 * row - 0.4 + 0.004 * std::sin(2.3 * row);
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth),
                                std::sin(elevation));
      double range = 100.0;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d wall = ray[axis] < 0.0 ? Eigen::Vector3d(-20, -10, -1.5)
                                                     : Eigen::Vector3d(20, 10, 4.5);
        if (std::abs(ray[axis]) > 1e-9)
          range = std::min(range, (wall[axis] - lidar.place[axis]) / ray[axis]);
      }
      const Eigen::Vector3d seen = (range + uniform(random, -0.005f, 0.005f)) * ray;
      if (!lidar.keeps(row, seen))
        continue;
      const Eigen::Vector3d point = lidar.pose * seen;
      HallCloud& to =
          lidar.is_row_by_row ? of_rows[static_cast<std::size_t>(row)] : fired;
      to.points.push_back({point.x(), point.y(), point.z()});
      to.rings.push_back(static_cast<std::uint8_t>(row));
    }
  for (const HallCloud& row : of_rows) {
    fired.points.insert(fired.points.end(), row.points.begin(), row.points.end());
    fired.rings.insert(fired.rings.end(), row.rings.begin(), row.rings.end());
  }
  return fired;
}

/** \brief Bytes of the clouds of a lidar as it moves; points of all of them are kept as
 * such.
 * \param[in] move of the lidar before cloud i
 * \param[in] has_rings else the field is left out
 */
std::size_t
bytesOf(Lidar lidar,
        const std::function<void(int, Lidar&)>& move,
        unsigned int i_frame_rate,
        bool has_rings = true)
{
  constexpr int clouds = 6;
  EncoderSettings settings;
  settings.resolution = 0.005;
  settings.effort = Effort::Fast;
  settings.keep_points = true;
  settings.i_frame_rate = i_frame_rate;
  CloudEncoder encoder(settings, IntensityUnit::None);
  FrameDecoder decoder;
  std::size_t sum = 0;
  for (int i = 0; i < clouds; ++i) {
    move(i, lidar);
    const HallCloud cloud = cloudOf(lidar, static_cast<unsigned int>(i));
    PointView view = cloud.view();
    if (!has_rings)
      view.fields.clear();
    Bytes bytes;
    EXPECT_TRUE(encoder.encode(view, {}, bytes).ok());
    EXPECT_TRUE(encoder.statistics().coding.has_points) << i;
    VoxelFrame back;
    EXPECT_EQ(decoded(decoder, bytes, back), CompressionCode::Ok);
    EXPECT_EQ(back.pointCount(), cloud.points.size());
    sum += bytes.size();
  }
  return sum;
}

void
stay(int, Lidar&)
{}

void
drive(int i, Lidar& lidar)
{
  lidar.place.x() = 0.5 * i;
  lidar.pose.translation() = lidar.place;
}

void
nod(int i, Lidar& lidar)
{
  lidar.pose.linear() =
      Eigen::AngleAxisd(0.2 * std::sin(0.7 * i), Eigen::Vector3d::UnitY()).matrix();
}

void
turnAtOtherSpeeds(int i, Lidar& lidar)
{
  lidar.columns = 510 + 2 * (i % 3);
}

TEST(LidarDrives, TakeNoMoreBytesWithPFramesThanWithout)
{
  for (const auto& move : {drive, nod, turnAtOtherSpeeds}) {
    const std::size_t of_i_frames = bytesOf(Lidar(), move, 1);
    EXPECT_LE(bytesOf(Lidar(), move, 50), of_i_frames + of_i_frames / 100);
  }
}

TEST(LidarDrives, FarFromTheOriginTakeHardlyMoreBytes)
{
  const std::size_t near = bytesOf(Lidar(), stay, 50);
  for (const bool is_row_by_row : {true, false}) {
    Lidar far;
    far.is_row_by_row = is_row_by_row;
    far.pose.translation() = Eigen::Vector3d(448262.12, 5411932.68, 123.4);
    EXPECT_LT(bytesOf(far, stay, 50), near + near / 10);
  }
}

TEST(LidarDrives, OfFewRowsTakeHardlyMoreBytesForTellingThem)
{
  Lidar lidar;
  lidar.is_row_by_row = false;
  lidar.keeps = [](int ring, const Eigen::Vector3d&) { return ring % 4 == 0; };
  const std::size_t untold = bytesOf(lidar, stay, 50, false);
  EXPECT_LT(bytesOf(lidar, stay, 50), untold + untold / 20);
}

TEST(LidarDrives, AsFiredMayHaveFewPointsInMostRows)
{
  // The floor around the sensor, and a part of a wall.
  Lidar lidar;
  lidar.keeps = [](int, const Eigen::Vector3d& point) {
    const double aside = std::abs(point.y());
    return (std::abs(point.x()) < 6.0 && aside < 6.0) ||
           (point.x() > 19.0 && aside < 3.0);
  };
  const std::size_t row_by_row = bytesOf(lidar, stay, 50);
  lidar.is_row_by_row = false;
  EXPECT_LT(bytesOf(lidar, stay, 50), row_by_row + row_by_row / 4);
}

} // namespace
