#pragma once

#include "codec/fast/frame.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Sorts the voxels of a frame into rows that are coded with the same kind of
 * model, by their statistics (doc/bitstream_fast.md, "Symbols"). */
struct IntensityRows {
  /** \brief Classes of voxels that are coded four at a time: three of low means, and
   * voxels without statistics. */
  static constexpr std::size_t low_class_count = 4;
  static constexpr std::size_t without_statistics = 3;

  /** \brief Voxels that are coded alike, in Morton order. The vector is memory, of
   * which the first `count` elements are in use; once they are coded it is the first
   * `noted`, of which more is to be coded. */
  struct Row {
    std::vector<std::uint32_t> voxels; ///< their index in the frame
    std::size_t count = 0;
    std::size_t noted = 0;
  };

  std::array<Row, low_class_count> quads;
  Row known;                         ///< other voxels with statistics
  Row fresh;                         ///< voxels without statistics in no quad
  std::vector<std::uint16_t> before; ///< by voxel: its statistics before this frame

  /** \brief Sorts voxels; those without statistics are all in their low class. */
  void
  sort(const Frame& frame, const StatisticsTable& statistics);

  /** \brief Moves voxels without statistics to `fresh`: all of them, or those that are no
   * whole quad. */
  void
  splitFresh(bool in_quads);
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
