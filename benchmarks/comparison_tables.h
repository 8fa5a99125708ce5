/** \file
 * \brief The tables of doc/benchmarks.md that compare coders. Each function measures
 * and prints.
 */
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief The command line of compare_with_peers. */
struct ComparisonOptions {
  std::vector<std::string> recordings; ///< folders of PCD files
  std::size_t frames = 0;              ///< of the robot cell
  unsigned int sensor = 0;             ///< of the robot cell, 1..6
  unsigned int i_frame_rate = 0;
  std::size_t error_every = 0;   ///< frames between two with position errors; 0: none
  std::size_t repetitions = 0;   ///< of each stream
  std::size_t growth_frames = 0; ///< for each size
  std::size_t fewest_points = 0; ///< of the sampled room
  std::size_t most_points = 0;
  std::size_t edge_points = 0; ///< of the room while the voxel edge changes
};

/** \brief All coders on the robot cell at 4 cm. */
void
printPeers(const ComparisonOptions& options, std::ostream& output);

/** \brief Each effort against the published layout and PCL's class, three workloads. */
void
printEfforts(const ComparisonOptions& options, std::ostream& output);

/** \brief Milliseconds of each stage. */
void
printStages(const ComparisonOptions& options, std::ostream& output);

/** \brief From the sensor's organised cloud to bytes, against PCL's filters and
 * class. */
void
printRawToBytes(const ComparisonOptions& options, std::ostream& output);

/** \brief Recorded streams, a row for each folder. */
void
printRecorded(const ComparisonOptions& options, std::ostream& output);

/** \brief Encoding with effort fast in one and more threads, up to one for each core, against
 * PCL's class; sampled room. */
void
printThreads(const ComparisonOptions& options, std::ostream& output);

/** \brief PCL's profiles in PCL's class and in this library's, by point type, robot
 * cell and recorded streams. */
void
printProfiles(const ComparisonOptions& options, std::ostream& output);

/** \brief Bytes and changed decisions over the bits of a count, linear and
 * companded. */
void
printBits(const ComparisonOptions& options, std::ostream& output);

/** \brief Time and bytes over the number of points. */
void
printGrowthWithPoints(const ComparisonOptions& options, std::ostream& output);

/** \brief Time and bytes over the voxel edge. */
void
printGrowthWithEdge(const ComparisonOptions& options, std::ostream& output);

} // namespace measuring
} // namespace pcl_ext
