#pragma once

#include "voxels/lower_neighbours.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief Looks up the numbers of the face neighbours of a voxel that are coded before it:
 * the lower one on each axis. */
class IntensityNeighbours : public LowerNeighbours {
public:
  /** \brief Classes are below this. */
  static constexpr std::uint32_t class_count = 12;

  using LowerNeighbours::LowerNeighbours;

  /** \brief Class of the average number of a cell's lower neighbours; 0 if it has none.
   * \param[in] cell of the block
   * \param[in] numbers of the frame's voxels, of which those before this one are coded
   */
  std::uint32_t
  classOf(unsigned int cell, const std::vector<std::uint16_t>& numbers) const
  {
    std::uint32_t sum = 0;
    std::uint32_t count = 0;
    visit(cell, [&](std::size_t voxel) {
      sum += numbers[voxel];
      ++count;
    });
    if (count == 0)
      return 0;
    constexpr std::array<std::uint16_t, class_count - 2> ends = {
        16, 24, 32, 40, 48, 64, 80, 112, 160, 256};
    const std::uint32_t average = 16 * sum / count;
    return static_cast<std::uint32_t>(
        1 + (std::lower_bound(ends.begin(), ends.end(), average) - ends.begin()));
  }
};

} // namespace context
} // namespace io
} // namespace pcl_ext
