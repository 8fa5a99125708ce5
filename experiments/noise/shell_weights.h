/** \file
 * \brief Where the weights of VoxelOutlierRemoval come from.
 */
#pragma once

#include <cstdint>
#include <iosfwd>

namespace pcl_ext {
namespace noise {

/** \brief Fits the weights of core, ring and rim to one stream by logistic regression, and
 * prints them.
 * \param[in] seed, sensor, resolution of the stream
 * \param[in] frames of it; of the last of each ten the voxels are used
 */
void
printShellWeights(std::uint32_t seed,
                  unsigned int sensor,
                  double resolution,
                  std::uint32_t frames,
                  std::ostream& output);

} // namespace noise
} // namespace pcl_ext
