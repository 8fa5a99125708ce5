// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/fast/models.h"

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

Models::Models(bool has_points)
{
  if (has_points)
    points.emplace();
  for (unsigned int past = 1; past < voxel_past::count; ++past)
    tracked_probability[past] =
        static_cast<std::uint16_t>(voxel_past::firstProbability(past));
}

const Models&
firstModels(bool has_points)
{
  static const Models models;
  // Made when it is first used.
  if (!has_points)
    return models;
  static const Models models_with_points(true);
  return models_with_points;
}

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
