// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What is compared: the paper's laws, this library's filters, PCL's and those of
 * others.
 */
#pragma once

#include "judged_voxels.h"
#include "lidar_scans.h"

#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief A way to score the voxels of a stream, or the points of its scans; low for
 * noise. It is called for the frames in their order, so that it may remember. A new
 * method is one more of cameraMethods() or lidarMethods(). */
struct Method {
  using VoxelScore = std::function<void(const LabelledFrame&, std::vector<float>&)>;
  /** \brief Sets a score for each return. */
  using PointScore = std::function<void(const LabelledScan&, std::vector<float>&)>;

  std::string name; ///< without a comma, for results
  VoxelScore score_voxels;
  std::vector<float> thresholds; ///< of which the figures are wanted
  PointScore score_points;       ///< then score_voxels is empty
};

/** \brief Of a camera: the paper's laws, VoxelOutlierRemoval on them, without history
 * and without intensities, and PCL's filters on the centres of voxels.
 * \param[in] edge of the voxels, metres
 */
std::vector<Method>
cameraMethods(double edge);

/** \brief Of the lidar: its own intensity, PointOutlierRemoval, VoxelOutlierRemoval by
 * rays, by voxels and by counts, DROR and DSOR. */
std::vector<Method>
lidarMethods();

/** \brief Those with one of some words in their names; all without words.
 * \throws std::invalid_argument if there is none
 */
std::vector<Method>
methodsNamed(const std::vector<std::string>& words, std::vector<Method> methods);

} // namespace noise
} // namespace pcl_ext
