#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/nodes/impl/merged_map.h>

#include "message_conversions.h"
#include "node_parameters.h"
#include "parameter_reader.h"

#include <fstream>
#include <iterator>

namespace pcl_ext_ros {

using pcl_ext::nodes::noiseParameters;
using pcl_ext::nodes::ParameterValues;

namespace {

/** \brief Reads an entry of ~streams: a topic, or a map with a topic. */
StreamParameters
readStream(XmlRpc::XmlRpcValue entry)
{
  const std::string shown = toText(entry) + " in one entry";
  const auto refuse = [&shown](const std::string& allowed) {
    ParameterReader::refuse("streams", shown, allowed);
  };
  const auto textOf = [&](XmlRpc::XmlRpcValue value, const std::string& name) {
    if (value.getType() != XmlRpc::XmlRpcValue::TypeString ||
        static_cast<std::string>(value).empty())
      refuse("a list in which each " + name + " is a text that is not empty");
    return static_cast<std::string>(value);
  };

  StreamParameters stream;
  if (entry.getType() == XmlRpc::XmlRpcValue::TypeString) {
    stream.topic = textOf(entry, "topic");
    return stream;
  }
  if (entry.getType() != XmlRpc::XmlRpcValue::TypeStruct || !entry.hasMember("topic"))
    refuse("a list of topics, or of maps with a topic");
  const ParameterValues known = defaultsOf(noiseParameters());
  for (auto& [name, value] : entry) {
    if (name == "topic")
      stream.topic = textOf(value, name);
    else if (name == "sensor_frame")
      stream.sensor_frame = withoutLeadingSlash(textOf(value, name));
    else if (known.count(name) != 0) {
      const auto& parameter = descriptionOf(noiseParameters(), name);
      const auto converted = convertedValue(parameter, value);
      if (!converted)
        refuse("a list in which each " + name + " is " + allowedValues(parameter));
      stream.noise[name] = *converted;
    }
    else
      refuse("a list of maps with topic, min_intensity, remove_outliers, min_log_odds, "
             "density_unit and sensor_frame, not " +
             name);
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

MapParameters
readMap(ParameterReader& reader)
{
  MapParameters map;
  map.path = reader.text("map_path", "");
  map.rate = reader.number("map_rate", 1.0, 0.001, 1000);
  constexpr double highest_intensity = 3.4e38; // below the largest float
  map.full_intensity =
      reader.number("map_full_intensity", 4.0, 1e-6, highest_intensity);
  map.tf_timeout = reader.number("tf_timeout", 0.05, 0, 10);
  if (map.path.empty())
    return map;
  // Checked at the start, as the map may be written hours later.
  if (!pcl_ext::nodes::detail::MergedMap::faultOf(map.path).empty())
    ParameterReader::refuse(
        "map_path", "'" + map.path + "'", "a file in a folder that can be written to");
  return map;
}

/** \brief The content of a file; nothing if it cannot be read or is empty. */
std::optional<std::string>
contentOf(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(file),
                      std::istreambuf_iterator<char>()};
  if (!file || content.empty())
    return std::nullopt;
  return content;
}

ViewParameters
readView(ParameterReader& reader)
{
  ViewParameters view;
  constexpr std::uint32_t largest_port = 65535;
  view.port = static_cast<std::uint16_t>(reader.count("view_port", 0, 0, largest_port));
  view.address = reader.text("view_address", "");
  const std::string path = reader.text("view_page", PCL_EXT_ROS_VIEW_PAGE);
  if (view.port == 0)
    return view;
  const std::optional<std::string> page = contentOf(path);
  if (!page)
    ParameterReader::refuse("view_page",
                            "'" + path + "'",
                            "the viewer's page, viewer.html, which viewer/build.sh of "
                            "pcl_ext makes");
  view.page = *page;
  return view;
}

} // namespace

DecompressorParameters
readDecompressorParameters()
{
  ParameterReader reader;
  DecompressorParameters parameters;
  parameters.streams = readStreams(reader);
  parameters.global_frame = reader.frame("global_frame", "world");
  parameters.noise = reader.values(noiseParameters());
  parameters.merge_rate = reader.number("merge_rate", 10, 0, 1000);
  if (parameters.merge_rate > 0 && parameters.merge_rate < 0.001)
    ParameterReader::refuse("merge_rate", "below 0.001", "0, or 0.001 to 1000");
  pcl_ext::nodes::CentralNodeSettings& node = parameters.node;
  node.resolution = reader.number("resolution",
                                  node.resolution,
                                  pcl_ext::io::smallest_resolution,
                                  pcl_ext::io::largest_resolution);
  node.threads = reader.count("threads", node.threads, 0, 1024);
  node.max_waiting_frames =
      reader.count("max_waiting_frames",
                   static_cast<std::uint32_t>(node.max_waiting_frames),
                   1,
                   100000);
  using Seconds = std::chrono::duration<double>;
  node.max_merge_age =
      std::chrono::duration_cast<pcl_ext::nodes::Time>(Seconds(reader.number(
          "max_merge_age", Seconds(node.max_merge_age).count(), 0.001, 3600)));
  node.clock = rosTimeNow;
  parameters.map = readMap(reader);
  parameters.view = readView(reader);
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace pcl_ext_ros
