/** \file
 * \brief How well each method distinguishes noise from surfaces, as results.
 */
#pragma once

#include "methods.h"

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext {

namespace measuring {
class ResultFile;
}

namespace noise {

/** \brief What results are of. */
struct Measured {
  std::string experiment;
  std::string sensor;      ///< its number, or what was made of several
  double resolution = 0.0; ///< voxel edge, metres
  std::size_t frames = 0;
  bool has_depths = true;      ///< that is, bands
  std::string unit = "voxels"; ///< what is judged, for the names of their numbers
};

/** \brief Adds the results of a method that only decides, at its thresholds, with the
 * prefix `given_`: see addResults(). */
void
addDecisions(const Measured& measured, Method method, measuring::ResultFile& results);

/** \brief Adds the results of all methods; values that are not defined (no voxels that
 * they would be of) are left out.
 *
 * Experiment as named: noise_percent, average_precision, `best_` (at the threshold of
 * the best F1) and `usual_` (at the highest threshold that keeps 95 % of the surfaces'
 * voxels), each with threshold, precision, recall, f1 and the shares in percent that
 * are let through and kept. With `_threshold:` and a threshold appended: the same at
 * that threshold. With `_curve`: precision over recall. With `_band:` and a band of
 * depth: average precision there, and shares at the usual threshold.
 * \param[in] methods their voxels are released one after the other, since they are many
 */
void
addResults(const Measured& measured,
           std::vector<Method> methods,
           measuring::ResultFile& results);

} // namespace noise
} // namespace pcl_ext
