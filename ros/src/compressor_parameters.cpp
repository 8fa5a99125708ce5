#include "message_conversions.h"
#include "node_parameters.h"
#include "parameter_reader.h"

namespace pcl_ext_ros {

std::unique_ptr<pcl_ext::nodes::CloudSender>
senderOf(const CompressorParameters& parameters)
{
  pcl_ext::nodes::SensorNodeSettings settings;
  settings.global_frame = parameters.global_frame;
  settings.clock = rosTimeNow;
  auto sender = std::make_unique<pcl_ext::nodes::CloudSender>(settings);
  const std::string fault = sender->setParameters(parameters.encoding);
  if (!fault.empty())
    throw WrongParameter("Parameter ~" + fault);
  return sender;
}

CompressorParameters
readCompressorParameters()
{
  ParameterReader reader;
  CompressorParameters parameters;
  parameters.encoding = reader.values(pcl_ext::nodes::encodingParameters());
  parameters.global_frame = reader.frame("global_frame", "world");
  parameters.tf_timeout = reader.number("tf_timeout", 0.05, 0, 10);
  parameters.queue_size = reader.count("queue_size", 5, 1, 1000);
  parameters.statistics = reader.flag("statistics", false);
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace pcl_ext_ros
