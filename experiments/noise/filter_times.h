/** \file
 * \brief Processor time of the outlier filters.
 */
#pragma once

#include <cstdint>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief Times VoxelOutlierRemoval and PCL's filters in turns, frame by frame, and
 * adds the results, experiment `noise_time`: voxels, median_ms and longest_ms of each
 * filter. */
void
measureFilterTimes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution,
                   measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
