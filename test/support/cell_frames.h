// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "simulator/robot_cell.h"

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::cell::test {

inline CellFrame
capture(RobotCell& cell, unsigned int sensor, std::uint32_t frame)
{
  CellFrame captured;
  cell.capture(sensor, frame, captured);
  return captured;
}

/** \brief Same bytes in all coordinates (NaN included) and the same truth. */
template <typename FrameT>
bool
sameBytes(const FrameT& one, const FrameT& other)
{
  if (one.cloud.size() != other.cloud.size() || one.truth != other.truth)
    return false;
  for (std::size_t i = 0; i < one.cloud.size(); ++i)
    if (std::memcmp(one.cloud[i].data, other.cloud[i].data, 3 * sizeof(float)) != 0)
      return false;
  return true;
}

} // namespace pcl_ext::cell::test
