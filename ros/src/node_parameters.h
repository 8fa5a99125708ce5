#pragma once

#include <pcl_ext/nodes/cloud_sender.h>
#include <pcl_ext/nodes/node_parameters.h>

#include <memory>
#include <string>
#include <vector>

// The parameters of the nodes: doc/nodes.md has their units, defaults and ranges.

namespace pcl_ext_ros1 {

struct CompressorParameters {
  pcl_ext::nodes::ParameterValues encoding; ///< of encodingParameters()
  pcl_ext::nodes::ParameterValues node;     ///< of sensorNodeParameters()
  std::string global_frame;                 ///< without a leading slash
  bool statistics = false;                  ///< a line is printed each second
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

struct DecompressorParameters {
  pcl_ext::nodes::ParameterValues node; ///< of centralNodeParameters()
  std::vector<StreamParameters> streams;
  pcl_ext::nodes::ParameterValues noise; ///< of all streams without one of their own
  std::string global_frame;              ///< without a leading slash
  double tf_timeout = 0.0;               ///< seconds, for the sensor_frame of streams
};

/** \brief Reads the parameters of the decompressor and checks them.
 * \throws WrongParameter
 */
DecompressorParameters
readDecompressorParameters();

} // namespace pcl_ext_ros1
