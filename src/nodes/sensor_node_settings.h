#pragma once

#include <pcl_ext/nodes/sensor_node.h>

namespace pcl_ext {
namespace nodes {

/** \brief The settings of the codec, with what follows from the node's. */
io::IntensityCompressionSettings
codecSettings(const SensorNodeSettings& settings);

/** \brief The settings of the outlier removal, which is set, with what the law tells of its
 * unit: frames of the published layout have no depth model that would. */
VoxelOutlierRemovalSettings
removalSettings(const SensorNodeSettings& settings);

/** \brief Tells whether all settings are within their ranges and none contradicts another;
 * if not, which one. */
SensorNodeStatus
checkSettings(const SensorNodeSettings& settings);

} // namespace nodes
} // namespace pcl_ext
