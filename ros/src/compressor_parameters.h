#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "parameter_reader.h"

#include <cstdint>

namespace pcl_ext_ros {

/** \brief All that the compressor is told by parameters; README.md documents them. */
struct CompressorParameters {
  pcl_ext::nodes::SensorNodeSettings node;
  double tf_timeout = 0.05; ///< seconds
  std::uint32_t queue_size = 5;
  bool statistics = false;
};

/** \brief Reads the compressor's parameters.
 * \throws WrongParameter
 */
CompressorParameters
readCompressorParameters(ParameterReader& reader);

} // namespace pcl_ext_ros
