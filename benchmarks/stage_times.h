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

/** \brief Milliseconds of each stage of one coder; samples are frames. */
struct StageTimes {
  std::string name;
  Samples preprocess;   ///< SensorPreprocessor, from the raw cloud; PCL: move and crop
  Samples voxelize;     ///< points -> voxels
  Samples code;         ///< voxels -> bytes
  Samples decode;       ///< FrameDecoder
  Samples class_encode; ///< the class, points -> bytes
  Samples class_decode; ///< the class, bytes -> cloud
  Samples raw_to_bytes; ///< sum of preprocess and class_encode
  Samples bytes;        ///< of a frame
};

/** \brief All stages of each of libraryVariants().
 * \throws std::runtime_error if what was decoded is not what was encoded
 */
std::vector<StageTimes>
timeStages(const InputStream& stream,
           const Workload& workload,
           std::size_t repetitions);

/** \brief Preprocessing and the class's encoding alone, of each of libraryVariants(), then
 * SensorNode at the first of them, and last PCL's transformPointCloud, CropBox and compression in voxel-grid mode.
 *
 * All start from the organised cloud in the sensor's frame. PCL gets PointXYZ, the
 * smaller type, as its class keeps no intensity.
 * \param[in] stream has a crop box
 * \throws std::runtime_error if PCL keeps other points than the library
 */
std::vector<StageTimes>
timeRawToBytes(const InputStream& stream,
               const Workload& workload,
               std::size_t repetitions);

} // namespace measuring
} // namespace pcl_ext
