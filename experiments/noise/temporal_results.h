/** \file
 * \brief What TemporalVoxelFilter does to the streams of the robot cell.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief Number of the camera on the hand of a robot, beside cell::RobotCell's. */
constexpr unsigned int hand_camera = 8;

/** \brief Measures one sensor's streams without a filter, with VoxelOutlierRemoval at
 * log-odds 0, with TemporalVoxelFilter, and with both; adds the results, experiment
 * `temporal:` and law. README.md beside this file has the quantities.
 * \param[in] sensor 1 to 6, cell::RobotCell::lidar or \ref hand_camera
 * \param[in] resolution voxel edge, metres; without it 4 cm with each law of the
 * sensor, and of the sensors 1 to 6 also 2 cm with counts
 * \param[in] samples folder that gets the samples of the first of these streams, see
 * TemporalSamples; empty: none
 * \throws std::runtime_error if a frame cannot be filtered, encoded or decoded, or
 * the samples cannot be written
 */
void
measureTemporalFilter(std::uint32_t seed,
                      unsigned int sensor,
                      std::uint32_t frames,
                      std::optional<double> resolution,
                      const std::string& samples,
                      measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
