/** \file
 * \brief Size of a stream whose noise is removed before it is encoded.
 */
#pragma once

#include <cstdint>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief Encodes one sensor's stream with a SensorNode without the filter, with it,
 * and with only the points that the simulator marks as of surfaces; adds the results,
 * experiment `noise_bytes:` and law and effort: voxels and bytes of a frame, and
 * less_percent, the bytes saved.
 * \throws std::runtime_error if a frame cannot be encoded
 */
void
measureStreamBytes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution,
                   measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
