#pragma once

#include <pcl_ext/compression/voxel_regions.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "bytes/byte_writer.h"

namespace pcl_ext {
namespace io {

/** \brief Writes regions, as an I-frame's header does (doc/bitstream.md, "Frame
 * header"). */
void
writeRegionTable(const VoxelRegions& regions, ByteWriter& writer);

/** \brief Writes the pose of regions that depend on it, as an I-frame's header does, and
 * that of a P-frame with another pose.
 * \param[in] has_rotation some box is in the sensor's frame
 */
void
writeRegionPose(const RegionPose& pose, bool has_rotation, ByteWriter& writer);

/** \brief Reads what writeRegionPose() wrote, unchecked: numbers with too many bits
 * become ones that no regions have. */
void
readRegionPose(ByteSource& source, RegionPose& pose);

/** \brief Reads and checks what writeRegionTable() wrote. */
CompressionStatus
readRegionTable(ByteSource& source, VoxelRegions& regions);

} // namespace io
} // namespace pcl_ext
