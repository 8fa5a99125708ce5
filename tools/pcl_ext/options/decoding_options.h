// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <CLI/App.hpp>

#include <array>
#include <optional>
#include <string>

namespace pcl_ext::tools {

struct DecodingOptions {
  io::DecoderLimits limits; ///< of all decoders, with the memory that they share
  std::optional<float> min_intensity; ///< voxels below are left out
  bool removes_outliers = false;
  DensityUnit unit = DensityUnit::Automatic;
  /** \brief Of the lidar, world coordinates, metres; none: that of the stream's pose. */
  std::optional<std::array<double, 3>> sensor_position;
};

/** \brief Adds what is done with decoded voxels. */
void
addDecodingOptions(CLI::App& app, DecodingOptions& options);

/** \brief Remark on a stream for which min_intensity has no effect. */
inline std::string
remarkWithoutIntensities(const std::string& stream)
{
  return stream +
         ": its voxels have no intensities, so that --min-intensity leaves none "
         "out";
}

/** \brief Adds --max-voxels and --memory-limit.
 * \param[in,out] limits changed by the options
 */
void
addLimits(CLI::App& app, io::DecoderLimits& limits);

} // namespace pcl_ext::tools
