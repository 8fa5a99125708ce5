#include "compressor_parameters.h"

#include <pcl_ext/compression/voxel_frame.h>

#include "message_conversions.h"

#include <cmath>
#include <limits>

namespace pcl_ext_ros {

namespace {

using pcl_ext::RuntimeSensor;
using pcl_ext::IntensityLaw;
namespace io = pcl_ext::io;

constexpr int most = std::numeric_limits<std::int32_t>::max();

template <typename SensorT>
RuntimeSensor
runtimeSensor(const SensorT& sensor)
{
  return {sensor.fov_x_deg, sensor.fov_y_deg, sensor.columns, sensor.rows};
}

/** \brief The sensor, by name or by its figures; none if no parameter tells it. */
std::optional<RuntimeSensor>
readSensor(ParameterReader& reader)
{
  const std::string name = reader.text("sensor", "");
  constexpr double widest = 179.9; // degrees; the tangent of half of it is finite
  constexpr double narrowest = 0.1;
  const double fov_x_deg = reader.number("sensor_fov_x_deg", 0, narrowest, widest);
  const double fov_y_deg = reader.number("sensor_fov_y_deg", 0, narrowest, widest);
  const int columns = reader.count("sensor_columns", 0, 1, 65536);
  const int rows = reader.count("sensor_rows", 0, 1, 65536);
  const int figures = (fov_x_deg > 0) + (fov_y_deg > 0) + (columns > 0) + (rows > 0);
  const std::string all_figures =
      "~sensor_fov_x_deg, ~sensor_fov_y_deg, ~sensor_columns and ~sensor_rows";
  if (!name.empty()) {
    if (figures != 0)
      ParameterReader::refuse(
          "sensor", "'" + name + "'", "left out where figures tell it: " + all_figures);
    return reader.choice<RuntimeSensor>(
        "sensor",
        "",
        {{"kinect_v2", runtimeSensor(pcl_ext::KinectV2())},
         {"kinect_v1", runtimeSensor(pcl_ext::KinectV1())},
         {"azure_kinect_nfov", runtimeSensor(pcl_ext::AzureKinectNfovUnbinned())}});
  }
  if (figures == 0)
    return std::nullopt;
  if (figures != 4)
    ParameterReader::refuse("sensor",
                            "''",
                            "a name, or told by all of " + all_figures + ", not by " +
                                std::to_string(figures) + " of them");
  return RuntimeSensor(fov_x_deg,
                       fov_y_deg,
                       static_cast<unsigned int>(columns),
                       static_cast<unsigned int>(rows));
}

/** \brief [x0, y0, z0, x1, y1, z1]; none if it is not set or empty. */
std::optional<io::BoundingBox>
readCropBox(ParameterReader& reader)
{
  const auto elements = reader.list("crop_box");
  if (!elements || elements->empty())
    return std::nullopt;
  const std::string allowed =
      "six finite numbers, [x0, y0, z0, x1, y1, z1], m, the first three below the "
      "others";
  std::string shown;
  for (const XmlRpc::XmlRpcValue& element : *elements)
    shown += (shown.empty() ? "[" : ", ") + toText(element);
  shown += "]";
  if (elements->size() != 6)
    ParameterReader::refuse("crop_box", shown, allowed);
  io::BoundingBox box;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::optional<double> corner = toNumber((*elements)[i]);
    if (!corner || !std::isfinite(*corner))
      ParameterReader::refuse("crop_box", shown, allowed);
    (i < 3 ? box.min[i] : box.max[i - 3]) = *corner;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!(box.min[axis] < box.max[axis]))
      ParameterReader::refuse("crop_box", shown, allowed);
  return box;
}

/** \brief None if outliers are to stay. */
std::optional<pcl_ext::VoxelOutlierRemovalSettings>
readOutlierRemoval(ParameterReader& reader)
{
  pcl_ext::VoxelOutlierRemovalSettings settings;
  // Allowed where outliers stay, too, so that it can be an argument of a launch file.
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
  settings.i_frame_rate =
      static_cast<unsigned int>(reader.count("i_frame_rate", 30, 0, most));
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
  settings.intensity_bits =
      static_cast<unsigned int>(reader.count("intensity_bits", 0, 0, 16));
  settings.intensity_range =
      static_cast<float>(reader.number("intensity_range", 0, 0, largest_float));
  settings.intensity_curve =
      reader.choice<io::IntensityCurve>("intensity_curve",
                                        "linear",
                                        {{"linear", io::IntensityCurve::Linear},
                                         {"companded", io::IntensityCurve::Companded}});
}

} // namespace

CompressorParameters
readCompressorParameters(ParameterReader& reader)
{
  CompressorParameters parameters;
  readCompression(reader, parameters.node.compression);
  parameters.node.law =
      reader.choice<IntensityLaw>("intensity",
                                  "count",
                                  {{"count", IntensityLaw::Count},
                                   {"quadratic", IntensityLaw::Quadratic},
                                   {"linear", IntensityLaw::Linear},
                                   {"native", IntensityLaw::Native}});
  const bool needs_sensor = parameters.node.law == IntensityLaw::Quadratic ||
                            parameters.node.law == IntensityLaw::Linear;
  const auto sensor = readSensor(reader);
  if (needs_sensor && !sensor)
    ParameterReader::refuse("sensor",
                            "not set",
                            "told, by name or figures, for ~intensity: " +
                                reader.text("intensity", "count"));
  // Allowed with the other laws, too, so that the law can be an argument of a launch file.
  if (needs_sensor)
    parameters.node.sensor = sensor;
  parameters.node.intensity_field = reader.nonEmptyText("intensity_field", "intensity");
  parameters.node.crop_box = readCropBox(reader);
  parameters.node.outlier_removal = readOutlierRemoval(reader);
  parameters.node.global_frame =
      withoutLeadingSlash(reader.nonEmptyText("global_frame", "world"));
  parameters.tf_timeout = reader.number("tf_timeout", 0.05, 0, 10);
  parameters.queue_size =
      static_cast<std::uint32_t>(reader.count("queue_size", 5, 1, 1000));
  parameters.statistics = reader.flag("statistics", false);
  reader.refuseUnknownNames();
  return parameters;
}

} // namespace pcl_ext_ros
