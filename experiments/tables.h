// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The paper's tables and figures, noise with its truth, and what a receiver shows.
 * Each function measures and prints results, as measuring::Results has them.
 */
#pragma once

#include "measuring/options.h"

namespace pcl_ext {
namespace experiments {

using measuring::Options;

/** \brief The paper's sections 3.1 and 3.2: cropping, compression by sensor, voxel edge
 * and law, depth images. */
void
measureStreams(const Options& options, std::ostream& output);

/** \brief The paper's section 3.3: the streams of all cameras at one central
 * computer. */
void
measureAtOnce(const Options& options, std::ostream& output);

/** \brief The most streams that are decoded in time, on one core and on all, and the
 * most that a gigabit link carries; Markdown. */
void
printScale(const Options& options, std::ostream& output);

/** \brief What it costs to decode many streams, to merge them 20 times a second, and to
 * encode what is merged; Markdown. */
void
printCentre(const Options& options, std::ostream& output);

/** \brief What the pictures show, as CSV files in a folder: Figures 5, 7, 10 and 11. One
 * frame of each sensor. */
void
writePictures(const Options& options, std::ostream& output);

/** \brief How well noise is told from surfaces among a camera's voxels: by the paper's
 * laws, by VoxelOutlierRemoval, and by PCL's filters. */
void
measureNoise(const Options& options, std::ostream& output);

/** \brief The same of the lidar's points and voxels, in clear air, snow or dust. */
void
measureLidarNoise(const Options& options, std::ostream& output);

/** \brief Bytes, surfaces and noise with and without filters of outliers and over
 * time. */
void
measureTemporalFilter(const Options& options, std::ostream& output);

/** \brief Rate control over simulated links, beside fixed settings; Markdown. */
void
printRateControl(const Options& options, std::ostream& output);

} // namespace experiments
} // namespace pcl_ext
