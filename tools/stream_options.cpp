#include "stream_options.h"

#include "measuring/command_line.h"

#include <boost/program_options.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

namespace options = boost::program_options;

/** \brief The value that a name stands for.
 * \throws std::invalid_argument naming the option and what it knows
 */
template <typename ValueT>
ValueT
lookUp(const std::string& option,
       const std::string& name,
       const std::map<std::string, ValueT>& values)
{
  const auto entry = values.find(name);
  if (entry != values.end())
    return entry->second;
  std::string known;
  for (const auto& value : values)
    known += " " + value.first;
  throw std::invalid_argument("--" + option + " knows no '" + name +
                              "'; it knows:" + known);
}

template <typename SensorT>
RuntimeSensor
runtimeSensor(const SensorT& sensor)
{
  return {sensor.fov_x_deg, sensor.fov_y_deg, sensor.columns, sensor.rows};
}

/** \brief Reads x0,y0,z0,x1,y1,z1. */
io::BoundingBox
parseBox(const std::string& text)
{
  std::vector<double> corners;
  std::istringstream stream(text);
  std::string number;
  while (std::getline(stream, number, ',')) {
    std::size_t used = 0;
    try {
      corners.push_back(std::stod(number, &used));
    }
    catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || used != number.size())
      throw std::invalid_argument("--crop: '" + number + "' is not a number");
  }
  if (corners.size() != 6)
    throw std::invalid_argument("--crop needs six numbers, x0,y0,z0,x1,y1,z1, not " +
                                std::to_string(corners.size()));
  io::BoundingBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = corners[axis];
    box.max[axis] = corners[axis + 3];
  }
  return box;
}

/** \brief The value of an option that counts something.
 * \throws std::invalid_argument naming the option and its range
 */
unsigned int
parseCount(const options::variables_map& values,
           const std::string& option,
           std::int64_t lowest,
           std::int64_t highest)
{
  return measuring::checkedCount(
      option, values[option].as<std::int64_t>(), lowest, highest);
}

options::options_description
describeOptions(StreamOptions& result)
{
  options::options_description description(
      "Compresses, decompresses and denoises a stream of point clouds and prints what "
      "it "
      "cost.\nUsage: pcl_ext_stream [options] [PCD file or folder ...]\n"
      "Without input: frames of the simulated robot cell. A folder is a stream of its "
      "own, "
      "all files named singly are one.\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and stop");
  option("input", options::value(&result.inputs), "PCD files and folders");
  option("output,o",
         options::value(&result.output_folder)->default_value("out"),
         "folder for the decoded and the denoised clouds; '' for none");
  option("frames,n",
         options::value<std::int64_t>(),
         "frames of the cell (default 100), or of each input at most (default all)");
  option("resolution,r",
         options::value(&result.settings.resolution)->default_value(0.04),
         "voxel edge, m");
  option("intensity,i",
         options::value<std::string>()->default_value("auto"),
         "auto (native if the input has an intensity, else count), count, quadratic, "
         "linear or native");
  option("sensor",
         options::value<std::string>()->default_value("kinect_v2"),
         "for quadratic and linear: kinect_v2, kinect_v1 or azure_kinect_nfov");
  option("format,f",
         options::value<std::string>()->default_value("version1"),
         "version1 or published");
  option("i-frame-rate",
         options::value<std::int64_t>()->default_value(30),
         "frames from one I-frame to the next");
  option("bits",
         options::value<std::int64_t>()->default_value(0),
         "bits of an intensity, 1 to 16; 0: automatic");
  option("effort,e",
         options::value<std::string>()->default_value("balanced"),
         "fast, balanced or small: time against size");
  option("curve",
         options::value<std::string>()->default_value("linear"),
         "linear or companded: small intensities exact, steps that grow above them; "
         "--bits 0 is then 4");
  option("threshold,t",
         options::value<float>(),
         "least intensity that denoising keeps (default: count 2, quadratic and linear "
         "64, native 0)");
  option("crop",
         options::value<std::string>(),
         "x0,y0,z0,x1,y1,z1: keep only this box, m (default: the cell's own for the "
         "cell, none for inputs)");
  option("cell-sensor",
         options::value<std::int64_t>()->default_value(1),
         "sensor of the cell, 1 to 6");
  option("seed",
         options::value<std::int64_t>()->default_value(1),
         "of the cell's random errors");
  return description;
}

} // namespace

std::optional<StreamOptions>
parseOptions(int argc, const char* const* argv)
{
  StreamOptions result;
  const options::options_description description = describeOptions(result);
  options::variables_map values;
  if (!measuring::parseCommandLine(argc, argv, description, "input", values))
    return std::nullopt;
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  if (values.count("frames") != 0)
    result.frames = parseCount(values, "frames", 1, most);
  else if (result.inputs.empty())
    result.frames = 100;
  result.settings.i_frame_rate = parseCount(values, "i-frame-rate", 0, most);
  result.settings.intensity_bits = parseCount(values, "bits", 0, 16);
  result.cell_sensor = parseCount(values, "cell-sensor", 1, 6);
  result.seed = parseCount(values, "seed", 0, most);
  result.law = lookUp<Law>("intensity",
                           values["intensity"].as<std::string>(),
                           {{"auto", Law::Automatic},
                            {"count", Law::Count},
                            {"quadratic", Law::Quadratic},
                            {"linear", Law::Linear},
                            {"native", Law::Native}});
  result.sensor = lookUp<RuntimeSensor>(
      "sensor",
      values["sensor"].as<std::string>(),
      {{"kinect_v2", runtimeSensor(KinectV2())},
       {"kinect_v1", runtimeSensor(KinectV1())},
       {"azure_kinect_nfov", runtimeSensor(AzureKinectNfovUnbinned())}});
  result.settings.format =
      lookUp<io::StreamFormat>("format",
                               values["format"].as<std::string>(),
                               {{"version1", io::StreamFormat::Version1},
                                {"published", io::StreamFormat::Published}});
  result.settings.effort = lookUp<io::Effort>("effort",
                                              values["effort"].as<std::string>(),
                                              {{"fast", io::Effort::Fast},
                                               {"balanced", io::Effort::Balanced},
                                               {"small", io::Effort::Small}});
  result.settings.intensity_curve =
      lookUp<io::IntensityCurve>("curve",
                                 values["curve"].as<std::string>(),
                                 {{"linear", io::IntensityCurve::Linear},
                                  {"companded", io::IntensityCurve::Companded}});
  if (values.count("threshold") != 0) {
    result.threshold = values["threshold"].as<float>();
    if (!std::isfinite(*result.threshold))
      throw std::invalid_argument("--threshold must be a finite number");
  }
  if (values.count("crop") != 0)
    result.crop_box = parseBox(values["crop"].as<std::string>());
  return result;
}

} // namespace tools
} // namespace pcl_ext
