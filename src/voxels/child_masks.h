#pragma once

#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Tables of the 256 masks of eight children: those of an octree node, the octants of
 * a block, or the cells of an octant. Bit c is child c = 4x + 2y + z. */
struct ChildMasks {
  std::array<std::uint8_t, 256> count{}; ///< number of children in a mask
  /** \brief The children in a mask, ascending, then zeros. */
  std::array<std::array<std::uint8_t, 8>, 256> children{};
  /** \brief All eight children, sorted: those in the mask first, then by decreasing number of
   * face neighbours in the mask, then ascending. */
  std::array<std::array<std::uint8_t, 8>, 256> by_neighbours{};
  /** \brief Index of a child in `by_neighbours`. */
  std::array<std::array<std::uint8_t, 8>, 256> rank{};
};

constexpr ChildMasks
makeChildMasks()
{
  ChildMasks masks;
  for (unsigned int mask = 0; mask < 256; ++mask) {
    std::uint8_t& count = masks.count[mask];
    for (unsigned int child = 0; child < 8; ++child)
      if ((mask >> child & 1) != 0)
        masks.children[mask][count++] = static_cast<std::uint8_t>(child);
    std::uint8_t rank = 0;
    for (unsigned int wanted = 8; wanted-- > 0;)
      for (unsigned int child = 0; child < 8; ++child) {
        const unsigned int score = (mask >> child & 1) * 4 + (mask >> (child ^ 1) & 1) +
                                   (mask >> (child ^ 2) & 1) +
                                   (mask >> (child ^ 4) & 1);
        if (score != wanted)
          continue;
        masks.by_neighbours[mask][rank] = static_cast<std::uint8_t>(child);
        masks.rank[mask][child] = rank++;
      }
  }
  return masks;
}

inline constexpr ChildMasks child_masks = makeChildMasks();

} // namespace io
} // namespace pcl_ext
