#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/context/history.h"
#include "codec/depth_split.h"

#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief What a payload is coded with besides the frame itself, the same on both
 * sides. */
struct FrameContext {
  const History& history;        ///< of the frames before
  bool is_i_frame;               ///< the history is empty, and so is what was learnt
  unsigned int grid_depth;       ///< 1..21
  unsigned int symbol_bits;      ///< 1..16
  const DepthModel* depth_model; ///< null if intensities do not depend on depth

  std::uint32_t
  maxSymbol() const
  {
    return (std::uint32_t{1} << symbol_bits) - 1;
  }
};

/** \brief Copies numbers. Memory grows by more than it must, which assignment does not, so
 * that a stream's frames soon need no more. */
inline void
copyNumbers(const std::vector<std::uint16_t>& from, std::vector<std::uint16_t>& to)
{
  if (to.capacity() < from.size())
    to.reserve(from.size() / 4 * 5 + 4);
  to.assign(from.begin(), from.end());
}

/** \brief The intensities of a frame's voxels, as they are coded. Both coders speak of
 * them in this form. */
struct CodedIntensities {
  /** \brief What is coded first: the number of points where the depth model can tell it,
   * else the symbol itself. */
  std::vector<std::uint16_t> numbers;
  std::vector<std::uint16_t> symbols;
  DepthSplit split; ///< used with a depth model only
};

} // namespace context
} // namespace io
} // namespace pcl_ext
