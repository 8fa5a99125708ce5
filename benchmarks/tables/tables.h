/** \file
 * \brief The tables of doc/benchmarks.md. Each function measures and prints.
 */
#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief The sensor of the robot cell whose stream is compressed, if it is one
 * alone. */
constexpr unsigned int first_sensor = 1;

/** \brief The command line. */
struct Options {
  std::vector<std::string> recordings; ///< folders of clouds
  std::vector<std::string> tables;
  std::vector<std::string> efforts = {"fast"}; ///< of table scale
  std::size_t frames = 60;                     ///< of each sensor of the robot cell
  std::size_t repetitions = 3; ///< of each stream; the least time of each frame counts
  std::string results_file;    ///< of table points; empty: none
  std::vector<double> edges = {0.001, 0.01, 0.04}; ///< of table points, metres
  std::string cloudini;           ///< of table points: its converter; empty: left out
  double seconds = 5.0;           ///< of each run of table scale
  std::size_t most_streams = 800; ///< that table scale tries
  /** \brief Of table scale: log-odds below which the sensors remove a voxel as
   * noise. */
  std::optional<float> outlier_removal;
  unsigned int temporal_filter = 0; ///< of table scale: the sensors', frames; 0: none
};

/** \brief Each effort against the published layout and PCL's class, three workloads. */
void
printEfforts(const Options& options, std::ostream& output);

/** \brief From the sensor's organised cloud to bytes, against PCL's filters and
 * class. */
void
printFromSensor(const Options& options, std::ostream& output);

/** \brief All coders on the robot cell at 4 cm, with allocations and errors. */
void
printPeers(const Options& options, std::ostream& output);

/** \brief All coders on recorded streams. */
void
printRecorded(const Options& options, std::ostream& output);

/** \brief All points of recorded streams, coordinates alone, with the same largest error
 * in all coders. */
void
printPoints(const Options& options, std::ostream& output);

/** \brief PCL's profiles in PCL's class and in this library's, by point type, robot
 * cell and recorded streams. */
void
printProfiles(const Options& options, std::ostream& output);

/** \brief The most streams that are decoded in time, on one core and on all, and the
 * most that a gigabit link carries. */
void
printScale(const Options& options, std::ostream& output);

} // namespace measuring
} // namespace pcl_ext
