// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds of any layout, and settings of a SensorPreprocessor, as the bytes of an
 * input describe them.
 */
#pragma once

#include "fuzz_input.h"

#include <pcl/PCLPointCloud2.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::fuzz {

/** \brief The pose as numbers that a product does not round: where the sensor's axes
 * lie in the world, by axis and sign, and a translation. */
struct Pose {
  std::array<std::size_t, 3> source{0, 1, 2}; ///< sensor axis of each world axis
  std::array<float, 3> sign{1.0f, 1.0f, 1.0f};
  std::array<float, 3> translation{};
};

struct PreprocessorSettings {
  Pose pose;
  std::optional<std::array<std::array<float, 3>, 2>> crop_box;
  float scale = 1.0f;
  std::string intensity_field = "intensity";
  bool reads_colours = true;
};

/** \brief A float that is small, or any. */
inline float
anyFloat(FuzzInput& input)
{
  const std::uint8_t kind = input.byte();
  if (kind < 192)
    return 0.25f * (static_cast<float>(kind) - 96.0f);
  const auto bits = input.number<std::uint32_t>();
  float number;
  std::memcpy(&number, &bits, sizeof(number));
  return number;
}

inline PreprocessorSettings
settingsOf(FuzzInput& input)
{
  PreprocessorSettings settings;
  const std::uint8_t choices = input.byte();
  if ((choices & 1) != 0) {
    constexpr std::size_t sources[6][3] = {
        {0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const std::uint8_t rotation = input.byte();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      settings.pose.source[axis] = sources[rotation % 6][axis];
      settings.pose.sign[axis] = (rotation >> (5 + axis) & 1) != 0 ? -1.0f : 1.0f;
      settings.pose.translation[axis] = anyFloat(input);
    }
  }
  if ((choices & 2) != 0) {
    settings.crop_box.emplace();
    for (std::array<float, 3>& corner : *settings.crop_box)
      for (float& number : corner)
        number = anyFloat(input);
  }
  if ((choices & 4) != 0)
    settings.scale = anyFloat(input);
  if ((choices & 8) != 0)
    settings.intensity_field = "reflectivity";
  settings.reads_colours = (choices & 16) == 0;
  return settings;
}

/** \brief Bytes of a number of a datatype; 0: there is no such datatype. 9, 10 and 11
 * are INT64, UINT64 and BOOL, which PCL names since 1.13. */
inline std::size_t
sizeOf(std::uint8_t datatype)
{
  constexpr std::size_t sizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8, 8, 8, 1};
  return datatype < std::size(sizes) ? sizes[datatype] : 0;
}

inline pcl::PCLPointCloud2
layoutOf(FuzzInput& input)
{
  pcl::PCLPointCloud2 cloud;
  cloud.header.frame_id = "sensor";
  cloud.header.stamp = 99;
  const std::uint8_t size = input.byte();
  cloud.width = size % 16;
  cloud.height = 1 + size / 16 % 4;
  if (size >= 192)
    cloud.width += input.byte(); // more than what is processed at once
  const std::uint8_t kind = input.byte();
  const auto coordinate = static_cast<std::uint8_t>(
      (kind & 1) != 0 ? pcl::PCLPointField::FLOAT64 : pcl::PCLPointField::FLOAT32);
  // In any order, each after the one before it, with gaps.
  std::array<const char*, 6> names = {
      "x", "y", "z", "intensity", "reflectivity", "ring"};
  if ((kind & 64) != 0)
    names[5] = (kind & 128) != 0 ? "rgba" : "rgb";
  if ((kind & 2) != 0)
    std::rotate(names.begin(), names.begin() + input.byte() % 6, names.end());
  if ((kind & 4) != 0)
    std::swap(names[input.byte() % 6], names[input.byte() % 6]);
  for (const char* const name : names) {
    pcl::PCLPointField field;
    field.name = name;
    field.count = 1;
    field.datatype = coordinate;
    if (field.name.size() == 1 && (kind & 192) == 128) // of several types
      field.datatype = static_cast<std::uint8_t>(1 + input.byte() % 10);
    if (field.name.size() > 1)
      field.datatype = static_cast<std::uint8_t>(
          (kind & 8) != 0 ? 1 + input.byte() % 11 : int{pcl::PCLPointField::FLOAT32});
    if ((kind & 16) != 0)
      cloud.point_step += input.byte() % 8;
    field.offset = cloud.point_step;
    cloud.point_step += static_cast<std::uint32_t>(sizeOf(field.datatype));
    cloud.fields.push_back(field);
  }
  cloud.row_step = cloud.width * cloud.point_step;
  if ((kind & 32) != 0)
    cloud.row_step += input.byte();
  cloud.data.resize(std::size_t{cloud.row_step} * cloud.height);
  return cloud;
}

/** \brief Any number; small changes are the more likely. */
inline std::uint32_t
changed(std::uint32_t number, FuzzInput& input)
{
  const std::uint8_t change = input.byte();
  if (change < 128)
    return number + change % 16u - 8u;
  return change < 192 ? change % 16u : input.number<std::uint32_t>();
}

/** \brief Changes a field of the cloud so that it may contradict the layout. */
inline void
falsify(pcl::PCLPointCloud2& cloud, FuzzInput& input)
{
  const std::uint8_t what = input.byte();
  pcl::PCLPointField spare;
  pcl::PCLPointField& field =
      cloud.fields.empty() ? spare : cloud.fields[what / 16 % cloud.fields.size()];
  switch (what % 16) {
  case 0:
    cloud.width = changed(cloud.width, input);
    break;
  case 1:
    cloud.height = changed(cloud.height, input);
    break;
  case 2:
    cloud.point_step = changed(cloud.point_step, input);
    break;
  case 3:
    cloud.row_step = changed(cloud.row_step, input);
    break;
  case 4: // no more than the input pays for
    cloud.data.resize(std::min<std::size_t>(
        changed(static_cast<std::uint32_t>(cloud.data.size()), input), 1 << 16));
    break;
  case 5:
    cloud.is_bigendian = input.byte();
    break;
  case 6:
    field.offset = changed(field.offset, input);
    break;
  case 7:
    field.count = changed(field.count, input);
    break;
  case 8:
    field.datatype = static_cast<std::uint8_t>(changed(field.datatype, input));
    break;
  case 9:
    field.name = field.name == "X" ? "" : "X";
    break;
  case 10: { // a second one of that name
    pcl::PCLPointField second = field;
    second.offset = changed(second.offset, input);
    cloud.fields.push_back(second);
    break;
  }
  case 11:
    if (!cloud.fields.empty())
      cloud.fields.pop_back();
    break;
  case 12:
    field.offset = cloud.fields.empty() ? 0 : cloud.fields.front().offset; // overlaps
    break;
  case 13:
    cloud.data.resize(cloud.data.size() -
                      std::min<std::size_t>(cloud.data.size(), input.byte()));
    break;
  default:
    break;
  }
}

/** \brief Fills the points: small numbers where a field of floats lies, so that crop
 * boxes have something to do, then what is left of the input. */
inline void
fillData(pcl::PCLPointCloud2& cloud, FuzzInput& input)
{
  const std::vector<std::uint8_t> bytes = input.rest();
  if (bytes.empty())
    return;
  if (bytes[0] < 128) {
    std::uint32_t state = bytes[0];
    for (std::size_t i = 0; i + 4 <= cloud.data.size(); i += 4) {
      state = state * 1664525u + 1013904223u;
      const float number = 0.25f * (static_cast<float>(state >> 24) - 128.0f);
      std::memcpy(&cloud.data[i], &number, sizeof(number));
    }
  }
  for (std::size_t i = 1; i < bytes.size() && i <= cloud.data.size(); ++i)
    cloud.data[i - 1] = bytes[i];
}

} // namespace pcl_ext::fuzz
