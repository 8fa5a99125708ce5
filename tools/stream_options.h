#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/intensity/intensity_law.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

/** \brief The command line. */
struct StreamOptions {
  std::vector<std::string> inputs; ///< PCD files and folders; empty: the robot cell
  std::string output_folder;       ///< for decoded clouds; empty: none
  unsigned int frames = 0;         ///< of the cell; of inputs at most, 0: all
  unsigned int cell_sensor = 1;    ///< 1..6
  std::uint32_t seed = 1;
  /** \brief None: native if the clouds have an intensity, else count. */
  std::optional<IntensityLaw> law;
  RuntimeSensor sensor = runtimeSensor(KinectV2());
  /** \brief Least intensity that denoising keeps; none: the outlier filter denoises. */
  std::optional<float> threshold;
  std::optional<io::BoundingBox> crop_box;
  io::IntensityCompressionSettings settings;
};

/** \brief Reads the command line.
 * \return the options, or nothing if only the help was asked for, which is then printed
 * \throws std::exception with a message for the user if the command line is invalid
 */
std::optional<StreamOptions>
parseOptions(int argc, const char* const* argv);

} // namespace tools
} // namespace pcl_ext
