// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief How well a score tells noise from surfaces, of voxels or points.
 */
#pragma once

#include "simulator/labelled_stream.h"

#include <array>
#include <cstddef>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Fewer voxels of the person's than this are too few for a share of them. */
constexpr std::size_t least_person_voxels = 20;

/** \brief What is gathered frame by frame: voxels, or points, with their truth and a
 * score that is to be low for noise. */
class ScoredVoxels {
public:
  /** \brief Adds a frame.
   * \throws std::invalid_argument if a score is NaN
   */
  void
  add(const std::vector<VoxelTruth>& truth, const std::vector<float>& scores);

private:
  friend class JudgedVoxels;

  struct Voxel {
    float score;
    VoxelTruth truth;
  };

  std::vector<Voxel> voxels_;
  /** \brief Of the person's voxels, a vector for each frame with enough of them. */
  std::vector<std::vector<float>> person_scores_;
};

/** \brief Removing the voxels of a lower score than this. */
struct Decision {
  float threshold = 0.0f;
  double precision =
      0.0;             ///< share of noise among the removed voxels; NaN: none removed
  double recall = 0.0; ///< share of the noise that is removed; NaN: there is none
  double f1 = 0.0;     ///< NaN: there is no noise, and nothing was removed
  std::array<double, voxel_truth_count>
      kept{}; ///< share of the voxels that stay, by VoxelTruth; NaN: none
  double surface_kept = 0.0; ///< the same of all surfaces
  /** \brief Of the person in the worst frame with at least least_person_voxels of it;
   * NaN: there is none. */
  double person_worst = 0.0;
};

/** \brief The judgement over all frames that were gathered. */
class JudgedVoxels {
public:
  explicit JudgedVoxels(ScoredVoxels voxels);

  /** \brief Area under precision over recall of `this voxel is noise`, without
   * interpolation; voxels of one score count together. NaN without noise. */
  double
  averagePrecision() const;

  /** \brief The decision of a threshold. */
  Decision
  at(float threshold) const;

  /** \brief The highest threshold that keeps a share of all surface voxels; infinity if
   * there are none. */
  float
  thresholdThatKeeps(double surface_share) const;

  /** \brief The threshold of the best F1; 0 without noise. */
  float
  bestThreshold() const;

  /** \brief Precision of the lowest threshold whose recall is i / steps at least, for i
   * from 1 to steps. Empty without noise. */
  std::vector<double>
  precisionsOverRecall(std::size_t steps) const;

  /** \brief Share of voxels that are noise. */
  double
  noiseShare() const;

private:
  using Voxel = ScoredVoxels::Voxel;

  /** \brief What is removed by a threshold above some voxels. */
  struct Step {
    double removed = 0.0;    ///< voxels
    double noise = 0.0;      ///< of these
    double more_noise = 0.0; ///< of these, with the highest score
    float threshold = 0.0f;  ///< the next score; infinity behind the last one
  };

  /** \brief All that thresholds can do, from the lowest that removes anything. */
  std::vector<Step>
  steps() const;

  std::size_t noise_ = 0;     ///< voxels
  std::vector<Voxel> voxels_; ///< from the lowest score to the highest
  std::vector<std::vector<float>> person_scores_;
};

} // namespace noise
} // namespace pcl_ext
