#include <pcl_ext/nodes/cloud_messages.h>

#include "message_conversions.h"
#include "node_parameters.h"
#include "parameter_reader.h"

namespace pcl_ext_ros1 {

using pcl_ext::nodes::valueOf;
using pcl_ext::nodes::withoutLeadingSlash;

namespace {

pcl_ext::nodes::ParameterDescription
statisticsParameter()
{
  pcl_ext::nodes::ParameterDescription parameter;
  parameter.name = "statistics";
  parameter.default_value = false;
  parameter.description = "Print a line of statistics each second.";
  return parameter;
}

} // namespace

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
  parameters.node = reader.values(pcl_ext::nodes::sensorNodeParameters());
  parameters.global_frame =
      withoutLeadingSlash(valueOf<std::string>(parameters.node, "global_frame"));
  parameters.statistics =
      valueOf<bool>(reader.values({statisticsParameter()}), "statistics");
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace pcl_ext_ros1
