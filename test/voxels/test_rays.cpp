// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Rays of images against their formulas in floating point.
 */
#include <pcl_ext/compression/impl/point_image.h>

#include "support/image_frames.h"
#include "voxels/rays.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

TEST(Rays, OfCamerasAreThoseOfTheirFormula)
{
  PointImage image = planarImage(48, 32);
  ASSERT_TRUE(isConsistent(image));
  for (const bool has_half_steps : {false, true}) {
    image.rays.has_half_steps = has_half_steps;
    RayReader reader(image);
    for (const std::uint32_t row : {0u, 17u, 31u})
      for (const std::uint32_t column : {0u, 30u, 47u}) {
        reader.moveTo(row);
        const Ray ray = reader.at(column);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const auto& plane = image.rays.pose.vectors;
          const double step =
              std::ldexp(double(plane[0][axis]) + double(plane[1][axis]) * column +
                             double(plane[2][axis]) * row,
                         -40);
          const double start = std::ldexp(double(image.rays.pose.origin[axis]), -16) +
                               (has_half_steps ? step / 2 : 0.0);
          EXPECT_NEAR(std::ldexp(double(ray.at(0, axis)), -32), start, 1e-8);
          EXPECT_NEAR(
              std::ldexp(double(ray.at(1000, axis)), -32), start + 1000 * step, 1e-6);
        }
      }
  }
}

TEST(Rays, OfSpinningSensorsAreThoseOfTheirFormula)
{
  const PointImage image = spinningImage(100, 16, 9);
  ASSERT_TRUE(isConsistent(image));
  RayReader reader(image);
  const auto number = [](std::int64_t units, int bits) {
    return std::ldexp(double(units), -bits);
  };
  for (const std::uint32_t row : {0u, 1u, 15u})
    for (const std::uint32_t column : {0u, 1u, 63u, 64u, 99u}) {
      const RayRow& numbers = image.rays.rows[row];
      const double angle = 2.0 * M_PI * column / 128 +
                           std::atan2(double(numbers.sine), double(numbers.cosine));
      const double run = (1000 + 0.5) * number(numbers.run, 24);
      const Eigen::Vector3d in_sensor(
          (number(numbers.along, 16) + run) * std::cos(angle) -
              number(numbers.across, 16) * std::sin(angle),
          (number(numbers.along, 16) + run) * std::sin(angle) +
              number(numbers.across, 16) * std::cos(angle),
          number(numbers.up, 16) + (1000 + 0.5) * number(numbers.rise, 24));
      reader.moveTo(row);
      const Ray ray = reader.at(column);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double expected = number(image.rays.pose.origin[axis], 16);
        for (std::size_t i = 0; i < 3; ++i)
          expected += number(image.rays.pose.vectors[i][axis], 30) *
                      in_sensor[static_cast<Eigen::Index>(i)];
        EXPECT_NEAR(number(ray.at(1000, axis), 32), expected, 1e-4);
      }
    }
}

} // namespace
