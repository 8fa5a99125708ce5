#pragma once

#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

// The parameters of the nodes; README.md has their units, defaults and ranges.

namespace pcl_ext_ros {

struct CompressorParameters {
  pcl_ext::nodes::SensorNodeSettings node;
  double tf_timeout = 0.05; ///< seconds
  std::uint32_t queue_size = 5;
  bool statistics = false;
};

/** \brief Reads the parameters of the compressor and checks them.
 * \throws WrongParameter
 */
CompressorParameters
readCompressorParameters();

/** \brief Noise settings of all streams that have none of their own. */
struct NoiseParameters {
  float min_intensity = 0.0f;
  bool remove_outliers = false;
  float min_log_odds = pcl_ext::VoxelOutlierRemovalSettings().min_log_odds;
  pcl_ext::DensityUnit density_unit = pcl_ext::VoxelOutlierRemovalSettings().unit;
};

/** \brief One entry of ~streams. */
struct StreamParameters {
  std::string topic; ///< as given, not resolved
  std::optional<float> min_intensity;
  std::optional<bool> remove_outliers;
  std::optional<float> min_log_odds;
  std::optional<pcl_ext::DensityUnit> density_unit;
  std::string sensor_frame; ///< empty: the map takes no rays from this stream
};

struct MapParameters {
  std::string path;  ///< file to write; empty: no map
  double rate = 1.0; ///< Hz
  double full_intensity = 4.0;
  double tf_timeout = 0.05; ///< seconds
};

struct ViewParameters {
  std::uint16_t port = 0; ///< 0: the streams are not shown
  std::string address;    ///< empty: this machine alone
  std::string page;       ///< the viewer's HTML
};

struct DecompressorParameters {
  pcl_ext::nodes::CentralNodeSettings node;
  std::vector<StreamParameters> streams;
  std::string global_frame = "world";
  NoiseParameters noise;
  double merge_rate = 10.0; ///< Hz; 0: no merged clouds
  MapParameters map;
  ViewParameters view;
};

/** \brief Reads the parameters of the decompressor and checks them.
 * \throws WrongParameter
 */
DecompressorParameters
readDecompressorParameters();

} // namespace pcl_ext_ros
