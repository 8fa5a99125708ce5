#include "stream_options.h"

#include "measuring/command_line.h"

#include <boost/program_options.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

namespace options = boost::program_options;

/** \brief Reads numbers with commas between them.
 * \param[in] option for messages
 * \param[in] text the numbers
 * \param[in] names of the numbers, with commas between them
 * \throws std::invalid_argument unless there is a number for each name
 */
std::vector<double>
parseNumbers(const std::string& option,
             const std::string& text,
             const std::string& names)
{
  std::vector<double> numbers;
  std::istringstream stream(text);
  std::string number;
  while (std::getline(stream, number, ',')) {
    std::size_t used = 0;
    try {
      numbers.push_back(std::stod(number, &used));
    }
    catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || used != number.size())
      throw std::invalid_argument("--" + option + ": '" + number + "' is not a number");
  }
  const auto count =
      static_cast<std::size_t>(std::count(names.begin(), names.end(), ',')) + 1;
  if (numbers.size() != count)
    throw std::invalid_argument("--" + option + " needs " + std::to_string(count) +
                                " numbers, " + names + ", not " +
                                std::to_string(numbers.size()));
  return numbers;
}

/** \brief Reads x0,y0,z0,x1,y1,z1. */
io::BoundingBox
parseBox(const std::string& text)
{
  const std::vector<double> corners = parseNumbers("crop", text, "x0,y0,z0,x1,y1,z1");
  io::BoundingBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = corners[axis];
    box.max[axis] = corners[axis + 3];
  }
  return box;
}

measuring::Choices<std::optional<IntensityLaw>>
lawChoices()
{
  measuring::Choices<std::optional<IntensityLaw>> choices = {{"auto", std::nullopt}};
  // Its clouds are of a type with intensities; without a law all of them would be 1.
  for (const NamedIntensityLaw& named : intensity_laws)
    if (named.law != IntensityLaw::None)
      choices.emplace_back(named.name, named.law);
  return choices;
}

/** \brief Reads the name of a sensor, or its figures. */
RuntimeSensor
parseSensor(const std::string& text)
{
  if (text.find(',') == std::string::npos) {
    measuring::Choices<RuntimeSensor> choices;
    for (const NamedSensor& named : named_sensors)
      choices.emplace_back(named.name, named.sensor);
    return measuring::valueNamed("sensor", text, choices);
  }
  const std::vector<double> figures =
      parseNumbers("sensor", text, "horizontal degrees,vertical degrees,columns,rows");
  const auto pixels = [](double number) {
    return measuring::checkedCount(
        "sensor", std::isfinite(number) ? std::int64_t(number) : 0, 1, 1 << 16);
  };
  return RuntimeSensor(figures[0], figures[1], pixels(figures[2]), pixels(figures[3]));
}

options::options_description
describeOptions(StreamOptions& result)
{
  using measuring::choice;
  using measuring::count;
  options::options_description description(
      "Compresses, decompresses and denoises a stream of point clouds and prints its "
      "size and times.\nUsage: pcl_ext_stream [options] [PCD file or folder ...]\n"
      "Without input: frames of the simulated robot cell. Each folder is a stream; all "
      "single files together are one.\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and exit");
  option("input", options::value(&result.inputs), "PCD files and folders");
  option("output,o",
         options::value(&result.output_folder)->default_value("out"),
         "folder for the decoded and the denoised clouds; '' for none");
  option("frames,n",
         count("frames", result.frames, 1),
         "frames of the cell (default 100), or of each input at most (default all)");
  option("resolution,r",
         options::value(&result.settings.resolution)->default_value(0.04, "0.04"),
         "voxel edge, m");
  option("intensity,i",
         choice("intensity", result.law, lawChoices())->default_value("auto"),
         "auto (native if the input has an intensity, else count), count, quadratic, "
         "linear or native");
  option("sensor",
         options::value<std::string>()
             ->default_value("kinect_v2")
             ->notifier([&result](const std::string& sensor) {
               result.sensor = parseSensor(sensor);
             }),
         "for quadratic and linear: kinect_v2, kinect_v1, azure_kinect_nfov, or "
         "field of view and image of another one: degrees,degrees,columns,rows");
  option("format,f",
         choice<io::StreamFormat>("format",
                                  result.settings.format,
                                  {{"version1", io::StreamFormat::Version1},
                                   {"published", io::StreamFormat::Published}})
             ->default_value("version1"),
         "version1 or published");
  option("i-frame-rate",
         count("i-frame-rate", result.settings.i_frame_rate, 0)->default_value(30),
         "frames from one I-frame to the next");
  option("bits",
         count("bits", result.settings.intensity_bits, 0, 16)->default_value(0),
         "bits of an intensity, 1 to 16; 0: automatic");
  option("colour-bits",
         count("colour-bits", result.settings.colour_bits, 0, 8)->default_value(6),
         "bits of a colour channel, 1 to 8, where the input has rgb or rgba; 0: no "
         "colours");
  option("effort,e",
         choice<io::Effort>("effort",
                            result.settings.effort,
                            {{"fast", io::Effort::Fast},
                             {"balanced", io::Effort::Balanced},
                             {"small", io::Effort::Small}})
             ->default_value("balanced"),
         "fast, balanced or small: time against size");
  option("curve",
         choice<io::IntensityCurve>("curve",
                                    result.settings.intensity_curve,
                                    {{"linear", io::IntensityCurve::Linear},
                                     {"companded", io::IntensityCurve::Companded}})
             ->default_value("linear"),
         "linear, or companded: small intensities are exact, larger ones are rounded; "
         "--bits 0 is then 4");
  option("threshold,t",
         options::value<float>()->notifier([&result](float threshold) {
           if (!std::isfinite(threshold))
             throw std::invalid_argument("--threshold must be a finite number");
           result.threshold = threshold;
         }),
         "least intensity that denoising keeps, instead of the outlier filter");
  option("crop",
         options::value<std::string>()->notifier(
             [&result](const std::string& box) { result.crop_box = parseBox(box); }),
         "x0,y0,z0,x1,y1,z1: keep only this box, m (default: the cell's own for the "
         "cell, none for inputs)");
  option("cell-sensor",
         count("cell-sensor", result.cell_sensor, 1, 6)->default_value(1),
         "sensor of the cell, 1 to 6");
  option("seed",
         count("seed", result.seed, 0)->default_value(1),
         "seed of the cell's random errors");
  return description;
}

} // namespace

std::optional<StreamOptions>
parseOptions(int argc, const char* const* argv)
{
  StreamOptions result;
  options::variables_map values;
  if (!measuring::parseCommandLine(
          argc, argv, describeOptions(result), "input", values))
    return std::nullopt;
  if (values.count("frames") == 0 && result.inputs.empty())
    result.frames = 100;
  return result;
}

} // namespace tools
} // namespace pcl_ext
