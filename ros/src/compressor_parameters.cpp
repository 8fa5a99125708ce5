#include <pcl_ext/compression/voxel_grid.h>

#include "message_conversions.h"
#include "node_parameters.h"
#include "parameter_reader.h"

#include <cmath>

namespace pcl_ext_ros {

namespace {

using pcl_ext::IntensityLaw;
using pcl_ext::RuntimeSensor;
namespace io = pcl_ext::io;

/** \brief The sensor, by its name or by its four numbers; nothing if none is set. */
std::optional<RuntimeSensor>
readSensor(ParameterReader& reader)
{
  const std::string name = reader.text("sensor", "");
  constexpr double widest = 179.9; // degrees; the tangent of its half is finite
  constexpr double narrowest = 0.1;
  const double fov_x_deg = reader.number("sensor_fov_x_deg", 0, narrowest, widest);
  const double fov_y_deg = reader.number("sensor_fov_y_deg", 0, narrowest, widest);
  const std::uint32_t columns = reader.count("sensor_columns", 0, 1, 65536);
  const std::uint32_t rows = reader.count("sensor_rows", 0, 1, 65536);
  const int numbers = (fov_x_deg > 0) + (fov_y_deg > 0) + (columns > 0) + (rows > 0);
  const std::string all_numbers =
      "~sensor_fov_x_deg, ~sensor_fov_y_deg, ~sensor_columns and ~sensor_rows";
  if (!name.empty()) {
    if (numbers != 0)
      ParameterReader::refuse(
          "sensor", "'" + name + "'", "unset where one is set of " + all_numbers);
    std::map<std::string, RuntimeSensor> sensors;
    for (const auto& [sensor, sensor_name] : pcl_ext::named_sensors)
      sensors.emplace(sensor_name, sensor);
    return reader.choice("sensor", "", sensors);
  }
  if (numbers == 0)
    return std::nullopt;
  if (numbers != 4)
    ParameterReader::refuse("sensor", "not set", "set, or else all of " + all_numbers);
  return RuntimeSensor(fov_x_deg, fov_y_deg, columns, rows);
}

/** \brief [x0, y0, z0, x1, y1, z1]; nothing if it is not set or empty. */
std::optional<io::BoundingBox>
readCropBox(ParameterReader& reader)
{
  const auto elements = reader.list("crop_box");
  if (!elements || elements->empty())
    return std::nullopt;
  std::string shown;
  for (const XmlRpc::XmlRpcValue& element : *elements)
    shown += (shown.empty() ? "[" : ", ") + toText(element);
  const auto check = [&shown](bool is_right) {
    if (!is_right)
      ParameterReader::refuse("crop_box",
                              shown + "]",
                              "six finite numbers, [x0, y0, z0, x1, y1, z1], m, the "
                              "first three below the others");
  };
  check(elements->size() == 6);
  io::BoundingBox box;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::optional<double> corner = toNumber((*elements)[i]);
    check(corner && std::isfinite(*corner));
    (i < 3 ? box.min[i] : box.max[i - 3]) = *corner;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    check(box.min[axis] < box.max[axis]);
  return box;
}

/** \brief Nothing if outliers are not removed. */
std::optional<pcl_ext::VoxelOutlierRemovalSettings>
readOutlierRemoval(ParameterReader& reader)
{
  pcl_ext::VoxelOutlierRemovalSettings settings;
  // Read in any case, so that a launch file can always set it.
  settings.min_log_odds = reader.finite("min_log_odds", settings.min_log_odds);
  if (!reader.flag("remove_outliers", false))
    return std::nullopt;
  return settings;
}

void
readCompression(ParameterReader& reader, io::IntensityCompressionSettings& settings)
{
  settings.resolution = reader.number(
      "resolution", 0.04, io::smallest_resolution, io::largest_resolution);
  settings.i_frame_rate = reader.count("i_frame_rate", 30, 0, largest_int);
  settings.effort = reader.choice<io::Effort>("effort",
                                              "balanced",
                                              {{"fast", io::Effort::Fast},
                                               {"balanced", io::Effort::Balanced},
                                               {"small", io::Effort::Small}});
  settings.format =
      reader.choice<io::StreamFormat>("format",
                                      "version1",
                                      {{"version1", io::StreamFormat::Version1},
                                       {"published", io::StreamFormat::Published}});
  settings.aggregation =
      reader.choice<io::Aggregation>("aggregation",
                                     "automatic",
                                     {{"automatic", io::Aggregation::Automatic},
                                      {"sum", io::Aggregation::Sum},
                                      {"mean", io::Aggregation::Mean}});
  settings.intensity_bits = reader.count("intensity_bits", 0, 0, 16);
  settings.intensity_range =
      static_cast<float>(reader.number("intensity_range", 0, 0, largest_float));
  settings.colour_bits = reader.count("colour_bits", 6, 0, 8);
  settings.intensity_curve =
      reader.choice<io::IntensityCurve>("intensity_curve",
                                        "linear",
                                        {{"linear", io::IntensityCurve::Linear},
                                         {"companded", io::IntensityCurve::Companded}});
}

IntensityLaw
readLaw(ParameterReader& reader)
{
  std::map<std::string, IntensityLaw> laws;
  for (const auto& [law, name] : pcl_ext::intensity_laws)
    laws[name] = law;
  return reader.choice("intensity", pcl_ext::nameOf(IntensityLaw::Count), laws);
}

} // namespace

CompressorParameters
readCompressorParameters()
{
  ParameterReader reader;
  CompressorParameters parameters;
  pcl_ext::nodes::SensorNodeSettings& node = parameters.node;
  readCompression(reader, node.compression);
  node.law = readLaw(reader);
  // Read in any case, so that a launch file can set it with any law.
  const auto sensor = readSensor(reader);
  if (pcl_ext::needsSensor(node.law)) {
    if (!sensor)
      ParameterReader::refuse("sensor",
                              "not set",
                              "set, by name or by numbers, for ~intensity: " +
                                  pcl_ext::nameOf(node.law));
    node.sensor = sensor;
  }
  node.intensity_field = reader.nonEmptyText("intensity_field", "intensity");
  node.crop_box = readCropBox(reader);
  node.outlier_removal = readOutlierRemoval(reader);
  node.global_frame = reader.frame("global_frame", "world");
  node.clock = rosTimeNow;
  parameters.tf_timeout = reader.number("tf_timeout", 0.05, 0, 10);
  parameters.queue_size = reader.count("queue_size", 5, 1, 1000);
  parameters.statistics = reader.flag("statistics", false);
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace pcl_ext_ros
