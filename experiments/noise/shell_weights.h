/** \file
 * \brief Fits the weights of VoxelOutlierRemoval.
 */
#pragma once

#include <cstdint>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief Fits the weights of core, ring and rim to one stream by logistic regression,
 * and adds them to the results, experiment `noise_weights`: c, core, ring, rim.
 * \param[in] seed, sensor, resolution of the stream
 * \param[in] frames of it; the voxels of every tenth are used
 */
void
fitShellWeights(std::uint32_t seed,
                unsigned int sensor,
                std::uint32_t frames,
                double resolution,
                measuring::ResultFile& results);

/** \brief Fits the offset of the unit Voxels to the lidar's stream by maximum
 * likelihood, and adds what is to be added to that of the library, experiment
 * `noise_weights`. */
void
fitVoxelsOffset(std::uint32_t seed,
                std::uint32_t frames,
                double resolution,
                measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
