// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/entered_stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pcl_ext {
namespace nodes {

namespace {

/** \brief What intensities add to sums, by their symbols. */
class SymbolUnits {
public:
  SymbolUnits(const io::VoxelFrame& voxels, const MergedScale& scale)
  : scale_(scale), intensities_(voxels.intensity_scale)
  {
    if (!voxels.hasIntensities())
      table_ = {unitsOf(1.0f)};
    else if (intensities_.maxSymbol() < voxels.size())
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

/** \brief Whether voxels of two frames that have colours, or one of which has, differ in
 * them. */
bool
haveOtherColours(const io::VoxelFrame& one,
                 std::size_t i,
                 const io::VoxelFrame& other,
                 std::size_t j)
{
  return one.colour_bits == 0 || other.colour_bits == 0 ||
         !(one.fullColour(i) == other.fullColour(j));
}

} // namespace

void
EnteredStream::replace(io::VoxelFrame& voxels)
{
  std::swap(before_, voxels_);
  std::swap(voxels_, voxels);
  is_replaced_ = before_.size() + voxels_.size() > 0;
  // What is not merged is not kept.
  voxels_.fields.clear();
  voxels_.points = io::FramePoints();
  voxels_.point_counts = std::vector<std::uint32_t>();
  voxels_.has_point_counts = false;
  countSymbols();
  measureIntensities();
}

void
EnteredStream::removeVoxels()
{
  io::VoxelFrame nothing;
  nothing.grid = voxels_.grid;
  nothing.intensity_scale = voxels_.intensity_scale;
  nothing.colour_bits = voxels_.colour_bits;
  nothing.depth_model = voxels_.depth_model;
  replace(nothing);
}

/** \brief Counts the symbols of the voxels. */
void
EnteredStream::countSymbols()
{
  const std::size_t symbols = voxels_.hasIntensities()
                                  ? std::size_t{voxels_.intensity_scale.maxSymbol()} + 1
                                  : 1;
  counts_.assign(symbols, 0);
  for (std::size_t i = 0; i < voxels_.size(); ++i)
    ++counts_[symbolOf(voxels_, i)];
  are_other_symbols_ |= before_.intensity_scale != voxels_.intensity_scale ||
                        are_there_.size() != symbols;
  are_there_.resize(symbols);
  unsigned int differences = 0;
  for (std::size_t symbol = 0; symbol < symbols; ++symbol) {
    const std::uint8_t is_there = counts_[symbol] != 0 ? 1 : 0;
    differences |= are_there_[symbol] != is_there ? 1u : 0u;
    are_there_[symbol] = is_there;
  }
  are_other_symbols_ |= differences != 0;
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
  const SymbolUnits units(voxels, scale);
  for (std::size_t i = 0; i < voxels.size(); ++i)
    append(voxels.keys[i], updateOf(voxels, i, units, is_added));
}

/** \brief Appends the updates of voxels of two frames of one grid that differ. */
void
EnteredStream::writeChanges(const MergedScale& scale)
{
  keys_.setGrids(voxels_.grid, scale.grid);
  const SymbolUnits units_before(before_, scale);
  const SymbolUnits units(voxels_, scale);
  const bool has_colours = before_.colour_bits + voxels_.colour_bits > 0;
  constexpr std::uint64_t behind_all = ~std::uint64_t{0};
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < before_.size() || j < voxels_.size()) {
    const std::uint64_t was = i < before_.size() ? before_.keys[i] : behind_all;
    const std::uint64_t is = j < voxels_.size() ? voxels_.keys[j] : behind_all;
    if (has_colours && (was != is || haveOtherColours(before_, i, voxels_, j))) {
      if (was <= is)
        append(was, updateOf(before_, i++, units_before, false));
      if (is <= was)
        append(is, updateOf(voxels_, j++, units, true));
      continue;
    }
    // Without branches, which could not be predicted among noise.
    VoxelUpdate update{};
    const bool is_gone = was <= is;
    const bool is_here = is <= was;
    if (is_here)
      update.intensity = units[symbolOf(voxels_, j)];
    if (is_gone)
      update.intensity -= units_before[symbolOf(before_, i)];
    update.summands = static_cast<std::int8_t>(is_here - is_gone);
    i += is_gone ? 1 : 0;
    j += is_here ? 1 : 0;
    if (update.intensity != 0 || update.summands != 0)
      append(std::min(was, is), update);
    else
      skipSame(i, j);
  }
}

/** \brief Skips voxels of the two frames that are the same, one after another. */
void
EnteredStream::skipSame(std::size_t& i, std::size_t& j) const
{
  const bool have_same_symbols = before_.intensity_scale == voxels_.intensity_scale;
  if (!have_same_symbols || before_.colour_bits + voxels_.colour_bits > 0)
    return;
  const std::size_t most = std::min(before_.size() - i, voxels_.size() - j);
  std::size_t same = 0;
  while (same < most && before_.keys[i + same] == voxels_.keys[j + same] &&
         symbolOf(before_, i + same) == symbolOf(voxels_, j + same))
    ++same;
  i += same;
  j += same;
}

bool
EnteredStream::writeUpdates(const MergedScale& scale)
{
  updates_.clear();
  has_all_in_grid_ = true;
  if (before_.grid == voxels_.grid)
    writeChanges(scale);
  else {
    writeOne(before_, false, scale);
    writeOne(voxels_, true, scale);
  }
  return has_all_in_grid_;
}

void
EnteredStream::writeAllUpdates(const MergedScale& scale)
{
  updates_.clear();
  outside_lattice_ = 0;
  writeOne(voxels_, true, scale);
  has_written_all_ = true;
}

void
EnteredStream::endUpdate()
{
  is_replaced_ = false;
  // As many updates are hardly ever needed again.
  if (std::exchange(has_written_all_, false))
    updates_ = VoxelUpdates();
  updates_.clear();
}

std::size_t
EnteredStream::measure(double resolution,
                       const std::array<double, 3>& origin,
                       std::optional<io::LatticeRange>& range) const
{
  const CentreLattice lattice(resolution, origin);
  CentreLattice::Index index{};
  std::size_t on_lattice = 0;
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    if (!lattice.find(voxels_.grid, voxels_.keys[i], index))
      continue;
    ++on_lattice;
    range = range ? io::unite(*range, {index, index}) : io::LatticeRange{index, index};
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

} // namespace nodes
} // namespace pcl_ext
