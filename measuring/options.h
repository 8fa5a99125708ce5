// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The command line of the program benchmark, which all of its tables share.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief The command line. A table ignores what it does not need. */
struct Options {
  std::vector<std::string> recordings; ///< folders of clouds
  std::vector<std::string> tables;
  std::vector<std::string> efforts = {"fast"}; ///< of tables scale, centre and at_once
  std::size_t frames = 60;                     ///< of each sensor of the robot cell
  std::size_t repetitions = 3; ///< of each stream; the least time of each frame counts
  std::vector<double> edges;   ///< voxel edges, metres; empty: the table's own
  std::string cloudini;        ///< of table points: its converter; empty: left out
  double seconds = 5.0;        ///< of each run of tables scale, centre and at_once
  std::size_t most_streams = 800; ///< that tables scale and centre try
  /** \brief Of table scale: log-odds below which the sensors remove a voxel as
   * noise. */
  std::optional<float> outlier_removal;
  unsigned int temporal_filter =
      0; ///< of tables scale, centre: the sensors', frames; 0: none

  std::vector<unsigned int> sensors; ///< of the robot cell; empty: all of the table
  std::uint32_t seed = 1;            ///< of the robot cell
  std::vector<std::string> methods;  ///< of tables of noise: parts of names; empty: all
  std::string weather = "none";      ///< of table lidar_noise: none, snow or dust
  std::string folder;                ///< of table pictures: where to write
  std::vector<double> rates = {20.0, 5.0, 1.0}; ///< of table rate: of links, Mbit/s
  double wireless = 8.0;      ///< of table rate: highest rate of a Wi-Fi; 0: none
  double rate_buffer = 0.25;  ///< of table rate: seconds
  bool changes_scene = false; ///< of table rate: from the middle on the sensor moves

  std::vector<double>
  edgesOr(std::vector<double> usual) const
  {
    return edges.empty() ? usual : edges;
  }

  std::vector<unsigned int>
  sensorsOr(std::vector<unsigned int> usual) const
  {
    return sensors.empty() ? usual : sensors;
  }
};

/** \brief A table: its name on the command line, and the function that measures it and
 * prints Markdown, or results as Results has them. */
struct Table {
  const char* name;
  void (*print)(const Options&, std::ostream&);
};

} // namespace measuring
} // namespace pcl_ext
