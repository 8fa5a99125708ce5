/** \file
 * \brief What the filters of outliers cost.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {

namespace report {
class ResultFile;
}

namespace noise {

/** \brief Processor time that one filter took for each frame of a stream. */
struct FilterTimes {
  std::string filter;
  std::vector<double> milliseconds; ///< of each frame
};

/** \brief What was timed, on one sensor's stream. */
struct TimedFilters {
  unsigned int sensor = 0;
  double resolution = 0.0; ///< voxel edge, metres
  double voxels = 0.0;     ///< mean of the frames
  std::vector<FilterTimes> filters;
};

/** \brief Lets VoxelOutlierRemoval and PCL's filters take turns, frame by frame. */
TimedFilters
measureFilterTimes(std::uint32_t seed,
                   unsigned int sensor,
                   std::uint32_t frames,
                   double resolution);

/** \brief The middle one, or the upper one of two; of at least one. */
double
medianOf(std::vector<double> values);

/** \brief Prints median and longest time as Markdown. */
void
print(const TimedFilters& timed, std::ostream& output);

/** \brief Adds the same to the results, experiment `noise_time`. */
void
addResults(const TimedFilters& timed, report::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
