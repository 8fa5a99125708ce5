// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/scan_rays.h"

#include "simd/bit_operations.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

ScanRayReader::ScanRayReader(const ScanRays& rays) : rays_(rays)
{
  if (rays_.shape != RayShape::Spinning)
    return;
  setLowTurns();
  columns_.reserve(rays.columns.size());
  for (std::size_t column = 0; column < rays.columns.size(); ++column)
    columns_.push_back(columnAt(column));
}

/** \brief Sets the directions of angles that have only the lowest bits, of which all others
 * begin, so that each bit is turned by once. */
void
ScanRayReader::setLowTurns()
{
  constexpr std::size_t most_bits = 8;
  low_turns_ = {{direction_length, 0}};
  for (std::size_t bit = 0; bit < std::min(most_bits, rays_.turns.size()); ++bit)
    for (std::size_t i = 0, end = low_turns_.size(); i < end; ++i)
      low_turns_.push_back(
          sum(low_turns_[i], {rays_.turns[bit][0], rays_.turns[bit][1]}));
}

ScanRayReader::Direction
ScanRayReader::directionOf(std::int32_t steps) const
{
  const auto size =
      static_cast<std::uint32_t>(steps < 0 ? -std::int64_t{steps} : steps);
  Direction direction = low_turns_[size % low_turns_.size()];
  for (std::size_t bit = highestBit(static_cast<std::uint32_t>(low_turns_.size()));
       bit < rays_.turns.size();
       ++bit)
    if ((size >> bit & 1) != 0)
      direction = sum(direction, {rays_.turns[bit][0], rays_.turns[bit][1]});
  if (steps < 0)
    direction.sine = -direction.sine;
  return direction;
}

ScanRayReader::Column
ScanRayReader::columnAt(std::size_t index) const
{
  const auto place = static_cast<std::int64_t>(index);
  const Direction direction = directionOf(rays_.columns[index]);
  Column column;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    column.origin[axis] =
        rays_.pose.origin[axis] * (1 << 16) + rays_.motion.origin[axis] * place;
    std::array<std::int64_t, 3> axes;
    for (std::size_t i = 0; i < 3; ++i)
      axes[i] =
          rays_.pose.vectors[i][axis] + (rays_.motion.vectors[i][axis] * place >> 16);
    column.ahead[axis] = (direction.cosine * axes[0] + direction.sine * axes[1]) >> 30;
    column.left[axis] = (direction.cosine * axes[1] - direction.sine * axes[0]) >> 30;
    column.up[axis] = axes[2];
  }
  return column;
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
