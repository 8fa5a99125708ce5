// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_changes.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief Gives a part of a frame what all its voxels have in common. */
void
beginPart(const VoxelFrame& frame, VoxelFrame& part)
{
  part.clearVoxels();
  part.grid = frame.grid;
  part.intensity_scale = frame.intensity_scale;
  part.depth_model = frame.depth_model;
  part.colour_bits = frame.colour_bits;
  part.viewpoint = {};
  part.has_point_counts = false;
  part.fields.clear();
  part.points = FramePoints();
}

void
append(const VoxelFrame& frame, std::size_t begin, std::size_t end, VoxelFrame& part)
{
  const auto appendTo = [&](auto& values, const auto& from) {
    const auto first = from.begin() + static_cast<std::ptrdiff_t>(begin);
    values.insert(
        values.end(), first, first + static_cast<std::ptrdiff_t>(end - begin));
  };
  appendTo(part.keys, frame.keys);
  if (frame.hasIntensities())
    appendTo(part.intensities, frame.intensities);
  if (frame.colour_bits > 0)
    appendTo(part.colours, frame.colours);
}

/** \brief Voxels of a frame that are to be appended to a part of it. */
class ListedVoxels {
public:
  static constexpr std::size_t most = 64;

  explicit ListedVoxels(const VoxelFrame& frame) : frame_(frame) {}

  /** \brief Lists a voxel, or lets the next one take its place. */
  void
  add(std::size_t voxel, bool is_listed)
  {
    voxels_[size_] = voxel;
    size_ += is_listed ? 1 : 0;
  }

  void
  moveTo(VoxelFrame& part)
  {
    move(frame_.keys, part.keys);
    if (frame_.hasIntensities())
      move(frame_.intensities, part.intensities);
    if (frame_.colour_bits > 0)
      move(frame_.colours, part.colours);
    size_ = 0;
  }

private:
  template <typename ValueT>
  void
  move(const std::vector<ValueT>& from, std::vector<ValueT>& values) const
  {
    const std::size_t begin = values.size();
    values.resize(begin + size_);
    for (std::size_t i = 0; i < size_; ++i)
      values[begin + i] = from[voxels_[i]];
  }

  const VoxelFrame& frame_;
  std::array<std::size_t, most + 1> voxels_;
  std::size_t size_ = 0;
};

} // namespace

void
findChanges(const VoxelFrame& before, const VoxelFrame& after, VoxelChanges& changes)
{
  changes.is_from_nothing = false;
  beginPart(before, changes.gone);
  beginPart(after, changes.came);
  if (!changes.areOfOneGrid() || before.depth_model != after.depth_model) {
    append(before, 0, before.size(), changes.gone);
    append(after, 0, after.size(), changes.came);
    return;
  }
  const bool has_intensities = before.hasIntensities();
  const bool has_colours = before.colour_bits > 0;
  // Without branches that could not be predicted among noise.
  const auto differ = [&](std::size_t i, std::size_t j) {
    bool is_other = before.keys[i] != after.keys[j];
    if (has_intensities)
      is_other |= before.intensities[i] != after.intensities[j];
    if (has_colours)
      is_other |= !(before.colours[i] == after.colours[j]);
    return is_other;
  };
  ListedVoxels gone(before);
  ListedVoxels came(after);
  std::size_t i = 0;
  std::size_t j = 0;
  const auto areLeft = [&] { return i < before.size() && j < after.size(); };
  while (areLeft()) {
    for (; areLeft() && !differ(i, j); ++i)
      ++j;
    for (std::size_t step = 0; step < ListedVoxels::most && areLeft(); ++step) {
      const std::uint64_t was = before.keys[i];
      const std::uint64_t is = after.keys[j];
      const bool is_other = differ(i, j);
      gone.add(i, is_other & (was <= is));
      came.add(j, is_other & (is <= was));
      i += was <= is ? 1 : 0;
      j += is <= was ? 1 : 0;
    }
    gone.moveTo(changes.gone);
    came.moveTo(changes.came);
  }
  append(before, i, before.size(), changes.gone);
  append(after, j, after.size(), changes.came);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
