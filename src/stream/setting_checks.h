// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>

namespace pcl_ext {
namespace io {

/** \brief Message of a setting that is out of range. */
template <typename ValueT>
std::string
invalidMessage(const std::string& name, const ValueT& value, const std::string& demand)
{
  std::ostringstream message;
  message << name << " is " << value << "; it must be " << demand;
  return message.str();
}

/** \brief What is wrong with the corners of a box; empty if nothing is. */
inline std::string
boxFault(const char* name, const BoundingBox& box)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(box.min[axis]) || !std::isfinite(box.max[axis]) ||
        !(box.min[axis] < box.max[axis]))
      return invalidMessage(name,
                            std::to_string(box.min[axis]) + " to " +
                                std::to_string(box.max[axis]),
                            "finite, with min below max on each axis");
  return {};
}

} // namespace io
} // namespace pcl_ext
