#pragma once

#include "fast_history.h"
#include "nibble_model.h"

#include <array>

namespace pcl_ext {
namespace io {

/** \brief Models of a byte that is coded as its low nibble, then the high one. */
template <std::size_t contexts>
struct ByteModels {
  std::array<NibbleModel, contexts> low;
  std::array<NibbleModel, 16> high; ///< by the low nibble
};

/** \brief All adaptive probabilities of the fast coder, as they are at an I-frame. */
struct FastModels {
  FastModels();

  // Known voxels, by their past: four at a time, and what remains of each bucket.
  std::array<NibbleModel, voxel_past::count> known;
  std::array<BitModel, voxel_past::count> known_rest;

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
  std::array<NibbleModel, 9> pair;           ///< by the classes of both voxels
  std::array<NibbleModel, 3> pair_escape;    ///< by the class
  std::array<NibbleModel, 125> known_symbol; ///< by mean and deviation
  /** \brief The same of a running mean; the second ones in I-frames. */
  std::array<std::array<NibbleModel, 125>, 2> new_symbol;
  NibbleModel escape_high;
  std::array<NibbleModel, 8> escape_low; ///< by the high bits
};

} // namespace io
} // namespace pcl_ext
