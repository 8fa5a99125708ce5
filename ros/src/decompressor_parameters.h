#pragma once

#include <pcl_ext/nodes/central_node.h>

#include "parameter_reader.h"

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext_ros {

/** \brief Thresholds are from minus this to this: all that a float holds. Native
 * intensities may be negative. */
constexpr double highest_min_intensity = std::numeric_limits<float>::max();

/** \brief One entry of ~streams. */
struct StreamParameters {
  std::string topic; ///< as it was given, not resolved
  std::optional<float> min_intensity;
  std::string sensor_frame; ///< empty: no rays for the map
};

/** \brief How the map of all streams is kept. */
struct MapParameters {
  std::string path;  ///< file to write; empty: there is no map
  double rate = 1.0; ///< Hz
  double full_intensity = 4.0;
  double tf_timeout = 0.05; ///< seconds
};

/** \brief All that the decompressor is told by parameters; README.md documents them. */
struct DecompressorParameters {
  pcl_ext::nodes::CentralNodeSettings node;
  std::vector<StreamParameters> streams;
  std::string global_frame = "world";
  float min_intensity = 0.0f; ///< of streams without one of their own
  double merge_rate = 10.0;   ///< Hz; 0: not merged
  MapParameters map;
};

/** \brief Reads the decompressor's parameters.
 * \throws WrongParameter
 */
DecompressorParameters
readDecompressorParameters(ParameterReader& reader);

} // namespace pcl_ext_ros
