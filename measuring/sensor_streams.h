/** \file
 * \brief Encoded streams, as the computers beside the sensors send them.
 */
#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "measuring/workload.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief An encoded stream that is sent repeatedly. */
struct SensorStream {
  std::string name;
  std::vector<std::vector<std::uint8_t>> frames;
  std::vector<std::size_t> i_frames; ///< which frames are I-frames; the first one is
  std::size_t bytes = 0;             ///< of all frames
  std::size_t voxels = 0;            ///< of all frames
};

/** \brief The settings of a sensor's node: number of points as intensity; no header and no
 * colours, so that recordings with and without them compare. */
nodes::SensorNodeSettings
sensorNodeSettings(const InputStream& stream,
                   const Workload& workload,
                   const Variant& variant);

/** \brief Encodes a stream as its SensorNode does.
 * \throws std::runtime_error if a cloud cannot be read or encoded
 */
SensorStream
encodeStream(const InputStream& stream,
             const Workload& workload,
             const Variant& variant);

} // namespace measuring
} // namespace pcl_ext
