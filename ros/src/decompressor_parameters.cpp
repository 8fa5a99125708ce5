#include "decompressor_parameters.h"

#include <pcl_ext/compression/voxel_frame.h>

#include "fused_map.h"
#include "message_conversions.h"

#include <filesystem>
#include <fstream>

namespace pcl_ext_ros {

namespace {

/** \brief Reads a list's element: a topic, or a map of topic and more. */
StreamParameters
readStream(XmlRpc::XmlRpcValue element)
{
  const std::string shown = toText(element);
  const auto refuse = [&shown](const std::string& allowed) {
    ParameterReader::refuse("streams", shown + " in one place", allowed);
  };
  const auto textOf = [&](XmlRpc::XmlRpcValue value, const std::string& what) {
    if (value.getType() != XmlRpc::XmlRpcValue::TypeString ||
        static_cast<std::string>(value).empty())
      refuse("a list whose " + what + " are texts");
    return static_cast<std::string>(value);
  };
  const auto floatOf = [&](const XmlRpc::XmlRpcValue& value, const std::string& what) {
    const std::optional<float> number = toFloat(value);
    if (!number)
      refuse("a list whose " + what + " are finite numbers");
    return number;
  };

  StreamParameters stream;
  if (element.getType() == XmlRpc::XmlRpcValue::TypeString) {
    stream.topic = textOf(element, "topics");
    return stream;
  }
  if (element.getType() != XmlRpc::XmlRpcValue::TypeStruct ||
      !element.hasMember("topic"))
    refuse("a list of topics, or of maps with a topic");
  for (auto& member : element) {
    if (member.first == "topic")
      stream.topic = textOf(member.second, "topics");
    else if (member.first == "sensor_frame")
      stream.sensor_frame = withoutLeadingSlash(textOf(member.second, "sensor_frames"));
    else if (member.first == "min_intensity")
      stream.min_intensity = floatOf(member.second, "min_intensities");
    else if (member.first == "min_log_odds")
      stream.min_log_odds = floatOf(member.second, "min_log_odds");
    else if (member.first == "remove_outliers") {
      stream.remove_outliers = toFlag(member.second);
      if (!stream.remove_outliers)
        refuse("a list whose remove_outliers are true or false");
    }
    else
      refuse("a list whose maps have topic, min_intensity, remove_outliers, "
             "min_log_odds and sensor_frame, not " +
             member.first);
  }
  return stream;
}

std::vector<StreamParameters>
readStreams(ParameterReader& reader)
{
  const auto elements = reader.list("streams");
  if (!elements) {
    StreamParameters input;
    input.topic = "input";
    return {input};
  }
  if (elements->empty())
    ParameterReader::refuse("streams", "an empty list", "a list of topics, or not set");
  std::vector<StreamParameters> streams;
  for (const XmlRpc::XmlRpcValue& element : *elements)
    streams.push_back(readStream(element));
  return streams;
}

NoiseParameters
readNoise(ParameterReader& reader)
{
  NoiseParameters noise;
  // Native intensities may be negative.
  noise.min_intensity = reader.finite("min_intensity", noise.min_intensity);
  noise.remove_outliers = reader.flag("remove_outliers", noise.remove_outliers);
  noise.min_log_odds = reader.finite("min_log_odds", noise.min_log_odds);
  for (const char* const of_streams :
       {"min_intensity_of", "remove_outliers_of", "min_log_odds_of"})
    reader.know(of_streams);
  return noise;
}

/** \brief True if the unfinished map can be written, as FusedMap does. */
bool
canWriteBeside(const std::filesystem::path& path)
{
  const std::string unfinished = FusedMap::unfinishedPath(path.string());
  if (!std::ofstream(unfinished, std::ios::binary))
    return false;
  std::error_code failure;
  return std::filesystem::remove(unfinished, failure);
}

MapParameters
readMap(ParameterReader& reader)
{
  MapParameters map;
  map.path = reader.text("map_path", "");
  map.rate = reader.number("map_rate", 1.0, 0.001, 1000);
  map.full_intensity = reader.number("map_full_intensity", 4.0, 1e-6, largest_float);
  map.tf_timeout = reader.number("tf_timeout", 0.05, 0, 10);
  if (map.path.empty())
    return map;
  // Now, not when the map of a whole day is to be written.
  const std::filesystem::path path(map.path);
  std::error_code failure;
  const bool is_there = std::filesystem::exists(path, failure);
  if ((is_there && !std::filesystem::is_regular_file(path, failure)) ||
      !canWriteBeside(path))
    ParameterReader::refuse(
        "map_path", "'" + map.path + "'", "a file in a folder that can be written to");
  return map;
}

} // namespace

DecompressorParameters
readDecompressorParameters(ParameterReader& reader)
{
  DecompressorParameters parameters;
  parameters.streams = readStreams(reader);
  parameters.global_frame =
      withoutLeadingSlash(reader.nonEmptyText("global_frame", "world"));
  parameters.noise = readNoise(reader);
  parameters.merge_rate = reader.number("merge_rate", 10, 0, 1000);
  if (parameters.merge_rate > 0 && parameters.merge_rate < 0.001)
    ParameterReader::refuse("merge_rate", "below 0.001", "0, or 0.001 to 1000");
  parameters.node.resolution = reader.number("resolution",
                                             0.04,
                                             pcl_ext::io::smallest_resolution,
                                             pcl_ext::io::largest_resolution);
  parameters.node.threads =
      static_cast<unsigned int>(reader.count("threads", 0, 0, 1024));
  parameters.node.max_waiting_frames =
      static_cast<std::size_t>(reader.count("max_waiting_frames", 40, 1, 100000));
  constexpr double nanoseconds = 1e9; // in a second
  parameters.node.max_merge_age = std::chrono::nanoseconds(static_cast<std::int64_t>(
      nanoseconds * reader.number("max_merge_age", 1, 0.001, 3600)));
  parameters.map = readMap(reader);
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace pcl_ext_ros
