#pragma once

#include "simd/symbol_lanes.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstdint>
#include <cstring>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief The occupied cells of a block, ascending. */
class CellList {
public:
  /** \brief Lists the cells of a mask. Without branches: the list of each octant is copied
   * over the excess of the previous one.
   * \return their number
   */
  unsigned int
  assign(std::uint64_t mask)
  {
    std::uint8_t* next = cells_.data();
    for (unsigned int octant = 0; octant < 8; ++octant) {
      const unsigned int children = mask >> (8 * octant) & 0xff;
      std::uint64_t eight;
      std::memcpy(&eight, child_masks.children[children].data(), sizeof(eight));
      eight += octant * 0x0808080808080808; // in each byte, without carries
      std::memcpy(next, &eight, sizeof(eight));
      next += child_masks.count[children];
    }
    return static_cast<unsigned int>(next - cells_.data());
  }

  /** \brief Adds eight cells to a number. Those that are not in the list have any value.
   * \param[in] first index of the first cell, 0..56
   * \param[in] number a place or a key
   * \param[out] sums eight of them
   */
  template <class Number>
  void
  addTo(Number number, unsigned int first, Number* sums) const
  {
    addToBytes(cells_.data() + first, number, sums);
  }

private:
  std::array<std::uint8_t, block_cells + 8> cells_{};
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
