/** \file
 * \brief How well a score distinguishes voxels of noise from those of surfaces.
 */
#pragma once

#include "simulator/labelled_stream.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Bands of depth in the sensor's frame; the last one has no end. */
constexpr std::array<float, 5> band_ends = {3.0f, 5.0f, 7.0f, 9.0f, 1e9f};
constexpr std::size_t band_count = band_ends.size();

/** \brief Fewer voxels of the person's than this are too few for a share of them. */
constexpr std::size_t least_person_voxels = 20;

/** \brief What is gathered frame by frame: voxels with their truth and a score that is
 * to be low for noise. */
class ScoredVoxels {
public:
  /** \brief Adds a frame; scores may be any numbers but NaN. */
  void
  add(const LabelledFrame& frame, const std::vector<float>& scores);

private:
  friend class JudgedVoxels;

  struct Voxel {
    float score;
    VoxelTruth truth;
    std::uint8_t band;
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
  std::array<double, 4>
      kept{}; ///< share of the voxels that stay, by VoxelTruth; NaN: none
  double surface_kept = 0.0; ///< the same of all surfaces
};

/** \brief What a threshold leaves of the person, frame by frame. */
struct PersonKept {
  std::size_t frames = 0;      ///< with at least least_person_voxels of the person's
  std::size_t poor_frames = 0; ///< of these, those where less than 80 % stay
  double worst_share = 0.0;    ///< that stays in the worst of them; NaN: there are none
};

/** \brief Voxels of noise and of surfaces in a band of depth, or in all. */
struct VoxelNumbers {
  std::size_t noise = 0;
  std::size_t surface = 0;
};

/** \brief The judgement over all frames that were gathered. */
class JudgedVoxels {
public:
  explicit JudgedVoxels(ScoredVoxels voxels);

  VoxelNumbers
  numbers() const;

  VoxelNumbers
  numbers(std::size_t band) const;

  /** \brief Area under precision over recall of `this voxel is noise`, without
   * interpolation; voxels of one score count together. NaN without noise. */
  double
  averagePrecision() const;

  /** \brief The same for the voxels of a band alone. */
  double
  averagePrecision(std::size_t band) const;

  /** \brief The decision of a threshold. */
  Decision
  at(float threshold) const;

  /** \brief The same for the voxels of a band alone. */
  Decision
  at(float threshold, std::size_t band) const;

  /** \brief The highest threshold that keeps a share of all surface voxels; infinity if
   * there are none. */
  float
  thresholdThatKeeps(double surface_share) const;

  /** \brief The threshold of the best F1; 0 without noise. */
  float
  bestThreshold() const;

  /** \brief What stays of the person at a threshold. */
  PersonKept
  personKept(float threshold) const;

  /** \brief Precision of the lowest threshold whose recall is i / steps at least, for i
   * from 1 to steps. Empty without noise. */
  std::vector<double>
  precisionsOverRecall(std::size_t steps) const;

  /** \brief Share of voxels that are noise. */
  double
  noiseShare() const;

private:
  using Voxel = ScoredVoxels::Voxel;

  template <typename WantedT>
  VoxelNumbers
  numbersOf(const WantedT& wanted) const;

  template <typename WantedT>
  double
  averagePrecisionOf(const WantedT& wanted) const;

  template <typename WantedT>
  Decision
  decisionOf(float threshold, const WantedT& wanted) const;

  std::vector<Voxel> voxels_; ///< from the lowest score to the highest
  std::vector<std::vector<float>> person_scores_;
};

} // namespace noise
} // namespace pcl_ext
