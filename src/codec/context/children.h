// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/context/models.h"
#include "codec/context/node_blocks.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Models of the children of octree nodes (doc/bitstream_context.md,
 * "Children"). */
struct ChildModels {
  using Child = DecisionModel<5, 2>;

  explicit ChildModels(bool is_small)
  : child(is_small, 5, {64 * 256, 7 * 4 * 9 * 2, 64 * 8 * 3, 64 * 16 * 8, 256}, 7)
  {}

  Child child; ///< a child has new voxels
};

/** \brief A node whose children are coded. */
struct ParentNode {
  unsigned int candidates = 0xff; ///< children that may have new voxels, a mask, not 0
  unsigned int target = 0;        ///< encoder only: those that have
};

/** \brief How many of the three nodes of NodeSurroundings::outside are present and
 * pending: 4 times the first number plus the second. */
constexpr std::array<std::uint8_t, 64>
makeStateCounts()
{
  std::array<std::uint8_t, 64> counts{};
  for (unsigned int states = 0; states < 64; ++states)
    for (unsigned int node = 0; node < 3; ++node)
      if ((states >> (3 + node) & 1) != 0)
        counts[states] = static_cast<std::uint8_t>(counts[states] +
                                                   ((states >> node & 1) != 0 ? 4 : 1));
  return counts;
}

inline constexpr std::array<std::uint8_t, 64> state_counts = makeStateCounts();

/** \brief The siblings of each child across its faces, masks. */
inline constexpr std::array<std::uint8_t, 8> siblings_beside = [] {
  std::array<std::uint8_t, 8> masks{};
  for (unsigned int child = 0; child < 8; ++child)
    masks[child] = static_cast<std::uint8_t>(1u << (child ^ 4) | 1u << (child ^ 2) |
                                             1u << (child ^ 1));
  return masks;
}();

/** \brief Which of the siblings of a child across its faces are present: 4 x + 2 y + z.
 * \param[in] nodes siblings that are present, a mask
 */
constexpr std::uint32_t
adjacentSiblings(unsigned int nodes, unsigned int child)
{
  return (nodes >> (child ^ 4) & 1) << 2 | (nodes >> (child ^ 2) & 1) << 1 |
         (nodes >> (child ^ 1) & 1);
}

/** \brief Codes which children of a node, at least one, have new voxels.
 * \param[in] parent the node
 * \param[in] around what is around its children
 * \return the children as a mask
 */
template <typename CodingT>
unsigned int
codeChildren(CodingT& coding,
             ChildModels& models,
             const ParentNode& parent,
             const NodeSurroundings& around)
{
  unsigned int children = 0;
  std::uint32_t found = 0;
  std::uint32_t left = child_masks.count[parent.candidates];
  for (unsigned int candidates = parent.candidates; candidates != 0;
       candidates &= candidates - 1) {
    --left;
    const unsigned int child = lowestBit(candidates);
    const bool is_implied = left == 0 && found == 0;
    if (!is_implied) {
      const unsigned int nodes = around.nodes | children;
      const auto outside =
          static_cast<std::uint32_t>(around.outside >> (8 * child) & 63);
      const unsigned int bit = candidates & (0 - candidates);
      const std::uint32_t siblings = bit | (nodes & (bit - 1));
      const std::uint32_t full = child_masks.count[nodes & siblings_beside[child]] +
                                 (state_counts[outside] >> 2);
      const std::uint32_t pending = state_counts[outside] & 3u;
      const std::uint32_t candidate_class =
          found == 0 ? 7 - left : std::min(6 + found, 8u);
      ChildModels::Child::Contexts contexts;
      contexts.ways[0] = outside * 256 + siblings;
      contexts.ways[1] = ((full * 4 + pending) * 9 + candidate_class) * 2 +
                         (around.nodes >> child & 1);
      if constexpr (CodingT::is_small) {
        const auto beyond =
            static_cast<std::uint32_t>(around.beyond >> (8 * child) & 15);
        contexts.ways[2] =
            (outside * 8 + adjacentSiblings(nodes, child)) * 3 + std::min(found, 2u);
        contexts.ways[3] = (outside * 16 + beyond) * 8 + child;
        contexts.ways[4] = siblings;
      }
      contexts.weight_set = full;
      if (!coding.code(models.child, contexts, (parent.target >> child & 1) != 0))
        continue;
    }
    ++found;
    children |= 1u << child;
  }
  return children;
}

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
