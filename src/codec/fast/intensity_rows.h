#pragma once

#include "codec/fast/frame.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Divides the voxels of a frame by their statistics into rows that are coded with the
 * same kind of model (doc/bitstream_fast.md, "Symbols"). */
struct IntensityRows {
  /** \brief Classes of voxels that are coded in quads: three of low means, and voxels without
   * statistics. */
  static constexpr std::size_t low_class_count = 4;
  static constexpr std::size_t without_statistics = 3;

  /** \brief Voxels that are coded in the same way, in Morton order. The first `count`
   * elements of the vector are in use; once they are coded, the first `noted`, which are
   * those whose bins or low bits are still to be coded. */
  struct Row {
    std::vector<std::uint32_t> voxels; ///< their index in the frame
    std::size_t count = 0;
    std::size_t noted = 0;
  };

  std::array<Row, low_class_count> quads;
  Row known;                         ///< other voxels with statistics
  Row fresh;                         ///< voxels without statistics that are in no quad
  std::vector<std::uint16_t> before; ///< statistics before this frame, by voxel

  /** \brief Divides the voxels; all without statistics are in their low class. */
  void
  sort(const Frame& frame, const StatisticsTable& statistics);

  /** \brief Moves voxels without statistics to `fresh`: all of them, or those of an
   * incomplete quad. */
  void
  splitFresh(bool in_quads);
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
