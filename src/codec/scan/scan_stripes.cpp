// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_stripes.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

namespace {

constexpr std::uint32_t stripes = 4;
/** \brief A stripe has one of so many columns. */
constexpr std::uint32_t period = 8;

/** \brief Indices of the points in the stripes. */
std::vector<std::uint32_t>
pointsInStripes(const ScanFrame& scan)
{
  std::vector<bool> is_chosen(scan.width);
  for (std::uint32_t column = 0; column < scan.width; ++column)
    is_chosen[column] =
        std::uint64_t{column} * stripes * period / scan.width % period == period / 2;
  std::vector<std::uint32_t> points;
  std::uint32_t row_begin = 0;
  for (std::uint32_t i = 0; i < scan.pixels.size(); ++i) {
    while (scan.pixels[i] - row_begin >= scan.width)
      row_begin += scan.width;
    if (is_chosen[scan.pixels[i] - row_begin])
      points.push_back(i);
  }
  return points;
}

/** \brief What some points have.
 * \param[in] count values of a point
 */
template <typename ValueT>
std::vector<ValueT>
valuesOf(const std::vector<std::uint32_t>& points,
         std::size_t count,
         const std::vector<ValueT>& values)
{
  std::vector<ValueT> chosen;
  if (values.empty())
    return chosen;
  chosen.reserve(points.size() * count);
  for (const std::uint32_t point : points)
    for (std::size_t i = 0; i < count; ++i)
      chosen.push_back(values[point * count + i]);
  return chosen;
}

} // namespace

ScanFrame
stripesOf(const ScanFrame& scan)
{
  const std::vector<std::uint32_t> points = pointsInStripes(scan);
  ScanFrame part;
  static_cast<ScanLayout&>(part) = scan;
  part.grid = scan.grid;
  part.pixels = valuesOf(points, 1, scan.pixels);
  part.depths = valuesOf(points, 1, scan.depths);
  part.turns = valuesOf(points, 1, scan.turns);
  auto beside = scan.beside.begin();
  for (const std::uint32_t pixel : part.pixels) {
    while (beside != scan.beside.end() && beside->pixel < pixel)
      ++beside;
    if (beside != scan.beside.end() && beside->pixel == pixel)
      part.beside.push_back(*beside);
  }
  part.intensity_scale = scan.intensity_scale;
  part.intensities = valuesOf(points, 1, scan.intensities);
  part.colour_bits = scan.colour_bits;
  part.colours = valuesOf(points, 1, scan.colours);
  for (const FrameField& field : scan.fields) {
    part.fields.push_back(field);
    part.fields.back().numbers = valuesOf(points, field.count, field.numbers);
  }
  return part;
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
