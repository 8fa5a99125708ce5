#include <pcl_ext/nodes/cloud_messages.h>
#include <pcl_ext/nodes/impl/merged_map.h>

#include "node_parameters.h"
#include "parameter_reader.h"

namespace pcl_ext_ros1 {

using pcl_ext::nodes::noiseParameters;
using pcl_ext::nodes::ParameterDescription;
using pcl_ext::nodes::ParameterValues;
using pcl_ext::nodes::streamParameters;
using pcl_ext::nodes::valueOf;
using pcl_ext::nodes::withoutLeadingSlash;

namespace {

/** \brief The parameter of a name that an entry of ~streams may have besides its topic; null:
 * none. */
const ParameterDescription*
findStreamParameter(const std::string& name)
{
  for (const auto* const table : {&noiseParameters(), &streamParameters()})
    for (const ParameterDescription& parameter : *table)
      if (parameter.name == name)
        return &parameter;
  return nullptr;
}

/** \brief Reads an entry of ~streams: a topic, or a map with a topic. */
StreamParameters
readStream(XmlRpc::XmlRpcValue entry)
{
  const std::string shown = toText(entry) + " in one entry";
  const auto refuse = [&shown](const std::string& allowed) {
    ParameterReader::refuse("streams", shown, allowed);
  };
  const auto topicOf = [&](XmlRpc::XmlRpcValue value) {
    if (value.getType() != XmlRpc::XmlRpcValue::TypeString ||
        static_cast<std::string>(value).empty())
      refuse("a list in which each topic is a text that is not empty");
    return static_cast<std::string>(value);
  };

  StreamParameters stream;
  if (entry.getType() == XmlRpc::XmlRpcValue::TypeString) {
    stream.topic = topicOf(entry);
    return stream;
  }
  if (entry.getType() != XmlRpc::XmlRpcValue::TypeStruct || !entry.hasMember("topic"))
    refuse("a list of topics, or of maps with a topic");
  for (auto& [name, value] : entry) {
    if (name == "topic") {
      stream.topic = topicOf(value);
      continue;
    }
    const ParameterDescription* const parameter = findStreamParameter(name);
    if (parameter == nullptr)
      refuse("a list of maps with topic, min_intensity, remove_outliers, min_log_odds, "
             "density_unit and sensor_frame, not " +
             name);
    const auto converted = convertedValue(*parameter, value);
    if (!converted)
      refuse("a list in which each " + name + " is " + allowedValues(*parameter));
    if (name == "sensor_frame")
      stream.sensor_frame = withoutLeadingSlash(std::get<std::string>(*converted));
    else
      stream.noise[name] = *converted;
  }
  return stream;
}

std::vector<StreamParameters>
readStreams(ParameterReader& reader)
{
  std::vector<StreamParameters> streams;
  const auto entries = reader.list("streams");
  if (!entries) {
    streams.emplace_back().topic = "input";
    return streams;
  }
  if (entries->empty())
    ParameterReader::refuse("streams", "an empty list", "a list of topics, or not set");
  for (const XmlRpc::XmlRpcValue& entry : *entries)
    streams.push_back(readStream(entry));
  return streams;
}

} // namespace

DecompressorParameters
readDecompressorParameters()
{
  ParameterReader reader;
  DecompressorParameters parameters;
  parameters.streams = readStreams(reader);
  parameters.noise = reader.values(noiseParameters());
  parameters.node = reader.values(pcl_ext::nodes::centralNodeParameters());
  parameters.global_frame =
      withoutLeadingSlash(valueOf<std::string>(parameters.node, "global_frame"));
  parameters.tf_timeout = valueOf<double>(
      reader.values(
          {descriptionOf(pcl_ext::nodes::sensorNodeParameters(), "tf_timeout")}),
      "tf_timeout");
  reader.refuseUnknownNames();
  // Checked at the start, as the map may be written hours later.
  const auto& map_path = valueOf<std::string>(parameters.node, "map_path");
  if (!map_path.empty())
    if (const auto fault = pcl_ext::nodes::detail::MergedMap::faultOf(map_path);
        !fault.empty())
      throw WrongParameter("Parameter ~" + fault);
  return parameters;
}

} // namespace pcl_ext_ros1
