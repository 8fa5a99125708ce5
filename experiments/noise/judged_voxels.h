/** \file
 * \brief How well a number tells voxels of noise from those of surfaces.
 */
#pragma once

#include "labelled_stream.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief Bands of depth in the sensor's frame; the last one has no end. */
constexpr std::array<float, 5> band_ends = {3.0f, 5.0f, 7.0f, 9.0f, 1e9f};
constexpr std::size_t band_count = band_ends.size();

/** \brief Removing the voxels of a lower score than this. */
struct Decision {
  float threshold = 0.0f;
  double precision = 0.0; ///< share of noise among the removed voxels
  double recall = 0.0;    ///< share of the noise that is removed
  double f1 = 0.0;
  std::array<double, 4>
      kept{}; ///< share of the voxels that stay, by VoxelTruth; NaN: none
  double surface_kept = 0.0; ///< the same of all surfaces
};

/** \brief Voxels with their truth and a score that is to be low for noise. */
class JudgedVoxels {
public:
  /** \brief Adds a frame; scores may be any numbers but NaN. */
  void
  add(const LabelledFrame& frame, const std::vector<float>& scores);

  /** \brief To be called before anything is asked. */
  void
  sort();

  /** \brief Area under precision over recall of `this voxel is noise`, without
   * interpolation; voxels of one score count together. */
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

  /** \brief The highest threshold that keeps a share of all surface voxels. */
  float
  thresholdThatKeeps(double surface_share) const;

  /** \brief The threshold of the best F1. */
  float
  bestThreshold() const;

  /** \brief Share of voxels that are noise. */
  double
  noiseShare() const;

private:
  struct Voxel {
    float score;
    VoxelTruth truth;
    std::uint8_t band;
  };

  template <typename WantedT>
  double
  averagePrecisionOf(const WantedT& wanted) const;

  template <typename WantedT>
  Decision
  decisionOf(float threshold, const WantedT& wanted) const;

  std::vector<Voxel> voxels_;
};

} // namespace noise
} // namespace pcl_ext
