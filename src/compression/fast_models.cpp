#include "fast_models.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

FastModels::FastModels()
{
  for (unsigned int past = 1; past < voxel_past::count; ++past) {
    const std::uint32_t ones =
        std::min(std::max(voxel_past::firstProbability(past), 2000u), 64800u);
    known_rest[past] = BitModel(ones);
    // Four voxels that know nothing of each other.
    std::array<std::uint32_t, NibbleModel::symbol_count> weights;
    for (unsigned int nibble = 0; nibble < weights.size(); ++nibble) {
      std::uint64_t weight = 1u << 20;
      for (unsigned int bit = 0; bit < 4; ++bit)
        weight = weight * ((nibble >> bit & 1) != 0 ? ones : 0x10000 - ones) >> 16;
      weights[nibble] = static_cast<std::uint32_t>(weight) + 64;
    }
    known[past] = NibbleModel(weights);
  }
}

} // namespace io
} // namespace pcl_ext
