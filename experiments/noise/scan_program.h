/** \file
 * \brief The part of measure_noise that judges labelled scans of lidars.
 */
#pragma once

#include "labelled_scans.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief Options of that part alone. */
struct ScanOptions {
  std::string folder; ///< of labelled scans; empty: the robot cell's lidar
  /** \brief Name of the robot cell's lidar for results, without a comma. */
  std::string cell_sensor = std::to_string(cell::RobotCell::lidar);
  LabelMeanings meanings;
  std::uint32_t rows = 1; ///< of the images that .bin files are; 1: they are none
  std::size_t first_frame = 0;
  std::optional<double> azimuth_step; ///< of the lidar, degrees
  std::optional<double> ring_step;    ///< the same between rings
  std::string predictions;            ///< folder; empty: none
  std::vector<std::string> methods;   ///< parts of their names; empty: all
};

void
addScanOptions(CLI::App& program, ScanOptions& options);

/** \brief Judges all methods on the scans of a folder, or on the cell's lidar.
 * \param[in] cell whose lidar is judged without a folder
 * \param[in] most_frames of a folder with fewer all are judged
 * \param[in] resolutions voxel edges, metres; empty: 5, 10, 20 cm
 * \throws std::runtime_error if scans cannot be read
 * \throws std::invalid_argument if no method has such a name
 */
void
measureScans(const ScanOptions& options,
             const cell::RobotCell& cell,
             std::size_t most_frames,
             std::vector<double> resolutions,
             measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
