// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/intensity/intensity_law.h>

#include <optional>
#include <string>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief What outliers of a stream are judged by, unless a unit is named.
 * \param[in] first frame of the stream
 * \param[in] law of its intensities; none: it is unknown
 * \param[in] is_of_lidar whether it is known to be a lidar's
 * \param[in] automatic the settings that are common to the units
 */
PCL_EXT_CODEC_EXPORT DensityUnitSettings
automaticUnitOf(const io::VoxelFrame& first,
                const std::optional<IntensityLaw>& law,
                bool is_of_lidar,
                const AutomaticUnit& automatic = AutomaticUnit());

/** \brief Why intensities of a law are not those that a unit compares, and what to
 * choose, after "unit is faces and law is "; empty if they are. */
PCL_EXT_CODEC_EXPORT std::string
unitFault(DensityUnit unit, IntensityLaw law);

} // namespace pcl_ext::PCL_EXT_ABI
