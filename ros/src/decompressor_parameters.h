#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>

#include "parameter_reader.h"

#include <optional>
#include <string>
#include <vector>

namespace pcl_ext_ros {

/** \brief What is noise in the streams that nothing else is said of. */
struct NoiseParameters {
  float min_intensity = 0.0f;
  bool remove_outliers = false;
  float min_log_odds = pcl_ext::VoxelOutlierRemovalSettings().min_log_odds;
};

/** \brief One entry of ~streams. */
struct StreamParameters {
  std::string topic; ///< as it was given, not resolved
  std::optional<float> min_intensity;
  std::optional<bool> remove_outliers;
  std::optional<float> min_log_odds;
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
  NoiseParameters noise;
  double merge_rate = 10.0; ///< Hz; 0: not merged
  MapParameters map;
};

/** \brief Reads the decompressor's parameters.
 * \throws WrongParameter
 */
DecompressorParameters
readDecompressorParameters(ParameterReader& reader);

} // namespace pcl_ext_ros
