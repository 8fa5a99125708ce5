/** \file
 * \brief The paper's experiment: the nodes of several sensors and a central one, at
 * once.
 */
#pragma once

#include <pcl_ext/nodes/sensor_node.h>

#include "measuring/samples.h"
#include "measuring/workload.h"

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext {
namespace report {

using measuring::InputStream;
using measuring::Samples;
using measuring::Variant;
using measuring::Workload;

/** \brief Figures of one node, those of the paper's Table 5. A sample of a rate is one
 * second. */
struct NodeFigures {
  std::string name;
  Samples frames_per_second;
  Samples megabits_per_second; ///< of coded frames
  Samples cpu_percent;         ///< of one core
  /** \brief Cloud to bytes of each frame; of the central node bytes to denoised voxels,
   * means of streams. */
  Samples cycle_ms;
  double max_cycle_ms = 0.0;
  double megabytes = 0.0; ///< resident, without the clouds
};

/** \brief Figures of a run. */
struct RunAtOnce {
  std::vector<NodeFigures> sensors;
  NodeFigures central; ///< its rates are of the frames decoded
  Samples merge_ms;
  Samples merged_voxels;
};

/** \brief A sensor, the settings of its node and its frame rate. */
struct SensorAtWork {
  InputStream stream; ///< these clouds are repeated
  nodes::SensorNodeSettings settings;
  double frame_rate; ///< Hz
};

/** \brief The six Kinect V2 of the robot cell.
 * \param[in] workload of all of them
 * \param[in] variant of all streams
 * \param[in] frames of each sensor, which are repeated
 */
std::vector<SensorAtWork>
sixKinects(const Workload& workload, const Variant& variant, std::size_t frames);

/** \brief The robot cell's lidar, with its own intensity; parameters as above. */
SensorAtWork
cellLidar(const Workload& workload, const Variant& variant, std::size_t frames);

/** \brief SensorNodes that get their clouds at their sensors' rates, each in a thread
 * of its own, and a CentralNode that merges them at the robot cell's rate.
 * \param[in] sensors at least one
 * \param[in] seconds to run
 * \param[in] min_intensity of all streams: voxels below it are removed before merging
 */
RunAtOnce
runAtOnce(const std::vector<SensorAtWork>& sensors,
          double seconds,
          float min_intensity);

} // namespace report
} // namespace pcl_ext
