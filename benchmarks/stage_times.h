/** \file
 * \brief Where this library's time goes, stage by stage.
 */
#pragma once

#include "measuring/samples.h"
#include "measuring/workload.h"

#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Milliseconds of each stage of one variant; samples are frames. */
struct StageTimes {
  std::string name;
  Samples preprocess;   ///< SensorPreprocessor, from the raw cloud
  Samples voxelize;     ///< Voxelizer
  Samples code;         ///< FrameEncoder
  Samples decode;       ///< FrameDecoder
  Samples class_encode; ///< OctreePointCloudIntensityCompression, points to bytes
  Samples class_decode; ///< the same class, bytes to cloud
};

/** \brief The stages of all variants, variant by variant on each frame.
 * \throws std::runtime_error if what was decoded is not what was encoded
 */
std::vector<StageTimes>
timeStages(const InputStream& stream,
           const Workload& workload,
           std::size_t repetitions);

} // namespace measuring
} // namespace pcl_ext
