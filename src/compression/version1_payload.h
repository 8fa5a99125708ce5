#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/compression_status.h>

#include "occupancy_tree.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Appends which voxels are occupied: the octree's occupancy bytes level by
 * level, XOR-ed with the reference's where that is smaller (doc/bitstream.md,
 * "Occupancy").
 * \param[in] tree octree of the frame, not empty
 * \param[in] reference octree of the frame that this one depends on, of the same depth;
 * null for an I-frame
 * \param[in,out] payload where to append
 */
void
encodeOccupancy(const OccupancyTree& tree,
                const OccupancyTree* reference,
                std::vector<std::uint8_t>& payload);

/** \brief Reads back what encodeOccupancy wrote.
 * \param[in] begin first byte
 * \param[in] end end of these bytes, all of which must be used
 * \param[in] voxel_count from the frame header, checked against the limits
 * \param[in] limits what decoding may cost
 * \param[in] reference as for encodeOccupancy
 * \param[in,out] tree octree of a depth and without nodes; is filled
 * \param[out] keys Morton keys of the voxels
 * \return Ok; LimitExceeded; Corrupt if the bytes are not an octree of that many voxels
 */
CompressionStatus
decodeOccupancy(const std::uint8_t* begin,
                const std::uint8_t* end,
                std::size_t voxel_count,
                const DecoderLimits& limits,
                const OccupancyTree* reference,
                OccupancyTree& tree,
                std::vector<std::uint64_t>& keys);

/** \brief Appends the intensity symbols in the order of the keys (doc/bitstream.md,
 * "Intensities").
 * \param[in] intensities symbols, below 2^bits
 * \param[in] bits 1..16
 * \param[in,out] payload where to append
 */
void
encodeIntensities(const std::vector<std::uint16_t>& intensities,
                  unsigned int bits,
                  std::vector<std::uint8_t>& payload);

/** \brief Reads back what encodeIntensities wrote.
 * \param[in] begin first byte
 * \param[in] end end of these bytes, all of which must be used
 * \param[in] voxel_count number of symbols
 * \param[in] bits 1..16
 * \param[out] intensities the symbols
 * \return Ok, or Corrupt if the bytes are not that many symbols of that many bits
 */
CompressionStatus
decodeIntensities(const std::uint8_t* begin,
                  const std::uint8_t* end,
                  std::size_t voxel_count,
                  unsigned int bits,
                  std::vector<std::uint16_t>& intensities);

} // namespace io
} // namespace pcl_ext
