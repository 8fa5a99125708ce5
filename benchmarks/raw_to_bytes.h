/** \file
 * \brief The whole way from the sensor's cloud to bytes, this library's and PCL's.
 */
#pragma once

#include "measuring/samples.h"
#include "measuring/workload.h"

#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Milliseconds from the sensor's cloud to bytes; samples are frames. */
struct RawToBytesTimes {
  std::string name;
  std::string passes;
  Samples move_and_crop;
  Samples compress;
  Samples total;
  Samples bytes;
};

/** \brief All variants, and last PCL's transformPointCloud, CropBox and compression in
 * voxel-grid mode.
 *
 * Both get the organised cloud in the sensor's frame. PCL stays with PointXYZ, the
 * smaller of the two, as its class keeps no intensity.
 * \throws std::runtime_error if the ways differ in the points that they keep
 */
std::vector<RawToBytesTimes>
timeRawToBytes(const InputStream& stream,
               const Workload& workload,
               std::size_t repetitions);

} // namespace measuring
} // namespace pcl_ext
