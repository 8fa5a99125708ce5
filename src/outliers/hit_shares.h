// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "outliers/distance_bands.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief In how many frames the shown voxels are occupied, at each distance from the
 * sensor, and how many that were empty are occupied again: few, where the sensor moves,
 * and as many as of all, where it is noise. Learned from a sample of the voxels. */
class HitShares {
public:
  /** \brief One shown voxel of so many is counted. */
  static constexpr std::size_t sample_step = 16;

  /** \brief Counts a shown voxel.
   * \param[in] distance from the sensor, squared, in voxels; 0 without one
   * \param[in] was_empty whether the frame before did not have it
   * \param[in] is_hit whether this frame has it */
  void
  add(std::uint64_t distance, bool was_empty, bool is_hit)
  {
    for (Counts* counts : {&bands_[distanceBand(distance)].counts, &all_}) {
      counts->voxels += unit;
      counts->hits += is_hit ? unit : 0;
      counts->empty += was_empty ? unit : 0;
      counts->returned += was_empty && is_hit ? unit : 0;
    }
  }

  /** \brief Forgets a part of the earlier frames, before the voxels of the next one are
   * counted. */
  void
  age()
  {
    for (Band& band : bands_) {
      const Counts& counts = band.counts;
      if (counts.empty >= least_empty * unit) {
        // Between the two shares it stays as it is, so that it does not change each
        // frame.
        if (20 * counts.hits > 13 * counts.voxels || !counts.returnsInTenths(5))
          band.is_noisy = false;
        else if (20 * counts.hits < 11 * counts.voxels)
          band.is_noisy = true;
      }
      band.counts.age();
    }
    all_.age();
  }

  /** \brief True if the noise at a distance is larger than a voxel, or pixels are further
   * apart than voxels: shown voxels are usually empty, and are occupied again. */
  bool
  isNoisy(std::uint64_t distance) const
  {
    return bands_[distanceBand(distance)].is_noisy;
  }

  /** \brief True if it is so at any distance. */
  bool
  isAnyNoisy() const
  {
    return std::any_of(
        bands_.begin(), bands_.end(), [](const Band& band) { return band.is_noisy; });
  }

  /** \brief True if of what is empty hardly anything is occupied again. */
  bool
  returnsRarely() const
  {
    return all_.empty >= least_empty / 4 * unit && !all_.returnsInTenths(3);
  }

private:
  static constexpr std::uint64_t unit = 64;         // of the sums, as they are divided
  static constexpr std::uint64_t least_empty = 256; // of the last frames, in a band

  struct Counts {
    std::uint64_t voxels = 0;
    std::uint64_t hits = 0;
    std::uint64_t empty = 0;
    std::uint64_t returned = 0; // of the empty ones, hits

    void
    age()
    {
      for (std::uint64_t* count : {&voxels, &hits, &empty, &returned})
        *count -= *count / 16;
    }

    /** \brief True if the share of hits of those that were empty is at least so many
     * tenths of that of all. */
    bool
    returnsInTenths(std::uint64_t tenths) const
    {
      return 10 * returned * voxels >= tenths * hits * empty;
    }
  };

  struct Band {
    Counts counts;
    bool is_noisy = false;
  };

  std::array<Band, distance_band_count> bands_{};
  Counts all_;
};

} // namespace pcl_ext::PCL_EXT_ABI
