/** \file
 * \brief How well methods distinguish noise from surfaces on labelled scans of lidars.
 */
#pragma once

#include "labelled_scans.h"
#include "scan_methods.h"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief Bands of range of a lidar outdoors, metres; the last one has no end. */
constexpr std::array<float, 4> range_band_ends = {10.0f, 20.0f, 40.0f, 1e9f};

/** \brief Which scans are judged, as which voxels. */
struct ScanRange {
  std::string sensor; ///< name for results, without a comma
  std::size_t first = 0;
  std::size_t count = 0;
  std::vector<double> resolutions; ///< voxel edges, metres
};

/** \brief Scores scans with a method and adds the results, as addResults() has them:
 * experiment `scan_voxels` for voxels of each edge and `scan_points` for points. Where
 * points are scored, a voxel's score is the highest of its points; where voxels are,
 * that of a point is its voxel's, and the points' results are of each edge.
 *
 * Experiment `scan_time`: `points`, those with a return, and of the scores' processor
 * time `median_ms` and `longest_ms` of a scan, without reading and voxelizing.
 * \throws std::runtime_error if a scan or what the method needs cannot be read
 */
void
judgeScans(LabelledScans& scans,
           const ScanRange& range,
           const ScanMethod& method,
           measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
