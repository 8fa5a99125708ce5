#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief What the command line of compare_with_peers says. */
struct ComparisonOptions {
  std::vector<std::string> recordings; ///< folders of PCD files
  std::vector<std::string> tables;     ///< names of the tables to make
  std::size_t frames = 0;              ///< of the robot cell
  unsigned int sensor = 0;             ///< of the robot cell, 1..6
  unsigned int i_frame_rate = 0;
  std::size_t error_every = 0;   ///< frames between those whose errors are searched
  std::size_t repetitions = 0;   ///< of each stream
  std::size_t growth_frames = 0; ///< for each size
  std::size_t fewest_points = 0;
  std::size_t most_points = 0;
  std::size_t edge_points = 0; ///< of the room at which the voxel edge changes

  bool
  wants(const std::string& table) const;
};

/** \brief Reads the command line.
 * \return the options, or nothing if only the help was asked for, which is then printed
 * \throws std::exception with a sentence for the user if the line makes no sense
 */
std::optional<ComparisonOptions>
parseComparisonOptions(int argc, const char* const* argv);

} // namespace measuring
} // namespace pcl_ext
