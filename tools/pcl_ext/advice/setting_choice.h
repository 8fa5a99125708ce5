// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Which voxel edge and effort suit a stream.
 */
#pragma once

#include <pcl_ext/compression/compression_settings.h>

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief What a stream takes with an edge and an effort. */
struct EffortTrial {
  double kilobits = 0.0;   ///< a second
  double ms = 0.0;         ///< of encoding a cloud, on this machine, median
  double least_rate = 0.0; ///< kbit/s, the lowest max_rate that it keeps within
};

/** \brief A stream with voxels of one edge. */
struct EdgeTrial {
  double edge = 0.0;           ///< metres
  double points_a_voxel = 0.0; ///< 0: all points are in order, without voxels
  double holes = 0.0;          ///< share of the surfaces' points, 0 to 1
  std::optional<double>
      noise; ///< share that would be removed, 0 to 1; none: not judged
  /** \brief By Effort; none: it was not tried. */
  std::array<std::optional<EffortTrial>, io::efforts.size()> efforts;
  std::string points_outside_grid; ///< see describePointsOutsideGrid()
};

/** \brief What a choice must keep to. */
struct ChoiceLimits {
  static constexpr double usual_holes = 0.25;
  static constexpr double busy_share = 0.5; ///< of the period, for encoding
  double most_holes = usual_holes;
  std::optional<double> kilobits; ///< of EffortTrial::least_rate
  double period = 0.0;            ///< seconds from cloud to cloud
};

/** \brief What keeps a choice from being a good one, the most important one last. */
enum class ChoiceFault { None, Holes, Time, Rate };

/** \brief An edge and an effort. */
struct Choice {
  std::size_t edge = 0; ///< number of the trial
  io::Effort effort = io::Effort::Balanced;
  ChoiceFault fault = ChoiceFault::None;
};

/** \brief The finest edge that keeps the limits; at that edge effort balanced if that
 * keeps them, else small, else fast. If nothing keeps them all, they are given up one
 * after the other: that on holes for the largest edge, that on time for what is
 * fastest, that on the rate for the fewest bytes.
 * \param[in] trials by ascending edges, at least one, each with an effort
 */
Choice
choose(const std::vector<EdgeTrial>& trials, const ChoiceLimits& limits);

} // namespace pcl_ext::tools
