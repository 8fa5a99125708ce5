#pragma once

#include "measuring/workload.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief What the command line of measure_scale says. */
struct ScaleOptions {
  std::vector<std::string>
      recordings;                ///< folders of PCD files, beside the cell's sensors
  std::vector<Variant> variants; ///< whose streams are sent
  std::size_t frames = 0;        ///< of each sensor of the robot cell
  double seconds = 0.0;          ///< of each run
  std::size_t most_streams = 0;  ///< to try
  double sensor_seconds = 0.0;   ///< of the run of six sensors
  std::size_t sensor_frames = 0; ///< clouds of each of the six, which are repeated
  Workload workload;
};

/** \brief Reads the command line.
 * \return the options, or nothing if only the help was asked for, which is then printed
 * \throws std::exception with a sentence for the user if the line makes no sense
 */
std::optional<ScaleOptions>
parseScaleOptions(int argc, const char* const* argv);

} // namespace measuring
} // namespace pcl_ext
