/** \file
 * \brief Times and counts of the stages from the sensor's cloud to bytes and back.
 */
#pragma once

#include "event_counter.h"
#include "measuring/samples.h"
#include "measuring/workload.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Figures of one stage; samples are frames. */
struct StageCounts {
  std::string name;
  Samples points;        ///< of the cloud that the stage starts from or ends with
  Samples voxels;        ///< of the frame
  Samples bytes_read;    ///< the stage's input
  Samples bytes_written; ///< its output
  Samples milliseconds;
  /** \brief Of each of event_names; empty if it is not counted. */
  std::array<Samples, event_names.size()> events;
};

/** \brief Runs a stream through all stages of a variant in this process: move and crop,
 * voxelize, remove outliers from a copy, code, decode, fill a cloud.
 * \param[in] repetitions of the stream with new coders; the least of each sample counts
 * \throws std::runtime_error if a stage fails, or if what was decoded is not what was
 * encoded
 */
std::vector<StageCounts>
countStages(const InputStream& stream,
            const Workload& workload,
            const Variant& variant,
            std::size_t repetitions,
            EventCounter& counter);

} // namespace measuring
} // namespace pcl_ext
