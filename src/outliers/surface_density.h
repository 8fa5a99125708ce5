#pragma once

#include <pcl_ext/version.h>

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

/** \brief How many occupied neighbours the voxels of surfaces have at each distance: where
 * pixels are further apart than voxels it is few. Learned from a sample of the voxels.
 */
class SurfaceDensity {
public:
  /** \brief One voxel of so many is counted. */
  static constexpr std::size_t sample_step = 8;

  /** \brief Forgets a part of the earlier frames. */
  void
  age()
  {
    for (Band& band : bands_) {
      band.voxels -= band.voxels / 8;
      band.neighbours -= band.neighbours / 8;
    }
  }

  /** \param[in] distance of a voxel from the sensor, squared, in voxels; 0 without one
   * \param[in] neighbours its occupied neighbours, 0..26 */
  void
  add(std::uint64_t distance, unsigned int neighbours)
  {
    Band& band = bands_[bandOf(distance)];
    band.voxels += unit;
    band.neighbours += unit * neighbours;
  }

  /** \brief Computes mean() from what was added. Nearer surfaces are at least as dense,
   * so that bands in which there is mostly noise do not count. */
  void
  update()
  {
    std::uint32_t mean = 0;
    for (std::size_t i = bands_.size(); i-- > 0;) {
      const Band& band = bands_[i];
      if (band.voxels >= least_voxels * unit)
        mean = std::max(mean,
                        static_cast<std::uint32_t>(16 * band.neighbours / band.voxels));
      means_[i] = mean;
    }
  }

  /** \brief Mean number of neighbours at a distance, in sixteenths. */
  std::uint32_t
  mean(std::uint64_t distance) const
  {
    return means_[bandOf(distance)];
  }

private:
  static constexpr std::uint64_t unit = 64; // of the sums, as they are divided
  static constexpr std::uint64_t least_voxels = 32;

  /** \brief Four bands for each doubling of the distance. */
  static std::size_t
  bandOf(std::uint64_t distance)
  {
    const auto bounded = static_cast<std::uint32_t>(
        std::clamp(distance, std::uint64_t{2}, std::uint64_t{0xffffffff}));
    const unsigned int highest = highestBit(bounded);
    return 2 * highest + (bounded >> (highest - 1) & 1);
  }

  struct Band {
    std::uint64_t voxels = 0;
    std::uint64_t neighbours = 0;
  };

  std::array<Band, 64> bands_{};
  std::array<std::uint32_t, 64> means_{};
};

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
