#include "stream_options.h"

#include <boost/program_options.hpp>

#include <iostream>
#include <map>
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

io::BoundingBox
parseBox(const std::vector<double>& corners)
{
  if (corners.size() != 6)
    throw std::invalid_argument("--crop needs six numbers: x0 y0 z0 x1 y1 z1");
  io::BoundingBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = corners[axis];
    box.max[axis] = corners[axis + 3];
  }
  return box;
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
         options::value(&result.frames),
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
         options::value(&result.settings.i_frame_rate)->default_value(30),
         "frames from one I-frame to the next");
  option("bits",
         options::value(&result.settings.intensity_bits)->default_value(0),
         "bits of an intensity, 1 to 16; 0: automatic");
  option("threshold,t",
         options::value<float>(),
         "least intensity that denoising keeps (default: count 2, quadratic and linear "
         "64, native 0)");
  option("crop",
         options::value<std::vector<double>>()->multitoken(),
         "x0 y0 z0 x1 y1 z1: keep only this box, m (default: the cell's own for the "
         "cell, none for inputs)");
  option("cell-sensor",
         options::value(&result.cell_sensor)->default_value(1),
         "sensor of the cell, 1 to 6");
  option("seed",
         options::value(&result.seed)->default_value(1),
         "of the cell's random errors");
  return description;
}

} // namespace

std::optional<StreamOptions>
parseOptions(int argc, const char* const* argv)
{
  StreamOptions result;
  const options::options_description description = describeOptions(result);
  options::positional_options_description positional;
  positional.add("input", -1);
  options::variables_map values;
  options::store(options::command_line_parser(argc, argv)
                     .options(description)
                     .positional(positional)
                     .run(),
                 values);
  if (values.count("help") != 0) {
    std::cout << description << '\n';
    return std::nullopt;
  }
  options::notify(values);
  if (values.count("frames") == 0 && result.inputs.empty())
    result.frames = 100;
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
  if (values.count("threshold") != 0)
    result.threshold = values["threshold"].as<float>();
  if (values.count("crop") != 0)
    result.crop_box = parseBox(values["crop"].as<std::vector<double>>());
  return result;
}

} // namespace tools
} // namespace pcl_ext
