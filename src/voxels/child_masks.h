#pragma once

#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief Tables of the 256 masks of eight children: of the octants of a block, of the
 * cells of an octant. Bit c is child c = 4x + 2y + z. */
struct ChildMasks {
  std::array<std::uint8_t, 256> count{}; ///< children in a mask
  /** \brief The children of a mask, ascending, then zeros. */
  std::array<std::array<std::uint8_t, 8>, 256> children{};
  /** \brief All children by what a mask says of them: occupied ones first, then by the
   * number of occupied face neighbours, then by their number. */
  std::array<std::array<std::uint8_t, 8>, 256> by_neighbours{};
  /** \brief Place of a child in `by_neighbours`. */
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

/** \brief The octants of a block that have occupied cells. */
constexpr unsigned int
occupiedOctants(std::uint64_t cells)
{
  constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7f;
  const std::uint64_t high = (((cells & low) + low) | cells) & ~low;
  return static_cast<unsigned int>((high >> 7) * 0x0102040810204080 >> 56);
}

/** \brief The cells of a block that share a face with an occupied one in it. */
constexpr std::uint64_t
cellsBeside(std::uint64_t cells)
{
  // Cells whose coordinate has its low and its high bit set.
  constexpr std::uint64_t z_low = 0xaaaaaaaaaaaaaaaa;
  constexpr std::uint64_t z_high = 0xff00ff00ff00ff00;
  constexpr std::uint64_t y_low = 0xcccccccccccccccc;
  constexpr std::uint64_t y_high = 0xffff0000ffff0000;
  constexpr std::uint64_t x_low = 0xf0f0f0f0f0f0f0f0;
  constexpr std::uint64_t x_high = 0xffffffff00000000;
  return (cells & ~z_low) << 1 | (cells & z_low) >> 1 | (cells & z_low & ~z_high) << 7 |
         (cells & ~z_low & z_high) >> 7 | (cells & ~y_low) << 2 | (cells & y_low) >> 2 |
         (cells & y_low & ~y_high) << 14 | (cells & ~y_low & y_high) >> 14 |
         (cells & ~x_low) << 4 | (cells & x_low) >> 4 |
         (cells & x_low & ~x_high) << 28 | (cells & ~x_low & x_high) >> 28;
}

} // namespace io
} // namespace pcl_ext
