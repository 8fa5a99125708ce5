// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/entered_stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief What intensities add to sums, by their symbols. */
class SymbolUnits {
public:
  /** \param[in] voxels with such intensities
   * \param[in] count number of voxels */
  SymbolUnits(const io::VoxelFrame& voxels, std::size_t count, const MergedScale& scale)
  : scale_(scale), intensities_(voxels.intensity_scale)
  {
    if (!voxels.hasIntensities())
      table_ = {unitsOf(1.0f)};
    else if (intensities_.maxSymbol() < count)
      for (std::uint32_t symbol = 0; symbol <= intensities_.maxSymbol(); ++symbol)
        table_.push_back(compute(static_cast<std::uint16_t>(symbol)));
  }

  std::int64_t
  operator[](std::uint16_t symbol) const
  {
    return table_.empty() ? compute(symbol) : table_[symbol];
  }

private:
  std::int64_t
  compute(std::uint16_t symbol) const
  {
    return unitsOf(intensities_.value(symbol));
  }

  std::int64_t
  unitsOf(float intensity) const
  {
    const double units =
        static_cast<double>(std::clamp(intensity, -scale_.limit, scale_.limit)) *
        scale_.units;
    // Rounded, without a call of the library; limited, as symbols that no voxel has are
    // in the table, too.
    return static_cast<std::int64_t>(
        std::clamp(units + (units < 0.0 ? -0.5 : 0.5), -0x1p62, 0x1p62));
  }

  MergedScale scale_;
  io::IntensityScale intensities_;
  std::vector<std::int64_t> table_; // empty: there are more symbols than voxels
};

std::uint16_t
symbolOf(const io::VoxelFrame& voxels, std::size_t voxel)
{
  return voxels.hasIntensities() ? voxels.intensities[voxel] : std::uint16_t{0};
}

VoxelUpdate
updateOf(const io::VoxelFrame& voxels,
         std::size_t voxel,
         const SymbolUnits& units,
         bool is_added)
{
  VoxelUpdate update{};
  update.intensity = units[symbolOf(voxels, voxel)] * (is_added ? 1 : -1);
  update.summands = is_added ? 1 : -1;
  update.has_colour = voxels.colour_bits > 0;
  if (update.has_colour)
    update.colour = voxels.fullColour(voxel);
  return update;
}

/** \brief Skips voxels without colours that are the same in two frames of one scale, one
 * after another. */
void
skipSame(const io::VoxelFrame& one,
         std::size_t& i,
         const io::VoxelFrame& other,
         std::size_t& j)
{
  while (i < one.size() && j < other.size() && one.keys[i] == other.keys[j] &&
         symbolOf(one, i) == symbolOf(other, j)) {
    ++i;
    ++j;
  }
}

} // namespace

void
EnteredStream::follow()
{
  for (const io::VoxelChanges& changes : taken_) {
    size_ = size_ + changes.came.size() - changes.gone.size();
    grid_ = changes.came.grid;
    countSymbols(changes);
  }
  measureIntensities();
}

void
EnteredStream::forget()
{
  taken_.clear();
  size_ = 0;
  outside_lattice_ = 0;
  counts_.clear();
  are_other_symbols_ = true; // none are left, even if none come
  is_entered_anew_ = true;
}

void
EnteredStream::countSymbols(const io::VoxelChanges& changes)
{
  const io::IntensityScale& scale = changes.came.intensity_scale;
  const std::size_t symbols =
      scale.bits > 0 ? std::size_t{scale.maxSymbol()} + 1 : std::size_t{1};
  const bool has_same_scale = counts_.size() == symbols && scale == scale_ &&
                              changes.gone.intensity_scale == scale;
  if (!has_same_scale) {
    // None of another scale is left.
    counts_.assign(symbols, 0);
    scale_ = scale;
    are_other_symbols_ = true;
  }
  // Those that came first, as a symbol may be of both.
  for (std::size_t i = 0; i < changes.came.size(); ++i)
    are_other_symbols_ |= counts_[symbolOf(changes.came, i)]++ == 0;
  for (std::size_t i = 0; has_same_scale && i < changes.gone.size(); ++i)
    are_other_symbols_ |= --counts_[symbolOf(changes.gone, i)] == 0;
}

/** \brief Finds what symbols there are. */
void
EnteredStream::measureIntensities()
{
  if (!are_other_symbols_)
    return;
  are_other_symbols_ = false;
  highest_ = 0.0f;
  step_ = io::CommonStep();
  for (std::size_t symbol = 0; symbol < counts_.size(); ++symbol) {
    if (counts_[symbol] == 0)
      continue;
    const float intensity = intensityOf(symbol);
    highest_ = std::max(highest_, std::abs(intensity));
    step_.add(intensity);
  }
}

/** \brief Appends the update of a voxel of the grid keys_ is set to. */
void
EnteredStream::append(std::uint64_t key, const VoxelUpdate& update)
{
  const std::uint64_t merged_key = keys_.find(key);
  if (merged_key < MergedKeys::outside_grid)
    updates_.append(merged_key, update);
  else if (merged_key == MergedKeys::outside_grid)
    has_all_in_grid_ = false;
  else
    outside_lattice_ += static_cast<std::size_t>(update.summands);
}

/** \brief Appends the updates of all voxels of one frame. */
void
EnteredStream::writeOne(const io::VoxelFrame& voxels,
                        bool is_added,
                        const MergedScale& scale)
{
  keys_.setGrids(voxels.grid, scale.grid);
  const SymbolUnits units(voxels, voxels.size(), scale);
  for (std::size_t i = 0; i < voxels.size(); ++i)
    append(voxels.keys[i], updateOf(voxels, i, units, is_added));
}

/** \brief Appends the updates of changes of one grid: one for a voxel of another
 * intensity, two for one of another colour. */
void
EnteredStream::writeDifferences(const io::VoxelChanges& changes,
                                const MergedScale& scale)
{
  const io::VoxelFrame& gone = changes.gone;
  const io::VoxelFrame& came = changes.came;
  keys_.setGrids(came.grid, scale.grid);
  const SymbolUnits units(came, gone.size() + came.size(), scale);
  const bool has_colours = came.colour_bits > 0;
  constexpr std::uint64_t behind_all = ~std::uint64_t{0};
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < gone.size() || j < came.size()) {
    const std::uint64_t was = i < gone.size() ? gone.keys[i] : behind_all;
    const std::uint64_t is = j < came.size() ? came.keys[j] : behind_all;
    const bool is_gone = was <= is;
    const bool is_here = is <= was;
    if (has_colours && (was != is || !(gone.fullColour(i) == came.fullColour(j)))) {
      if (is_gone)
        append(was, updateOf(gone, i++, units, false));
      if (is_here)
        append(is, updateOf(came, j++, units, true));
      continue;
    }
    // Without branches, which could not be predicted among noise.
    VoxelUpdate update{};
    if (is_here)
      update.intensity = units[symbolOf(came, j)];
    if (is_gone)
      update.intensity -= units[symbolOf(gone, i)];
    update.summands = static_cast<std::int8_t>(is_here - is_gone);
    i += is_gone ? 1 : 0;
    j += is_here ? 1 : 0;
    if (update.intensity != 0 || update.summands != 0)
      append(std::min(was, is), update);
    else if (!has_colours)
      skipSame(gone, i, came, j);
  }
}

bool
EnteredStream::writeUpdates(const MergedScale& scale)
{
  updates_.clear();
  has_all_in_grid_ = true;
  for (const io::VoxelChanges& changes : taken_)
    if (changes.areOfOneGrid())
      writeDifferences(changes, scale);
    else {
      writeOne(changes.gone, false, scale);
      writeOne(changes.came, true, scale);
    }
  return has_all_in_grid_;
}

void
EnteredStream::endUpdate()
{
  // As many updates are hardly ever needed again: of all voxels, or of many more.
  const bool are_many = updates_.updates.size() > 2 * size_;
  if (std::exchange(is_entered_anew_, false) || are_many) {
    updates_ = VoxelUpdates();
    taken_.release();
  }
  updates_.clear();
  taken_.clear();
}

std::size_t
EnteredStream::measure(double resolution,
                       const std::array<double, 3>& origin,
                       std::optional<io::LatticeRange>& range) const
{
  const CentreLattice lattice(resolution, origin);
  CentreLattice::Index index{};
  std::size_t on_lattice = 0;
  for (const io::VoxelChanges& changes : taken_)
    for (const std::uint64_t key : changes.came.keys) {
      if (!lattice.find(changes.came.grid, key, index))
        continue;
      ++on_lattice;
      range =
          range ? io::unite(*range, {index, index}) : io::LatticeRange{index, index};
    }
  return on_lattice;
}

void
EnteredStream::addTo(io::CommonStep& step, float limit) const
{
  for (std::size_t symbol = 0; symbol < counts_.size(); ++symbol)
    if (counts_[symbol] != 0)
      step.add(std::clamp(intensityOf(symbol), -limit, limit));
}

std::size_t
EnteredStream::countAbove(float limit) const
{
  std::size_t count = 0;
  if (limit < highest_)
    for (std::size_t symbol = 0; symbol < counts_.size(); ++symbol)
      count += std::abs(intensityOf(symbol)) > limit ? counts_[symbol] : 0;
  return count;
}

std::optional<float>
EnteredStream::medianMagnitude() const
{
  std::vector<std::pair<float, std::size_t>> magnitudes; // and how many there are
  std::size_t total = 0;
  for (std::size_t symbol = 0; symbol < counts_.size(); ++symbol) {
    const float magnitude = std::abs(intensityOf(symbol));
    if (counts_[symbol] == 0 || magnitude == 0.0f)
      continue;
    magnitudes.emplace_back(magnitude, counts_[symbol]);
    total += counts_[symbol];
  }
  if (total == 0)
    return std::nullopt;
  std::sort(magnitudes.begin(), magnitudes.end());
  std::size_t left = (total - 1) / 2;
  for (const auto& [magnitude, count] : magnitudes) {
    if (left < count)
      return magnitude;
    left -= count;
  }
  return magnitudes.back().first;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
