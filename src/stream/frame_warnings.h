// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/status.h>

#include "stream/cloud_voxelizer.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What of a frame DecoderLimits limit, beside its voxels, points and bytes. */
struct LimitedCounts {
  std::size_t blocks = 0;                ///< at most so many
  std::size_t field_values = 0;          ///< of all fields
  std::uint64_t bytes_since_i_frame = 0; ///< payloads, see frameLimits()
};

/** \brief Whether decoders with the limits of the settings refuse a frame.
 * \param[in] statistics of the frame
 * \param[in] settings of its encoder
 * \param[in] counts of the frame
 */
bool
exceedsLimits(const FrameStatistics& statistics,
              const EncoderSettings& settings,
              const LimitedCounts& counts);

/** \brief What of a cloud is not in its frame, or changed, each with its number; empty
 * if nothing is. Points that are not finite are not mentioned: organised clouds have
 * them where there is no measurement.
 * \param[in] statistics of the frame
 * \param[in] settings of its encoder
 * \param[in] unit unit of the point intensities
 * \param[in] fit of its voxels
 * \param[in] counts of the frame
 * \param[in] fields_left_out see FieldCollector::leftOut()
 */
SettingText
frameWarning(const FrameStatistics& statistics,
             const EncoderSettings& settings,
             IntensityUnit unit,
             const VoxelFit& fit,
             const LimitedCounts& counts = LimitedCounts(),
             const std::string& fields_left_out = std::string());

} // namespace pcl_ext::PCL_EXT_ABI::io
