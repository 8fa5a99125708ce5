// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/entered_stream.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
namespace nodes {

namespace {

/** \brief Lattice indices of the centres of voxels, in double precision. */
class CentreLattice {
public:
  CentreLattice(double resolution, const std::array<double, 3>& origin)
  : voxels_per_metre_(1.0 / resolution), origin_(origin)
  {}

  /** \brief Finds the index of a voxel of a frame; false if it is outside of the
   * lattice. */
  bool
  find(const io::VoxelFrame& frame,
       std::size_t voxel,
       EnteredStream::LatticeIndex& index) const
  {
    const io::VoxelPosition position = io::voxelPosition(frame.keys[voxel]);
    return findOnAxis(frame.grid.centre(0, position.x), 0, index) &&
           findOnAxis(frame.grid.centre(1, position.y), 1, index) &&
           findOnAxis(frame.grid.centre(2, position.z), 2, index);
  }

private:
  bool
  findOnAxis(double centre, std::size_t axis, EnteredStream::LatticeIndex& index) const
  {
    // A centre on a face is in the upper voxel, but may be just below after rounding.
    constexpr double margin = 1.0 / 1024.0;
    constexpr auto end = static_cast<double>(io::lattice_end);
    // From the lower end of the lattice, so that a cast rounds down.
    const double position = (centre - origin_[axis]) * voxels_per_metre_ + margin + end;
    // Negated, so that NaN fails.
    if (!(position >= 0.0 && position < 2.0 * end))
      return false;
    index[axis] = static_cast<std::int32_t>(position) -
                  static_cast<std::int32_t>(io::lattice_end);
    return true;
  }

  double voxels_per_metre_;
  std::array<double, 3> origin_;
};

} // namespace

void
EnteredStream::replace(io::VoxelFrame& voxels)
{
  io::findChanges(voxels_, voxels, changes_);
  std::swap(voxels_, voxels);
  // What is not merged is not kept.
  voxels_.fields.clear();
  voxels_.points = io::FramePoints();
  voxels_.point_counts = std::vector<std::uint32_t>();
  voxels_.has_point_counts = false;
  const std::size_t symbols = voxels_.hasIntensities()
                                  ? std::size_t{voxels_.intensity_scale.maxSymbol()} + 1
                                  : 1;
  if (changes_.gone.intensity_scale == changes_.came.intensity_scale &&
      counts_.size() == symbols)
    follow(changes_.gone, false);
  else {
    counts_.assign(symbols, 0);
    are_other_symbols_ = true;
  }
  follow(changes_.came, true);
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

/** \brief Counts the symbols of voxels. */
void
EnteredStream::follow(const io::VoxelFrame& voxels, bool is_added)
{
  const auto number = static_cast<std::uint32_t>(voxels.size());
  if (number == 0)
    return;
  if (!voxels.hasIntensities()) {
    are_other_symbols_ = true;
    counts_[0] += is_added ? number : 0 - number;
    return;
  }
  for (const std::uint16_t symbol : voxels.intensities) {
    std::uint32_t& count = counts_[symbol];
    are_other_symbols_ |= count == (is_added ? 0u : 1u);
    count += is_added ? 1u : ~0u;
  }
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

/** \brief What the intensity of a voxel adds to a sum. */
std::int64_t
EnteredStream::unitsOf(const io::VoxelFrame& voxels,
                       std::size_t voxel,
                       const MergedScale& scale)
{
  const float intensity = voxels.hasIntensities()
                              ? voxels.intensity_scale.value(voxels.intensities[voxel])
                              : 1.0f;
  const double units =
      static_cast<double>(std::clamp(intensity, -scale.limit, scale.limit)) *
      scale.units;
  // Rounded, without a call of the library.
  return static_cast<std::int64_t>(units + (units < 0.0 ? -0.5 : 0.5));
}

/** \brief Appends the update of one voxel that has an index on the lattice. */
void
EnteredStream::appendUpdate(const io::VoxelFrame& voxels,
                            std::size_t voxel,
                            const LatticeIndex& index,
                            bool is_added,
                            const MergedScale& scale)
{
  std::array<std::uint32_t, 3> position{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t from_grid =
        std::int64_t{index[axis]} - scale.grid.first_index[axis];
    has_all_in_grid_ &= from_grid >= 0 && from_grid < scale.grid.size();
    position[axis] = static_cast<std::uint32_t>(from_grid);
  }
  VoxelUpdate update{};
  update.key = io::mortonKey({position[0], position[1], position[2]});
  update.intensity = unitsOf(voxels, voxel, scale) * (is_added ? 1 : -1);
  update.summands = is_added ? 1 : -1;
  update.has_colour = voxels.colour_bits > 0;
  if (update.has_colour)
    update.colour = voxels.fullColour(voxel);
  updates_.push_back(update);
}

bool
EnteredStream::writeUpdates(const MergedScale& scale)
{
  const io::VoxelFrame& gone = changes_.gone;
  const io::VoxelFrame& came = changes_.came;
  updates_.clear();
  updates_.reserve(gone.size() + came.size());
  has_all_in_grid_ = true;
  const CentreLattice lattice(scale.grid.resolution, scale.grid.origin);
  LatticeIndex index{};
  const auto take_away = [&](std::size_t i) {
    if (lattice.find(gone, i, index))
      appendUpdate(gone, i, index, false, scale);
    else
      --outside_lattice_;
  };
  const auto add = [&](std::size_t j) {
    if (lattice.find(came, j, index))
      appendUpdate(came, j, index, true, scale);
    else
      ++outside_lattice_;
  };
  const auto replace_intensity = [&](std::size_t i, std::size_t j) {
    if (!lattice.find(gone, i, index))
      return;
    appendUpdate(gone, i, index, false, scale);
    updates_.back().intensity += unitsOf(came, j, scale);
    updates_.back().summands = 0;
  };
  const bool may_replace = changes_.areOfOneGrid() && gone.colour_bits == 0;
  // Side by side, as neighbours are in the same octants.
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < gone.size() && j < came.size())
    if (may_replace && gone.keys[i] == came.keys[j])
      replace_intensity(i++, j++);
    else if (gone.keys[i] <= came.keys[j])
      take_away(i++);
    else
      add(j++);
  while (i < gone.size())
    take_away(i++);
  while (j < came.size())
    add(j++);
  return has_all_in_grid_;
}

void
EnteredStream::writeAllUpdates(const MergedScale& scale)
{
  updates_.clear();
  updates_.reserve(voxels_.size());
  outside_lattice_ = 0;
  const CentreLattice lattice(scale.grid.resolution, scale.grid.origin);
  LatticeIndex index{};
  for (std::size_t i = 0; i < voxels_.size(); ++i)
    if (lattice.find(voxels_, i, index))
      appendUpdate(voxels_, i, index, true, scale);
    else
      ++outside_lattice_;
}

void
EnteredStream::endUpdate()
{
  // That of all voxels is hardly ever needed again.
  if (updates_.size() >= voxels_.size()) {
    updates_ = std::vector<VoxelUpdate>();
    changes_ = io::VoxelChanges();
    return;
  }
  changes_.gone.clearVoxels();
  changes_.came.clearVoxels();
  updates_.clear();
}

std::size_t
EnteredStream::measure(double resolution,
                       const std::array<double, 3>& origin,
                       std::optional<io::LatticeRange>& range) const
{
  const CentreLattice lattice(resolution, origin);
  LatticeIndex index{};
  std::size_t on_lattice = 0;
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    if (!lattice.find(voxels_, i, index))
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
