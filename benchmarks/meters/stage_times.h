/** \file
 * \brief Times of the stages from the sensor's cloud to bytes and back.
 */
#pragma once

#include "measuring/samples.h"
#include "measuring/workload.h"

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Figures of one stage; samples are frames. */
struct StageTimes {
  std::string name;
  Samples points; ///< of the cloud that the stage starts from or ends with
  Samples voxels; ///< of the frame
  Samples milliseconds;
};

/** \brief Runs a stream through all stages of a variant in this process: move and crop,
 * voxelize, remove outliers from a copy, code, decode, fill a cloud.
 * \param[in] repetitions of the stream with new coders; the least of each sample counts
 * \throws std::runtime_error if a stage fails, or if what was decoded is not what was
 * encoded
 */
std::vector<StageTimes>
timeStages(const InputStream& stream,
           const Workload& workload,
           const Variant& variant,
           std::size_t repetitions);

} // namespace measuring
} // namespace pcl_ext
