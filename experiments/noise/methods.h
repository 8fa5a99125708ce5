/** \file
 * \brief What is compared: the laws, the library's filter and PCL's.
 */
#pragma once

#include "judged_voxels.h"
#include "merged_stream.h"
#include "simulator/labelled_stream.h"

#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief A way to score the voxels of one stream, and what it gave them. */
struct Method {
  using Score = std::function<void(const LabelledFrame&, std::vector<float>&)>;

  std::string name; ///< without a comma, for results
  Score score;
  std::vector<float> thresholds; ///< of which the figures are wanted
  ScoredVoxels voxels;
};

/** \brief A camera's laws, and VoxelOutlierRemoval on each of them, without history and
 * without intensities. */
std::vector<Method>
cameraMethods();

/** \brief The same for the sums of several cameras, and the filter on each camera
 * before they are merged: what one of them takes for a surface stays.
 * \param[in] stream that the frames to judge are of; it must live as long
 */
std::vector<Method>
mergedMethods(const MergedStream& stream);

/** \brief A lidar's own intensity and its counts, and the filter on counts, for which
 * it is not meant, and without intensities. */
std::vector<Method>
lidarMethods();

/** \brief PCL's filters on the centres of voxels, and the filter on the quadratic law.
 * \param[in] resolution voxel edge, metres
 */
std::vector<Method>
peerMethods(double resolution);

/** \brief Scores a frame with all methods. */
void
judge(const LabelledFrame& frame, std::vector<Method>& methods);

} // namespace noise
} // namespace pcl_ext
