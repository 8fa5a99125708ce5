// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What a method's scores of a stream are worth.
 */
#pragma once

#include "measuring/samples.h"
#include "methods.h"

#include <string>
#include <vector>

namespace pcl_ext {

namespace measuring {
class Results;
struct Subject;
} // namespace measuring

namespace noise {

/** \brief A method, and what it gave the frames of a stream so far. */
struct MethodRun {
  Method method;
  ScoredVoxels voxels;
  ScoredVoxels points;   ///< of scans
  measuring::Samples ms; ///< processor time of a frame's scores
};

std::vector<MethodRun>
runsOf(std::vector<Method> methods);

/** \brief Scores the voxels of a camera's next frame. */
void
score(const LabelledFrame& frame, MethodRun& run);

/** \brief Scores the points and the voxels of the next scan. Where points are scored, a
 * voxel's score is the highest of its points, as one point of a surface makes a surface;
 * where voxels are, that of a point is its voxel's. */
void
score(const LabelledScan& scan, MethodRun& run);

/** \brief Adds the judgement of scores.
 *
 * Experiment as named: noise_percent, average_precision, `best_` (at the threshold of
 * the best F1) and `usual_` (at the highest threshold that keeps 95 % of the surfaces),
 * each with threshold, precision, recall, f1 and the shares in percent that are let
 * through and kept. With `_threshold:` and a threshold appended: the same at that one.
 * With `_curve`: precision over recall. Values that are not defined are left out.
 * \param[in] subject without the method
 * \param[in] scored of the method
 * \param[in] frames that they are of
 */
void
addJudgement(measuring::Subject subject,
             const Method& method,
             ScoredVoxels scored,
             std::size_t frames,
             measuring::Results& results);

} // namespace noise
} // namespace pcl_ext
