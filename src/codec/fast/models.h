#pragma once

#include "codec/fast/byte_table.h"
#include "codec/fast/history.h"
#include "codec/fast/nibble_model.h"

#include <array>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Models of a byte that is coded as its low nibble, then the high one. */
template <std::size_t contexts>
struct ByteModels {
  std::array<NibbleModel, contexts> low;
  std::array<NibbleModel, 16> high; ///< by the low nibble
};

/** \brief All adaptive probabilities of the fast coder, as they are at an I-frame. */
struct Models {
  Models();

  /** \brief Share of known voxels that are occupied, by their past; 2^16 is 1. */
  std::array<std::uint16_t, voxel_past::count> known_share{};

  // New voxels in known blocks.
  std::array<NibbleModel, 32> octant; ///< by activity and whether the block is empty
  ByteModels<1> octants;              ///< masks of several octants
  std::array<NibbleModel, 24> cell;   ///< by open cells and those with neighbours
  ByteModels<1> cells;                ///< masks of several cells

  // New blocks; the last index of each pair is 1 in an I-frame.
  BitModel has_new_blocks;
  std::array<ByteModels<1>, 4> node; ///< by the levels between children and blocks
  std::array<ByteModels<1>, 2> new_block_octants;
  std::array<ByteModels<16>, 2> new_block_cells; ///< low: by neighbours

  // Symbols.
  std::array<QuadModel, 4> quad;             ///< by the class of all four
  std::array<NibbleModel, 4> quad_escape;    ///< by the class
  std::array<NibbleModel, 125> known_symbol; ///< by mean and deviation
  /** \brief Whether voxels without a moment had low steps lately. */
  bool new_steps_are_low = false;
  /** \brief The same of a running mean; the second ones in I-frames. */
  std::array<std::array<NibbleModel, 125>, 2> new_symbol;
  NibbleModel escape_high;
  std::array<NibbleModel, 8> escape_low; ///< by the high bits
  ByteModels<1> plain;                   ///< high bits of symbols that are noise
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
