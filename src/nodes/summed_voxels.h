// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "simd/bit_operations.h"
#include "voxels/block_directory.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace nodes {

/** \brief A voxel of a stream that is added to the voxel of the merged grid that contains
 * it, is taken away again, or has another intensity. */
struct VoxelUpdate {
  std::uint64_t key;      ///< Morton key in the merged grid
  std::int64_t intensity; ///< to be added
  std::int8_t summands;   ///< 1: it is added, -1: taken away, 0: it stays
  bool has_colour;
  io::VoxelColour colour; ///< in channels of 0 to 255
};

/** \brief What is summed in a voxel of the merged grid. Of integers, so that the order
 * of summands does not matter, and so that each can be taken away again. */
struct SummedVoxel {
  std::int64_t intensity = 0;
  std::uint32_t summands = 0; ///< voxels of streams; 0: there is none here
};

/** \brief Sum of colours. */
struct SummedColour {
  std::uint32_t summands = 0;
  std::array<std::uint32_t, 3> channels{};
};

/** \brief Sums of voxels in a grid, by their Morton keys, in ascending order.
 *
 * Memory: 200 bytes for an octant, 2 x 2 x 2 voxels, of which one or more are occupied,
 * and with colours 128 more. Octants without a voxel are removed when they are more than
 * a half.
 */
class SummedVoxels {
public:
  /** \param[in] parts into which octants are divided, 1 or more, for as many threads */
  explicit SummedVoxels(std::size_t parts) : part_count_(parts) {}

  std::size_t
  partCount() const
  {
    return part_count_;
  }

  /** \brief Removes all voxels and all memory. */
  void
  clear() noexcept;

  /** \brief Begins updates. */
  void
  begin()
  {
    parts_.resize(part_count_);
  }

  /** \brief Sums those of some updates that belong to a part, after begin(). Different parts
   * at the same time; settle() has to follow. */
  void
  add(std::size_t part, const std::vector<VoxelUpdate>& updates);

  /** \brief Ends updates. */
  void
  settle();

  /** \brief Number of voxels. */
  std::size_t
  size() const;

  /** \brief Calls visit(key, SummedVoxel, SummedColour) for each voxel, in ascending
   * order of their keys. After settle(). */
  template <typename VisitT>
  void
  forEach(VisitT&& visit) const
  {
    constexpr std::size_t ahead = 8;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      if (i + ahead < order_.size())
        prefetch(&octantAt(order_[i + ahead]));
      const Place& place = order_[i];
      const SummedOctant& octant = octantAt(place);
      const std::vector<ColouredOctant>& colours = parts_[place.part].colours;
      const bool has_colours = place.index < colours.size();
      for (unsigned int left = parts_[place.part].occupied[place.index]; left != 0;
           left &= left - 1) {
        const std::size_t cell = lowestBit(left);
        visit(place.key * cells + cell,
              octant[cell],
              has_colours ? colours[place.index][cell] : SummedColour());
      }
    }
  }

  /** \brief Whether a voxel's key is in a range, the end not included. */
  bool
  hasAnyBetween(std::uint64_t begin, std::uint64_t end) const;

private:
  static constexpr std::size_t cells = 8;
  using SummedOctant = std::array<SummedVoxel, cells>;
  using ColouredOctant = std::array<SummedColour, cells>;

  /** \brief Where an octant is. */
  struct Place {
    std::uint64_t key;
    std::uint32_t part;
    std::uint32_t index;
  };

  /** \brief A part of the octants, by index. */
  struct Part {
    io::BlockDirectory directory;
    std::vector<std::uint64_t> keys;
    std::vector<SummedOctant> octants;
    std::vector<std::uint8_t> occupied;  ///< cells of each
    std::vector<ColouredOctant> colours; ///< of the first ones; the others have none
    std::vector<std::uint8_t> are_in_order;
    std::vector<std::uint32_t> added;   ///< those that are not in the order yet
    std::vector<std::uint32_t> emptied; ///< those that lost their last voxel
    std::size_t voxels = 0;
  };

  std::size_t
  partOf(std::uint64_t octant_key) const
  {
    return part_count_ == 1
               ? 0
               : static_cast<std::size_t>((octant_key * 0x9e3779b97f4a7c15) >> 32) %
                     part_count_;
  }

  const SummedOctant&
  octantAt(const Place& place) const
  {
    return parts_[place.part].octants[place.index];
  }

  static std::uint32_t
  findOrInsert(Part& part, std::uint64_t octant_key);

  void
  dropEmptied();

  void
  mergeAdded();

  void
  removeEmpty(Part& part) const;

  const std::size_t part_count_;
  std::vector<Part> parts_;
  std::vector<Place> order_; // of the octants with voxels, by key
  std::vector<Place> added_; // keep their memory
  std::vector<Place> spare_;
};

} // namespace nodes
} // namespace pcl_ext
