#include "message_conversions.h"
#include "node_parameters.h"
#include "parameter_reader.h"

namespace pcl_ext_ros {

using pcl_ext::nodes::encodingParameters;
using pcl_ext::nodes::SensorNodeSettings;

SensorNodeSettings
sensorNodeSettings(const CompressorParameters& parameters, bool has_intensities)
{
  SensorNodeSettings settings;
  settings.global_frame = parameters.global_frame;
  settings.clock = rosTimeNow;
  const std::string fault =
      readEncodingParameters(parameters.encoding, has_intensities, settings);
  if (!fault.empty())
    throw WrongParameter("Parameter ~" + fault);
  return settings;
}

CompressorParameters
readCompressorParameters()
{
  ParameterReader reader;
  CompressorParameters parameters;
  parameters.encoding = reader.values(encodingParameters());
  parameters.global_frame = reader.frame("global_frame", "world");
  parameters.tf_timeout = reader.number("tf_timeout", 0.05, 0, 10);
  parameters.queue_size = reader.count("queue_size", 5, 1, 1000);
  parameters.statistics = reader.flag("statistics", false);
  reader.refuseUnknownNames();
  // What the first cloud decides must not end the node later.
  for (const bool has_intensities : {false, true})
    sensorNodeSettings(parameters, has_intensities);
  return parameters;
}

} // namespace pcl_ext_ros
