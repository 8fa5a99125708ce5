#include <pcl_ext/compression/voxel_frame.h>

namespace pcl_ext {
namespace io {

std::uint32_t
compandedEdge(unsigned int bits, std::uint32_t range, std::uint32_t level)
{
  const std::uint32_t level_count = std::uint32_t{1} << bits;
  if (level >= level_count)
    return range + 1;
  if (level < 3)
    return level;
  if (level_count == 4)
    return 4;
  constexpr std::uint32_t exact = 4;
  if (level <= exact)
    return level;
  const std::uint64_t widening = level_count - exact;
  const std::uint64_t step = level - exact;
  const std::uint64_t excess = range + 1 - exact - widening;
  return exact + static_cast<std::uint32_t>(step + excess * step * step /
                                                       (widening * widening));
}

std::uint32_t
compandedMiddle(unsigned int bits, std::uint32_t range, std::uint32_t level)
{
  return (compandedEdge(bits, range, level) + compandedEdge(bits, range, level + 1) -
          1) /
         2;
}

} // namespace io
} // namespace pcl_ext
