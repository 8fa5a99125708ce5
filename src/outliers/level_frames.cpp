#include "outliers/level_frames.h"

#include "voxels/intensity_symbols.h"
#include "voxels/region_cells.h"

#include <algorithm>
#include <cmath>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

namespace {

/** \brief The grid of the coarse voxels of a grid that is aligned to them. */
io::VoxelGrid
coarseGrid(io::VoxelGrid grid, unsigned int levels)
{
  grid.resolution = std::ldexp(grid.resolution, static_cast<int>(levels));
  for (std::int32_t& index : grid.first_index)
    index /= 1 << levels; // without a remainder
  grid.depth = std::max(grid.depth - levels, 1u);
  return grid;
}

/** \brief The depth model of coarse voxels, whose shares are those of their faces; none
 * if its numbers are too large. */
std::optional<io::DepthModel>
coarseModel(io::DepthModel model, unsigned int levels)
{
  const std::int64_t edge = std::int64_t{1} << levels;
  const std::int64_t sum = std::int64_t{model.step[0]} + model.step[1] + model.step[2];
  model.origin += (edge - 1) * sum / 2;
  for (std::int32_t& step : model.step) {
    const std::int64_t coarse = edge * step;
    step = static_cast<std::int32_t>(coarse);
    if (step != coarse)
      return std::nullopt;
  }
  model.full_symbol >>= model.exponent * levels;
  return isConsistent(model) ? std::optional(model) : std::nullopt;
}

} // namespace

void
LevelFrames::assign(const io::VoxelFrame& frame, unsigned int share_exponent)
{
  levels_ = io::voxelLevels(frame);
  indices_.resize(frame.size());
  frames_.resize(frame.regions->mostLevels() + 1);
  for (unsigned int levels = 0; levels < frames_.size(); ++levels)
    assignLevel(frame, levels, share_exponent);
}

void
LevelFrames::assignLevel(const io::VoxelFrame& frame,
                         unsigned int levels,
                         unsigned int share_exponent)
{
  io::VoxelFrame& coarse = frames_[levels];
  coarse.clearVoxels();
  coarse.grid = coarseGrid(frame.grid, levels);
  coarse.intensity_scale = frame.intensity_scale;
  coarse.colour_bits = frame.colour_bits;
  coarse.depth_model =
      frame.depth_model ? coarseModel(*frame.depth_model, levels) : std::nullopt;
  float sum = 0.0f; // of the last coarse voxel
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (levels_[i] > levels)
      continue;
    const bool is_own = levels_[i] == levels;
    const std::uint64_t key = frame.keys[i] >> 3 * levels;
    const bool begins = coarse.keys.empty() || coarse.keys.back() != key;
    if (is_own)
      indices_[i] = coarse.size();
    if (begins) {
      coarse.keys.push_back(key);
      if (frame.colour_bits > 0)
        coarse.colours.push_back(frame.colours[i]);
    }
    if (!frame.hasIntensities())
      continue;
    if (begins)
      coarse.intensities.push_back(frame.intensities[i]);
    if (is_own)
      continue;
    const float value =
        std::ldexp(frame.intensity_scale.value(frame.intensities[i]),
                   -static_cast<int>(share_exponent * (levels - levels_[i])));
    sum = begins ? value : sum + value;
    coarse.intensities.back() = static_cast<std::uint16_t>(
        std::min(io::lowestSymbol(frame.intensity_scale, sum),
                 frame.intensity_scale.maxSymbol()));
  }
}

void
LevelFrames::unite(io::VoxelFrame& frame) const
{
  struct Voxel {
    std::uint64_t key;
    std::size_t levels;
    std::size_t index;
  };
  std::vector<Voxel> voxels;
  io::RegionCells cells(frame.grid, *frame.regions);
  for (unsigned int levels = 0; levels < frames_.size(); ++levels)
    for (std::size_t i = 0; i < frames_[levels].size(); ++i) {
      const std::uint64_t key =
          io::keyOfCoarseVoxel(frames_[levels].keys[i] << 3 * levels, levels);
      if (cells.levelsOf(key) == static_cast<int>(levels))
        voxels.push_back({key, levels, i});
    }
  std::sort(voxels.begin(), voxels.end(), [](const Voxel& one, const Voxel& other) {
    return one.key < other.key;
  });
  frame.clearVoxels();
  for (const Voxel& voxel : voxels) {
    const io::VoxelFrame& of_levels = frames_[voxel.levels];
    frame.keys.push_back(voxel.key);
    if (frame.hasIntensities())
      frame.intensities.push_back(of_levels.intensities[voxel.index]);
    if (frame.colour_bits > 0)
      frame.colours.push_back(of_levels.colours[voxel.index]);
  }
}

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
