/** \file
 * \brief The figures of each method, as values, as tables and as results.
 */
#pragma once

#include "methods.h"

#include <array>
#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {

namespace report {
class ResultFile;
}

namespace noise {

/** \brief A decision, and what it leaves of the person. */
struct DecisionFigures {
  Decision decision;
  PersonKept person;
};

/** \brief What there is in a band of depth, and how well noise is told there. */
struct BandFigures {
  VoxelNumbers numbers;
  double average_precision = 0.0;
  Decision usual; ///< at the threshold of all depths
};

/** \brief How well a method tells noise from surfaces. */
struct MethodFigures {
  std::string method;
  double noise_share = 0.0;
  double average_precision = 0.0;
  DecisionFigures best;  ///< of the best F1
  DecisionFigures usual; ///< where 95 % of the surfaces' voxels stay
  std::vector<DecisionFigures> thresholds;
  std::array<BandFigures, band_count> bands;
  std::vector<double> precisions; ///< over recall, in steps of curve_steps
};

constexpr std::size_t curve_steps = 50;

/** \brief The figures of all methods, each of which is forgotten on the way: of many
 * frames the voxels are many. */
std::vector<MethodFigures>
figuresOf(std::vector<Method> methods);

/** \brief What a band of depth is called. */
std::string
nameOfBand(std::size_t band);

/** \brief What figures are of. */
struct Measured {
  std::string sensor;      ///< its number, or what was made of several
  double resolution = 0.0; ///< voxel edge, metres
  std::size_t frames = 0;
  bool has_depths = true; ///< that is, bands
};

/** \brief Prints average precision, best F1, what is let through where 95 % of the
 * surfaces' voxels stay, bands of depth and thresholds as Markdown. */
void
print(const Measured& measured,
      const std::vector<MethodFigures>& figures,
      std::ostream& output);

/** \brief Adds the same to the results. Shares are in percent, but precision, recall and
 * F1; what is not a number, as there is nothing that it would be of, is left out.
 *
 * Experiments: `experiment`; the same with `_band:` and a band, with `_threshold:` and a
 * threshold, and with `_curve`, precision at each recall.
 */
void
addResults(const std::string& experiment,
           const Measured& measured,
           const std::vector<MethodFigures>& figures,
           report::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
