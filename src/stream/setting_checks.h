// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/status.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <sstream>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Message of a setting that is not allowed.
 * \param[in] id of the setting
 * \param[in] demand what it must be; settings that it names are in braces
 */
template <typename ValueT>
SettingText
invalidText(const std::string& id, const ValueT& value, const std::string& demand)
{
  std::ostringstream text;
  text << value;
  return {'{' + id + "} is " + SettingText::of(text.str()).marked + "; it must be " +
          demand};
}

/** \brief What is wrong with the corners of a box; nothing if nothing is. */
inline std::optional<SettingText>
boxFault(const char* id, const BoundingBox& box)
{
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!std::isfinite(box.min[axis]) || !std::isfinite(box.max[axis]) ||
        !(box.min[axis] < box.max[axis]))
      return invalidText(id,
                         std::to_string(box.min[axis]) + " to " +
                             std::to_string(box.max[axis]),
                         "finite, with min below max on each axis");
  return std::nullopt;
}

/** \brief Why clouds of a law that counts points cannot have an order or a mean, if
 * that is asked for. */
inline std::optional<SettingText>
lawFault(const EncoderSettings& settings, IntensityLaw law)
{
  if (law == IntensityLaw::Native || law == IntensityLaw::None)
    return std::nullopt;
  if (settings.keep_order)
    return invalidText("law",
                       nameOf(law),
                       "native or none with {keep_order}, as points in order have no "
                       "counts or shares of voxels");
  if (settings.aggregation == Aggregation::Mean)
    return invalidText("aggregation",
                       "mean",
                       "sum or automatic with {law} " + nameOf(law) +
                           ", whose intensities are sums over the points of a voxel");
  return std::nullopt;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
