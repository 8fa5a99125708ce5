// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "codec/published/occupancy_tree.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

/** \brief Writes an octree as PCL serializes it: depth first, for each branch node its
 * occupancy byte, XOR-ed with that of the same node in the reference.
 * \param[in] tree may be empty, which is one byte 0
 * \param[in] reference tree of the previous frame, of the same depth; null for an
 * I-frame
 * \param[out] symbols the bytes
 */
void
serializeTree(const OccupancyTree& tree,
              const OccupancyTree* reference,
              std::vector<std::uint8_t>& symbols);

/** \brief Inverse of serializeTree.
 * \param[in] symbols the bytes
 * \param[in] reference as for serializeTree
 * \param[in] voxel_count number of voxels that the octree must have
 * \param[in,out] tree its depth is given by reset()
 * \param[out] keys Morton keys of the voxels, strictly ascending
 * \return false if the bytes are not an octree of that many voxels
 */
bool
deserializeTree(const std::vector<std::uint8_t>& symbols,
                const OccupancyTree* reference,
                std::size_t voxel_count,
                OccupancyTree& tree,
                std::vector<std::uint64_t>& keys);

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io
