#include "fast_history.h"

namespace pcl_ext {
namespace io {

std::uint32_t
voxel_past::firstProbability(unsigned int past)
{
  unsigned int frames = 0;
  while (past >> (frames + 1) != 0)
    ++frames;
  std::int32_t probability = 26000;
  for (unsigned int i = 0; i < frames; ++i) {
    const std::int32_t goal = (past >> (frames - 1 - i) & 1) != 0 ? 0xffff : 0;
    const unsigned int shift = i < 2 ? 1 : i < 5 ? 2 : 3;
    probability += (goal - probability) >> shift;
  }
  return static_cast<std::uint32_t>(probability);
}

} // namespace io
} // namespace pcl_ext
