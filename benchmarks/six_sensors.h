/** \file
 * \brief The paper's experiment: six sensors' nodes and a central one, at once.
 */
#pragma once

#include "workload.h"

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext {
namespace benchmarks {

/** \brief What one node needed, as the paper's Table 5 asks. */
struct NodeFigures {
  std::string name;
  double frames_per_second = 0.0;
  double megabits_per_second = 0.0; ///< of coded frames
  double mean_cycle_ms = 0.0;       ///< cloud to bytes, or bytes to denoised voxels
  double max_cycle_ms = 0.0;
  double cpu_percent = 0.0; ///< of one core
  double megabytes = 0.0;   ///< resident, beside the clouds themselves
};

/** \brief Six SensorNodes that get their clouds at the cell's rate, each in a thread of its
 * own, and a CentralNode that merges them at that rate, too.
 * \param[in] workload of all sensors
 * \param[in] variant of all streams
 * \param[in] frames of each sensor, which are repeated
 * \param[in] seconds to run
 * \return the sensors', then the central node's with the sums of the streams
 */
std::vector<NodeFigures>
runSixSensors(const Workload& workload,
              const Variant& variant,
              std::size_t frames,
              double seconds);

} // namespace benchmarks
} // namespace pcl_ext
