// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_grid.h>

#include "voxels/grid_fit.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Lattice indices of the centres of a grid's voxels on another lattice, in double
 * precision. */
class CentreLattice {
public:
  using Index = std::array<std::int32_t, 3>;

  /** \param[in] resolution voxel edge of the other lattice, metres
   * \param[in] origin of the other lattice, metres
   */
  CentreLattice(double resolution, const std::array<double, 3>& origin)
  : voxels_per_metre_(1.0 / resolution), origin_(origin)
  {}

  /** \brief Finds the index of a voxel; false if it is outside of the lattice. */
  bool
  find(const io::VoxelGrid& grid, std::uint64_t key, Index& index) const
  {
    const io::VoxelPosition position = io::voxelPosition(key);
    return findOnAxis(grid, 0, position.x, index[0]) &&
           findOnAxis(grid, 1, position.y, index[1]) &&
           findOnAxis(grid, 2, position.z, index[2]);
  }

  bool
  findOnAxis(const io::VoxelGrid& grid,
             std::size_t axis,
             std::uint32_t position,
             std::int32_t& index) const
  {
    // A centre on a face is in the upper voxel, but may be just below after rounding.
    constexpr double margin = 1.0 / 1024.0;
    constexpr auto end = static_cast<double>(io::lattice_end);
    // From the lower end of the lattice, so that a cast rounds down.
    const double from_end =
        (grid.centre(axis, position) - origin_[axis]) * voxels_per_metre_ + margin +
        end;
    // Negated, so that NaN fails.
    if (!(from_end >= 0.0 && from_end < 2.0 * end))
      return false;
    index = static_cast<std::int32_t>(from_end) -
            static_cast<std::int32_t>(io::lattice_end);
    return true;
  }

private:
  double voxels_per_metre_;
  std::array<double, 3> origin_;
};

/** \brief Finds the Morton keys, in the merged grid, of the voxels of a stream. */
class MergedKeys {
public:
  /** \brief What find() returns in place of a key. */
  static constexpr std::uint64_t outside_grid = std::uint64_t{1}
                                                << 63; ///< on the lattice
  static constexpr std::uint64_t outside_lattice = outside_grid + 1;

  /** \brief Sets the grids. Does nothing if they are those of the last time. */
  void
  setGrids(const io::VoxelGrid& stream, const io::VoxelGrid& merged)
  {
    if (has_tables_ && stream == stream_ && merged == merged_)
      return;
    has_tables_ = false;
    stream_ = stream;
    merged_ = merged;
    lattice_ = CentreLattice(merged.resolution, merged.origin);
    if (stream.depth > deepest_table)
      return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      tables_[axis].resize(static_cast<std::size_t>(stream.size()));
      for (std::size_t i = 0; i < tables_[axis].size(); ++i)
        tables_[axis][i] = partOfKey(axis, static_cast<std::uint32_t>(i));
    }
    has_tables_ = true;
  }

  /** \brief The key of a voxel in the merged grid; outside_grid or outside_lattice if it
   * has none. */
  std::uint64_t
  find(std::uint64_t key) const
  {
    const io::VoxelPosition position = io::voxelPosition(key);
    const std::uint64_t merged =
        has_tables_
            ? tables_[0][position.x] | tables_[1][position.y] | tables_[2][position.z]
            : partOfKey(0, position.x) | partOfKey(1, position.y) |
                  partOfKey(2, position.z);
    return (merged & outside_grid) == 0 ? merged : placeOutside(key);
  }

private:
  // Tables of 8 KiB an axis at most.
  static constexpr unsigned int deepest_table = 10;

  /** \brief The bits of a key that belong to a position on one axis; outside_grid if it
   * has none. */
  std::uint64_t
  partOfKey(std::size_t axis, std::uint32_t position) const
  {
    std::int32_t index = 0;
    if (!lattice_.findOnAxis(stream_, axis, position, index))
      return outside_grid;
    const std::int64_t in_grid = std::int64_t{index} - merged_.first_index[axis];
    if (in_grid < 0 || in_grid >= merged_.size())
      return outside_grid;
    return io::detail::spreadBits(static_cast<std::uint64_t>(in_grid)) << (2 - axis);
  }

  std::uint64_t
  placeOutside(std::uint64_t key) const
  {
    CentreLattice::Index index{};
    return lattice_.find(stream_, key, index) ? outside_grid : outside_lattice;
  }

  io::VoxelGrid stream_;
  io::VoxelGrid merged_;
  CentreLattice lattice_{1.0, {}}; // of the merged grid
  bool has_tables_ = false;
  std::array<std::vector<std::uint64_t>, 3> tables_; // of each axis, by positions
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
