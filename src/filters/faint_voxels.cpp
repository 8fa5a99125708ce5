#include <pcl_ext/filters/faint_voxels.h>

namespace pcl_ext {

namespace {

/** \brief The lowest symbol that stands for an intensity of at least this; one above the
 * highest if there is none. Intensities do not fall as symbols grow. */
std::uint32_t
lowestSymbol(const io::IntensityScale& scale, float min_intensity)
{
  std::uint32_t low = 0;
  std::uint32_t high = scale.maxSymbol() + 1;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (scale.value(static_cast<std::uint16_t>(middle)) < min_intensity)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

} // namespace

std::size_t
removeFaintVoxels(io::VoxelFrame& frame, float min_intensity)
{
  const std::uint32_t lowest = lowestSymbol(frame.intensity_scale, min_intensity);
  if (lowest == 0)
    return 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    // Written in any case, as which voxels stay is hard to foretell.
    frame.keys[kept] = frame.keys[i];
    frame.intensities[kept] = frame.intensities[i];
    kept += frame.intensities[i] >= lowest ? 1 : 0;
  }
  const std::size_t removed = frame.size() - kept;
  frame.keys.resize(kept);
  frame.intensities.resize(kept);
  return removed;
}

} // namespace pcl_ext
