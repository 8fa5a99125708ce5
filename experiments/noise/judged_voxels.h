/** \file
 * \brief How well a score distinguishes voxels of noise from those of surfaces.
 */
#pragma once

#include "simulator/labelled_stream.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Bands of depth in the sensor's frame, of the robot cell's sensors; the last one
 * has no end. */
constexpr std::array<float, 5> band_ends = {3.0f, 5.0f, 7.0f, 9.0f, 1e9f};
constexpr std::size_t band_count = band_ends.size();

/** \brief Fewer voxels of the person's than this are too few for a share of them. */
constexpr std::size_t least_person_voxels = 20;

/** \brief What is gathered frame by frame: voxels, or points, with their truth and a
 * score that is to be low for noise. */
class ScoredVoxels {
public:
  /** \brief Of the bands of the robot cell. */
  ScoredVoxels() : band_ends_(band_ends.begin(), band_ends.end()) {}

  /** \brief Of other bands.
   * \param[in] ends of the bands, metres, ascending; the last one is taken for endless
   */
  explicit ScoredVoxels(std::vector<float> ends) : band_ends_(std::move(ends)) {}

  /** \brief Adds a frame; scores may be any numbers but NaN. */
  void
  add(const LabelledFrame& frame, const std::vector<float>& scores);

  /** \brief The same of voxels or points with their truths and depths, metres. */
  void
  add(const std::vector<VoxelTruth>& truth,
      const std::vector<float>& depth,
      const std::vector<float>& scores);

private:
  friend class JudgedVoxels;

  struct Voxel {
    float score;
    VoxelTruth truth;
    std::uint8_t band;
  };

  std::uint8_t
  bandOf(float depth) const;

  std::vector<float> band_ends_;
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

  /** \brief Ends of the bands, metres; the last one has no end. */
  const std::vector<float>&
  bandEnds() const
  {
    return band_ends_;
  }

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

  std::vector<float> band_ends_;
  std::vector<Voxel> voxels_; ///< from the lowest score to the highest
  std::vector<std::vector<float>> person_scores_;
};

} // namespace noise
} // namespace pcl_ext
