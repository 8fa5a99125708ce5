// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/sensor_node.h>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief The settings of the codec that follow from those of the node. */
io::EncoderSettings
codecSettings(const SensorNodeSettings& settings);

/** \brief True if the frames have the colours of the clouds. */
bool
codesColours(const SensorNodeSettings& settings);

/** \brief Why voxels of an edge are not judged. */
SettingText
unjudgedEdge(double resolution);

/** \brief The settings of the outlier removal, which must be set, with the unit of the
 * law: frames of the published layout have no depth model to derive it from. */
VoxelOutlierRemovalSettings
removalSettings(const SensorNodeSettings& settings);

/** \brief Checks all settings against their ranges and each other.
 * \return Ok, or InvalidSettings with the setting and its value */
SensorNodeStatus
checkSettings(const SensorNodeSettings& settings);

} // namespace pcl_ext::PCL_EXT_ABI::nodes
