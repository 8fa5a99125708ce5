// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outliers/density_blocks.h"

#include "simd/bit_operations.h"

#include <algorithm>
#include <cstring>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

constexpr std::int16_t forgotten_below = 16; ///< in units of 2^-6

/** \brief Cells of a block whose x, y or z is below 2. */
constexpr std::array<std::uint64_t, 3> low_cells = {
    0x00000000ffffffff, 0x00ff00ff00ff00ff, 0x3333333333333333};

/** \brief Cells of the previous, the own and the next block along an axis that are in a
 * window: first cell, number of cells, position in the window. */
struct Span {
  std::size_t from, count, to;
};
constexpr std::array<Span, 3> spans = {{{2, 2, 0}, {0, 4, 2}, {0, 2, 6}}};

/** \brief Copies f of a part of a block.
 * \tparam count z.count
 */
template <std::size_t count>
void
copyRows(const BlockCells& block,
         const Span& x,
         const Span& y,
         const Span& z,
         DensityWindow& window)
{
  for (std::size_t i = 0; i < x.count; ++i)
    for (std::size_t j = 0; j < y.count; ++j)
      std::memcpy(window.rows[(x.to + i) * DensityWindow::width + y.to + j].data() +
                      z.to,
                  block.data() + (x.from + i) * 16 + (y.from + j) * 4 + z.from,
                  count * sizeof(std::int16_t));
}

using Row = DensityWindow::Row;

inline void
addRow(const Row& row, Row& sum)
{
  for (std::size_t lane = 0; lane < DensityWindow::width; ++lane)
    sum[lane] = static_cast<std::int16_t>(sum[lane] + row[lane]);
}

inline void
countRow(const Row& row, Row& count)
{
  for (std::size_t lane = 0; lane < DensityWindow::width; ++lane)
    count[lane] = static_cast<std::int16_t>(count[lane] + (row[lane] != 0 ? 1 : 0));
}

/** \brief Sums over the rows around a row, for each z. */
struct RowSums {
  Row cross{};  ///< the four adjacent rows
  Row near{};   ///< 3 x 3 rows
  Row far{};    ///< the other 16 of 5 x 5 rows; sums are below 2^15
  Row counts{}; ///< number of the 5 x 5 that are not 0
};

/** \param[in] rows the first of the 5 x 5 */
template <bool counts>
RowSums
sumRows(const Row* rows)
{
  constexpr std::size_t slice = DensityWindow::width;
  RowSums sums;
  for (const std::size_t x : {std::size_t{0}, std::size_t{4}})
    for (std::size_t y = 0; y < 5; ++y)
      addRow(rows[x * slice + y], sums.far);
  for (std::size_t x = 1; x < 4; ++x) {
    addRow(rows[x * slice], sums.far);
    addRow(rows[x * slice + 4], sums.far);
    addRow(rows[x * slice + 2], x == 2 ? sums.near : sums.cross);
  }
  for (const std::size_t y : {std::size_t{1}, std::size_t{3}}) {
    addRow(rows[slice + y], sums.near);
    addRow(rows[2 * slice + y], sums.cross);
    addRow(rows[3 * slice + y], sums.near);
  }
  addRow(sums.cross, sums.near);
  if constexpr (counts)
    for (std::size_t x = 0; x < 5; ++x)
      for (std::size_t y = 0; y < 5; ++y)
        countRow(rows[x * slice + y], sums.counts);
  return sums;
}

} // namespace

void
DensityBlocks::clear()
{
  keys_.clear();
  means_.clear();
  fields_.clear();
  directory_.clear(0);
}

void
DensityBlocks::age()
{
  for (std::size_t index = 0; index < size();) {
    BlockCells& means = means_[index];
    BlockCells& field = fields_[index];
    std::int16_t any = 0;
    for (std::size_t i = 0; i < means.size(); ++i) {
      const auto mean = static_cast<std::int16_t>(means[i] - (means[i] >> 2));
      means[i] = mean >= forgotten_below ? mean : std::int16_t{0};
      field[i] = static_cast<std::int16_t>(means[i] >> 5); // half of the mean
      any = static_cast<std::int16_t>(any | means[i]);
    }
    if (any != 0) {
      ++index;
      continue;
    }
    keys_[index] = keys_.back();
    means = means_.back();
    keys_.pop_back();
    means_.pop_back();
    fields_.pop_back();
  }
  directory_.assign(keys_);
}

std::uint32_t
DensityBlocks::blockAt(std::uint64_t key)
{
  std::uint32_t index = directory_.find(key);
  if (index != io::BlockDirectory::not_found)
    return index;
  index = static_cast<std::uint32_t>(size());
  keys_.push_back(key);
  means_.emplace_back(); // all zeros
  fields_.emplace_back();
  directory_.insert(key);
  return index;
}

void
DensityBlocks::add(std::uint32_t block, unsigned int cell, std::int16_t density)
{
  std::int16_t& mean = means_[block][cell];
  mean = static_cast<std::int16_t>(mean + mean_step * density);
  // Not the mean, so that a new voxel is as dense as an old one.
  fields_[block][cell] = static_cast<std::int16_t>(4 * density);
}

void
DensityBlocks::keepOnly(const std::vector<std::uint32_t>& kept)
{
  std::size_t next = 0;
  for (const std::uint32_t index : kept) {
    keys_[next] = keys_[index];
    means_[next] = means_[index];
    fields_[next] = fields_[index];
    ++next;
  }
  keys_.resize(next);
  means_.resize(next);
  fields_.resize(next);
  directory_.assign(keys_);
}

void
DensityBlocks::releaseMemory()
{
  keys_.shrink_to_fit();
  means_.shrink_to_fit();
  fields_.shrink_to_fit();
  directory_ = io::BlockDirectory();
  directory_.assign(keys_);
}

void
DensityBlocks::collect(std::uint32_t block,
                       std::uint64_t cells,
                       DensityWindow& window) const
{
  std::memset(&window, 0, sizeof(window));
  copyRows<4>(fields_[block], spans[1], spans[1], spans[1], window);
  // Range of neighbours within 2 voxels of a cell.
  std::array<std::size_t, 3> first;
  std::array<std::size_t, 3> last;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = (cells & low_cells[axis]) != 0 ? 0 : 1;
    last[axis] = (cells & ~low_cells[axis]) != 0 ? 2 : 1;
  }
  for (std::size_t x = first[0]; x <= last[0]; ++x)
    for (std::size_t y = first[1]; y <= last[1]; ++y)
      for (std::size_t z = first[2]; z <= last[2]; ++z) {
        if (x == 1 && y == 1 && z == 1)
          continue;
        const std::uint64_t key =
            keys_[block] + (std::uint64_t{x} << 42) + (std::uint64_t{y} << 21) + z -
            ((std::uint64_t{1} << 42 | std::uint64_t{1} << 21) + 1);
        const std::uint32_t index = directory_.find(key);
        if (index == io::BlockDirectory::not_found)
          continue;
        if (z == 1)
          copyRows<4>(fields_[index], spans[x], spans[y], spans[z], window);
        else
          copyRows<2>(fields_[index], spans[x], spans[y], spans[z], window);
      }
}

template <bool counts>
void
sumNeighbourhoods(const DensityWindow& window,
                  std::uint64_t cells,
                  std::array<NeighbourhoodSums, 64>& sums)
{
  while (cells != 0) {
    const unsigned int row = lowestBit(cells) >> 2;
    const std::size_t first = (row >> 2) * DensityWindow::width + (row & 3);
    const RowSums about = sumRows<counts>(&window.rows[first]);
    const Row& own = window.rows[first + DensityWindow::margin * DensityWindow::width +
                                 DensityWindow::margin];
    for (std::size_t z = 0; z < 4; ++z) {
      const std::size_t middle = z + DensityWindow::margin;
      const std::int32_t faces =
          own[middle - 1] + own[middle + 1] + about.cross[middle];
      const std::int32_t cube =
          about.near[middle - 1] + about.near[middle] + about.near[middle + 1];
      NeighbourhoodSums& sum = sums[4 * row + z];
      sum.core = 2 * own[middle] + faces;
      sum.ring = cube - own[middle] - faces;
      sum.rim = about.near[middle - 2] + about.near[middle + 2];
      sum.occupied = 0;
      for (std::size_t lane = z; lane < z + 5; ++lane) {
        sum.rim += about.far[lane];
        if constexpr (counts)
          sum.occupied += about.counts[lane];
      }
      sum.all = cube + sum.rim;
    }
    cells &= ~(std::uint64_t{15} << (4 * row));
  }
}

template void
sumNeighbourhoods<false>(const DensityWindow&,
                         std::uint64_t,
                         std::array<NeighbourhoodSums, 64>&);
template void
sumNeighbourhoods<true>(const DensityWindow&,
                        std::uint64_t,
                        std::array<NeighbourhoodSums, 64>&);

} // namespace pcl_ext::PCL_EXT_ABI
