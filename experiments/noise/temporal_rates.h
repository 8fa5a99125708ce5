/** \file
 * \brief What TemporalVoxelFilter shows of the robot cell's clouds at other rates of frames
 * and with other noise, as an encoder gets them.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief A stream of one sensor. */
struct RateOptions {
  std::uint32_t seed = 1;
  std::uint32_t frames = 40; ///< of which the last half is judged
  double resolution = 0.04;  ///< voxel edge, metres
  /** \brief Each n-th frame of the sensor, so that its rate is an n-th. */
  std::uint32_t step = 1;
  /** \brief Standard deviation of a camera's depth d, metres: a + b d + c d^2
   * millimetres, 1.5 times as much in the corners; all 0: the simulator's. */
  std::array<double, 3> depth_noise{};
};

/** \brief Encodes a stream with stamps and poses, with the filter and without, and adds
 * the results, experiment `rates` and the rate. README.md beside this file has the
 * quantities. The cameras 1 to 6 have the crop, and all points are given to the encoder.
 * \param[in] sensor 1 to 6, cell::RobotCell::lidar or hand_camera; the last two without
 * a crop
 * \throws std::runtime_error if a cloud cannot be encoded
 */
void
measureRates(unsigned int sensor,
             const RateOptions& options,
             measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
