// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/fast/history.h"
#include "codec/rans/byte_table.h"
#include "codec/rans/nibble_model.h"
#include "voxels/child_masks.h"

#include <array>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

/** \brief Models of a mask of eight children: low nibble, then high nibble. The context
 * is the mask of the children that are likely. */
struct MaskModels {
  std::array<rans::NibbleModel, 16> low; ///< by the likely ones of children 0 to 3
  std::array<rans::NibbleModel, 64>
      high; ///< by the low nibble and how many others are likely
};

/** \brief Codes a mask of eight children.
 * \param[in] likely children that touch occupied ones
 */
template <class Coder>
unsigned int
codeMask(Coder& coder, MaskModels& models, unsigned int likely, unsigned int mask)
{
  const unsigned int low = coder.code(models.low[likely & 15], mask & 15);
  const unsigned int count = child_masks.count[likely >> 4];
  const unsigned int high =
      coder.code(models.high[low + 16 * (count < 3 ? count : 3)], mask >> 4);
  return low | high << 4;
}

/** \brief Models of the masks of an octree's nodes, as MaskModels, but also by which of a
 * node's neighbours at +x, +y and +z there are. */
struct NodeModels {
  std::array<rans::NibbleModel, 64>
      low; ///< by likely ones, and neighbours at +y and +z
  std::array<rans::NibbleModel, 512> high; ///< by what MaskModels has, and neighbours
};

/** \brief Codes the mask of a node's children.
 * \param[in] likely see codeMask
 * \param[in] upper neighbours: 4, 2 and 1 for those at +x, +y and +z
 * \param[in] mask not used by a decoder
 */
template <class Coder>
unsigned int
codeNode(Coder& coder,
         NodeModels& models,
         unsigned int likely,
         unsigned int upper,
         unsigned int mask)
{
  const unsigned int low =
      coder.code(models.low[(likely & 15) + 16 * (upper & 3)], mask & 15);
  const unsigned int count = child_masks.count[likely >> 4];
  const unsigned int high = coder.code(
      models.high[low + 16 * (count < 3 ? count : 3) + 64 * upper], mask >> 4);
  return low | high << 4;
}

/** \brief Models of symbols: of intensities, or of numbers of points. */
struct SymbolModels {
  std::array<rans::NibbleModel, 126> symbol; ///< by statistics of the voxel
  std::array<rans::NibbleModel, 125>
      running_symbol; ///< by running statistics; I-frames
  rans::NibbleModel escape_high;
  std::array<rans::NibbleModel, 8> escape_low; ///< by high bits
};

/** \brief All adaptive probabilities of effort fast, initially those of an I-frame. */
struct Models {
  /** \param[in] has_points beside intensities */
  explicit Models(bool has_points = false);

  /** \brief Probability that a tracked voxel is occupied, by its past; 2^16 is 1. */
  std::array<std::uint16_t, voxel_past::count> tracked_probability{};

  // New voxels in tracked blocks.
  std::array<rans::NibbleModel, 32>
      octant; ///< by activity and whether the block is empty
  std::array<rans::NibbleModel, 12> cell; ///< by numbers of near and of open cells
  MaskModels several;                     ///< masks of several octants or cells

  NodeModels node; ///< of the octree of new blocks

  SymbolModels symbols;
  std::optional<SymbolModels> points; ///< beside intensities
};

/** \brief The initial models, as at an I-frame.
 * \param[in] has_points beside intensities
 */
const Models&
firstModels(bool has_points);

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
