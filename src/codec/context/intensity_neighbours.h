#pragma once

#include <pcl_ext/version.h>

#include "voxels/lower_neighbours.h"
#include "voxels/voxel_block.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief The face neighbours of a voxel whose symbol is coded: all voxels of the frame
 * are known, and the symbols of those before it, which are the lower ones on each
 * axis. */
class IntensityNeighbours : public LowerNeighbours {
public:
  /** \brief Shapes are below this. */
  static constexpr std::uint32_t shape_count = 27;

  using LowerNeighbours::LowerNeighbours;

  /** \brief Selects a block of the frame. */
  void
  moveTo(std::size_t block)
  {
    LowerNeighbours::moveTo(block);
    for (std::size_t face = 0; face < face_count; ++face) {
      const std::uint64_t beside =
          face < lower_faces ? lower(face).mask : blockAcross(block, face).mask;
      across_[face] = occupiedAcross(selected().mask, beside, face);
    }
  }

  /** \brief On which axes a cell has neighbours: 9 times their number, 0..2, on x, 3
   * times that on y, and that on z. */
  std::uint32_t
  shapeOf(unsigned int cell) const
  {
    const auto onAxis = [&](std::size_t axis) {
      return static_cast<std::uint32_t>((across_[axis] >> cell & 1) +
                                        (across_[axis + 3] >> cell & 1));
    };
    return (onAxis(0) * 3 + onAxis(1)) * 3 + onAxis(2);
  }

  /** \brief Average symbol of a cell's lower neighbours, in sixteenths.
   * \param[in] cell of the block
   * \param[in] symbols of the frame's voxels, of which those before this one are coded
   * \param[in] otherwise returned if it has none
   */
  std::uint32_t
  averageOf(unsigned int cell,
            const std::vector<std::uint16_t>& symbols,
            std::uint32_t otherwise) const
  {
    std::uint32_t sum = 0;
    std::uint32_t count = 0;
    visitEachSide(cell, [&](std::size_t voxel, std::uint32_t is_there) {
      sum += symbols[voxel] * is_there;
      count += is_there;
    });
    return count == 0 ? otherwise : count == 3 ? 16 * sum / 3 : 16 * sum >> (count - 1);
  }

private:
  std::array<std::uint64_t, face_count> across_{}; ///< cells with a neighbour there
};

} // namespace context
} // namespace io
} // namespace pcl_ext
