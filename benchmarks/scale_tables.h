/** \file
 * \brief The tables of doc/benchmarks.md about many streams. Each function measures and
 * prints.
 */
#pragma once

#include "measuring/workload.h"

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief The command line of measure_scale. */
struct ScaleOptions {
  std::vector<std::string> recordings; ///< folders of PCD files, besides the cell's
  std::vector<Variant> variants;       ///< whose streams are sent
  std::size_t frames = 0;              ///< of each sensor of the robot cell
  double seconds = 0.0;                ///< of each run
  std::size_t most_streams = 0;        ///< to try
  double sensor_seconds = 0.0;         ///< of the run of six sensors
  std::size_t sensor_frames = 0; ///< clouds of each of the six, which are repeated
  Workload workload;
};

/** \brief The most streams that are decoded in time, on one core and on all, and the
 * most that a gigabit link carries. */
void
printManyStreams(const ScaleOptions& options, std::ostream& output);

/** \brief Six sensors at once. */
void
printSixSensors(const ScaleOptions& options, std::ostream& output);

} // namespace measuring
} // namespace pcl_ext
