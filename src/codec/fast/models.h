#pragma once

#include "codec/fast/byte_table.h"
#include "codec/fast/history.h"
#include "codec/fast/nibble_model.h"

#include <array>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Models of a byte that is coded as low nibble, then high nibble. */
template <std::size_t contexts>
struct ByteModels {
  std::array<NibbleModel, contexts> low;
  std::array<NibbleModel, 16> high; ///< by the low nibble
};

/** \brief Codes a byte as two nibbles. */
template <class Coder, std::size_t contexts>
unsigned int
codeByte(Coder& coder,
         ByteModels<contexts>& models,
         unsigned int context,
         unsigned int byte)
{
  const unsigned int low = coder.code(models.low[context], byte & 15);
  return low | coder.code(models.high[low], byte >> 4) << 4;
}

/** \brief All adaptive probabilities of effort fast, initially those of an I-frame. */
struct Models {
  Models();

  /** \brief Probability that a known voxel is occupied, by its past; 2^16 is 1. */
  std::array<std::uint16_t, voxel_past::count> known_probability{};

  // New voxels in known blocks.
  std::array<NibbleModel, 32> octant; ///< by activity and whether the block is empty
  ByteModels<1> octants;              ///< masks of several octants
  std::array<NibbleModel, 24> cell;   ///< by numbers of near and of open cells
  ByteModels<1> cells;                ///< masks of several cells

  // New blocks; in pairs the second element is for I-frames.
  BitModel has_new_blocks;
  std::array<ByteModels<1>, 4> node; ///< by levels between children and blocks
  std::array<ByteModels<1>, 2> new_block_octants;
  std::array<ByteModels<16>, 2> new_block_cells; ///< low nibble: by neighbours

  // Intensities.
  std::array<QuadModel, 4> quad;             ///< by class
  std::array<NibbleModel, 4> quad_escape;    ///< by class
  std::array<NibbleModel, 125> known_symbol; ///< by statistics of the voxel
  /** \brief Whether most voxels without statistics had low bins in the last frame. */
  bool new_bins_are_low = false;
  /** \brief By common statistics of the previous voxels; the second ones for I-frames. */
  std::array<std::array<NibbleModel, 125>, 2> new_symbol;
  NibbleModel escape_high;
  std::array<NibbleModel, 8> escape_low; ///< by high bits
  ByteModels<1> plain;                   ///< high bits of plain symbols
};

/** \brief The initial models, as at an I-frame. */
const Models&
firstModels();

} // namespace fast
} // namespace io
} // namespace pcl_ext
