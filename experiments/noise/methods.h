/** \file
 * \brief What is compared: the laws, the library's filter, and tables of their figures.
 */
#pragma once

#include "judged_voxels.h"
#include "labelled_stream.h"

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief A way to score the voxels of one stream, and what came of it. */
struct Method {
  using Score = std::function<void(const LabelledFrame&, std::vector<float>&)>;

  std::string name;
  Score score;
  std::vector<float> thresholds; ///< of which the figures are wanted
  JudgedVoxels voxels;
};

/** \brief The three laws: low intensities are noise. */
std::vector<Method>
lawMethods();

/** \brief VoxelOutlierRemoval on each law, and without history.
 * \param[in] are_merged intensities are sums over several sensors, without depth models
 */
std::vector<Method>
filterMethods(bool are_merged);

/** \brief Scores a frame with all methods. */
void
judge(const LabelledFrame& frame, std::vector<Method>& methods);

/** \brief Average precision, best F1 and what is let through where 95 % of the surfaces'
 * voxels stay. */
void
printFigures(std::vector<Method>& methods, std::ostream& output);

/** \brief Precision, recall and F1 at each method's thresholds. */
void
printThresholds(const std::vector<Method>& methods, std::ostream& output);

/** \brief Average precision by depth, and what is let through and kept there. */
void
printBands(const std::vector<Method>& methods, std::ostream& output);

} // namespace noise
} // namespace pcl_ext
