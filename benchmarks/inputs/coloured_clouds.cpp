// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/coloured_clouds.h"

#include "simulator/random_numbers.h"

#include <pcl/conversions.h>
#include <pcl/filters/filter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief A random number of 0 to 1 for a place of a cubic lattice. */
double
shareAt(const std::array<std::int32_t, 3>& place, std::uint32_t seed)
{
  return cell::asShare(
      cell::mixSeeds(cell::mixSeeds(static_cast<std::uint32_t>(place[0]),
                                    static_cast<std::uint32_t>(place[1])),
                     static_cast<std::uint32_t>(place[2]),
                     seed));
}

std::array<double, 3>
scaled(const pcl::PointXYZ& point, double edge)
{
  return {static_cast<double>(point.x) / edge,
          static_cast<double>(point.y) / edge,
          static_cast<double>(point.z) / edge};
}

std::array<std::int32_t, 3>
floorOf(const std::array<double, 3>& position)
{
  std::array<std::int32_t, 3> place{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    place[axis] = static_cast<std::int32_t>(std::floor(position[axis]));
  return place;
}

/** \brief A smooth texture of 0 to 1: random numbers at the corners of cubes with this
 * edge, linear in between. */
double
textureAt(const pcl::PointXYZ& point, double edge, std::uint32_t seed)
{
  const std::array<double, 3> position = scaled(point, edge);
  const std::array<std::int32_t, 3> lower = floorOf(position);
  double sum = 0.0;
  for (unsigned int corner = 0; corner < 8; ++corner) {
    std::array<std::int32_t, 3> place = lower;
    double weight = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double above = position[axis] - lower[axis];
      const bool is_upper = (corner >> axis & 1) != 0;
      place[axis] += is_upper ? 1 : 0;
      weight *= is_upper ? above : 1.0 - above;
    }
    sum += weight * shareAt(place, seed);
  }
  return sum;
}

/** \brief A sum of four uniform numbers, which is nearly normal; its deviation is 1. */
double
nearlyNormal(std::uint32_t a, std::uint32_t b, std::uint32_t c)
{
  const double deviation_of_sum = std::sqrt(4.0 / 12.0);
  double sum = -2.0;
  for (std::uint32_t i = 0; i < 4; ++i)
    sum += cell::asShare(cell::mixSeeds(a, b, 4 * c + i));
  return sum / deviation_of_sum;
}

} // namespace

ColouredCloud::Ptr
paint(const PositionCloud& positions, std::uint32_t seed)
{
  constexpr double noise_deviation = 4.0;
  ColouredCloud::Ptr painted(new ColouredCloud);
  painted->reserve(positions.size());
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    const pcl::PointXYZ& point = positions[i];
    const std::array<std::int32_t, 3> patch = floorOf(scaled(point, 0.5));
    // Light and dark change in all channels alike.
    const double light =
        60.0 * textureAt(point, 0.1, 1) + 30.0 * textureAt(point, 0.02, 2) - 45.0;
    std::array<std::uint8_t, 3> channels{};
    for (std::uint32_t channel = 0; channel < 3; ++channel) {
      const double value = 50.0 + 155.0 * shareAt(patch, 3 + channel) + light +
                           noise_deviation * nearlyNormal(seed, i, channel);
      channels[channel] =
          static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    }
    pcl::PointXYZRGB coloured;
    coloured.getVector3fMap() = point.getVector3fMap();
    coloured.r = channels[0];
    coloured.g = channels[1];
    coloured.b = channels[2];
    painted->push_back(coloured);
  }
  return painted;
}

std::vector<ColouredCloud::Ptr>
readColouredFrames(const InputStream& stream)
{
  std::vector<ColouredCloud::Ptr> frames;
  pcl::PCLPointCloud2 message;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, message);
    const bool has_colours = std::any_of(
        message.fields.begin(), message.fields.end(), [](const auto& field) {
          return field.name == "rgb" || field.name == "rgba";
        });
    if (!has_colours)
      return {};
    frames.push_back(ColouredCloud::Ptr(new ColouredCloud));
    pcl::fromPCLPointCloud2(message, *frames.back());
    pcl::Indices kept;
    pcl::removeNaNFromPointCloud(*frames.back(), *frames.back(), kept);
  }
  return frames;
}

} // namespace measuring
} // namespace pcl_ext
