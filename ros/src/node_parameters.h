#pragma once

#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/cloud_sender.h>
#include <pcl_ext/nodes/node_parameters.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

// The parameters of the nodes; README.md has their units, defaults and ranges.

namespace pcl_ext_ros {

struct CompressorParameters {
  pcl_ext::nodes::ParameterValues encoding; ///< of encodingParameters(), if set
  std::string global_frame = "world";
  double tf_timeout = 0.05; ///< seconds
  std::uint32_t queue_size = 5;
  bool statistics = false;
};

/** \brief Reads the parameters of the compressor and checks them.
 * \throws WrongParameter
 */
CompressorParameters
readCompressorParameters();

/** \brief A sender with these parameters.
 * \throws WrongParameter if they contradict each other
 */
std::unique_ptr<pcl_ext::nodes::CloudSender>
senderOf(const CompressorParameters& parameters);

/** \brief One entry of ~streams. */
struct StreamParameters {
  std::string topic;                     ///< as given, not resolved
  pcl_ext::nodes::ParameterValues noise; ///< of noiseParameters(), if set here
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
  pcl_ext::nodes::ParameterValues noise; ///< of all streams without one of their own
  double merge_rate = 10.0;              ///< Hz; 0: no merged clouds
  MapParameters map;
  ViewParameters view;
};

/** \brief Reads the parameters of the decompressor and checks them.
 * \throws WrongParameter
 */
DecompressorParameters
readDecompressorParameters();

} // namespace pcl_ext_ros
