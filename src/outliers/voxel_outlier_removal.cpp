#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "outliers/density_blocks.h"
#include "outliers/voxel_densities.h"
#include "voxels/keep_voxels.h"
#include "voxels/memory_rule.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace pcl_ext {

namespace {

/** \brief e of VoxelOutlierRemoval, in faces. */
constexpr float least_shell = 0.02f;

/** \brief c of VoxelOutlierRemoval for a voxel edge, metres. */
float
offsetOf(bool are_faces, double resolution)
{
  // Faces: the maximum likelihood on sensor 2 of the robot cell with seed 2 at 4 cm; the
  // maximum differs by up to 0.2 at 2 to 6 cm, and by 0.6 at 8 cm. Points: 0.4 to 1 below
  // that maximum; the maxima of the six sensors at 4 cm differ from this value by -0.3 to
  // 0.8. Above 4 cm the maximum for Points would remove 1 of 10 voxels of the surfaces at
  // 8 cm and 1 of 3 at 20 cm, as counts of coarse voxels vary more than their local mean.
  const auto edges = static_cast<float>(3.0 * std::log(resolution / 0.04));
  return are_faces ? 2.4f + edges : -2.5f - std::min(edges, 0.0f);
}

/** \brief exp(2 (log-odds - c)), which is compared without computing logarithms. */
float
evidenceOf(const NeighbourhoodSums& sums, float unit)
{
  const float least = least_shell * unit;
  const auto shell = [&](std::int32_t sum) {
    return (static_cast<float>(sum) + least) / unit;
  };
  const float core = shell(sums.core);
  const float core_squared = core * core;
  return core_squared * core_squared * core_squared * shell(sums.ring) *
         shell(sums.rim);
}

/** \brief Maps positions in the grids of a stream to positions in DensityBlocks. */
class PlacedGrid {
public:
  /** \brief Sets the grid of the stream's next frame.
   * \return false if positions of previous frames are no longer valid, or there are none
   */
  bool
  follow(const io::VoxelGrid& grid)
  {
    const bool is_same_lattice =
        has_lattice_ && grid.resolution == resolution_ && grid.anchor == anchor_;
    if (is_same_lattice && place(grid))
      return true;
    has_lattice_ = true;
    resolution_ = grid.resolution;
    anchor_ = grid.anchor;
    // Blocks are aligned to those of the grid, with a margin on all sides.
    for (std::size_t axis = 0; axis < 3; ++axis)
      origin_[axis] = std::int64_t{grid.first_index[axis]} - first_position;
    place(grid);
    return false;
  }

  void
  clear()
  {
    has_lattice_ = false;
  }

  /** \brief Position of the grid's first voxel. */
  io::VoxelPosition
  first() const
  {
    return {offset_[0], offset_[1], offset_[2]};
  }

  io::VoxelPosition
  operator()(const io::VoxelPosition& position) const
  {
    return {position.x + offset_[0], position.y + offset_[1], position.z + offset_[2]};
  }

private:
  // A grid has at most 2^21 voxels on each axis.
  static constexpr std::int64_t first_position = std::int64_t{1} << 21;
  static constexpr std::int64_t margin = 4;

  bool
  place(const io::VoxelGrid& grid)
  {
    std::array<std::int64_t, 3> offset;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      offset[axis] = grid.first_index[axis] - origin_[axis];
      if (offset[axis] < margin ||
          offset[axis] + grid.size() > DensityBlocks::position_end - margin)
        return false;
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
      offset_[axis] = static_cast<std::uint32_t>(offset[axis]);
    return true;
  }

  bool has_lattice_ = false;
  double resolution_ = 0.0;
  std::array<double, 3> anchor_{};
  std::array<std::int64_t, 3> origin_{};  ///< lattice index of position 0
  std::array<std::uint32_t, 3> offset_{}; ///< position of the grid's first voxel
};

} // namespace

class VoxelOutlierRemoval::Implementation {
public:
  explicit Implementation(const VoxelOutlierRemovalSettings& settings)
  : settings_(settings)
  , has_valid_settings_(checkSettings(settings).ok())
  , densities_(settings.unit, settings.full_intensity)
  {}

  std::size_t
  filter(io::VoxelFrame& frame)
  {
    if (!isSupported(frame))
      return 0;
    beginFrame();
    learn(frame);
    const float least = std::exp(2.0f * (settings_.min_log_odds - offset_));
    const std::size_t voxels = frame.size();
    const std::size_t removed = io::keepVoxels(frame, [&](std::size_t i) {
      return !(evidence_[indexOf(places_[i])] < least);
    });
    endFrame(voxels);
    return removed;
  }

  void
  score(const io::VoxelFrame& frame, std::vector<float>& log_odds)
  {
    if (!isSupported(frame)) {
      log_odds.assign(frame.size(), std::numeric_limits<float>::infinity());
      return;
    }
    beginFrame();
    learn(frame);
    log_odds.resize(frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i)
      log_odds[i] = 0.5f * std::log(evidence_[indexOf(places_[i])]) + offset_;
    endFrame(frame.size());
  }

  void
  reset()
  {
    grid_.clear(); // so that learn() starts without a history
    releaseAll();
  }

  std::size_t
  rememberedBlocks() const
  {
    return blocks_.size();
  }

private:
  /** \brief Position of a voxel of the frame in the blocks. */
  struct Place {
    std::uint32_t block;
    std::uint8_t cell;
  };

  bool
  isSupported(const io::VoxelFrame& frame) const
  {
    return has_valid_settings_ && frame.hasIntensities() &&
           isMadeFor(frame.grid.resolution);
  }

  std::size_t
  indexOf(const Place& place) const
  {
    const std::uint64_t before = (std::uint64_t{1} << place.cell) - 1;
    return first_voxels_[place.block] + bitCount(masks_[place.block] & before);
  }

  /** \brief Begins a frame; drops the history if memory ran out in the previous one. */
  void
  beginFrame()
  {
    if (is_interrupted_)
      reset();
    is_interrupted_ = true;
  }

  void
  endFrame(std::size_t voxels)
  {
    const bool is_too_large = memory_rule_.shouldRelease(voxels + blocks_.size());
    limitHistory();
    if (is_too_large) {
      blocks_.releaseMemory();
      releaseFrame();
    }
    is_interrupted_ = false;
  }

  void
  learn(const io::VoxelFrame& frame)
  {
    if (!grid_.follow(frame.grid)) {
      blocks_.clear();
      densities_.reset();
    }
    const bool is_same_unit = densities_.follow(frame, grid_.first());
    if (!is_same_unit || !settings_.use_history)
      blocks_.clear();
    else
      blocks_.age();
    offset_ = offsetOf(densities_.areFaces(), frame.grid.resolution);
    addVoxels(frame);
    evidence_.resize(frame.size());
    first_voxels_.resize(masks_.size());
    std::uint32_t first = 0;
    // In the order of the frame, in which neighbours are close in memory.
    for (const std::uint32_t block : frame_blocks_) {
      first_voxels_[block] = first;
      computeEvidence(block, evidence_.data() + first);
      first += bitCount(masks_[block]);
    }
  }

  void
  addVoxels(const io::VoxelFrame& frame)
  {
    masks_.assign(blocks_.size(), 0);
    frame_blocks_.clear();
    places_.resize(frame.size());
    std::uint64_t last_key = std::numeric_limits<std::uint64_t>::max();
    std::uint32_t block = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const io::VoxelPosition at = grid_(io::voxelPosition(frame.keys[i]));
      const std::uint64_t key = DensityBlocks::blockKey(at.x, at.y, at.z);
      if (key != last_key) {
        block = blocks_.blockAt(key);
        last_key = key;
        if (block == masks_.size())
          masks_.push_back(0);
        if (masks_[block] == 0)
          frame_blocks_.push_back(block);
      }
      const unsigned int cell = DensityBlocks::cell(at.x, at.y, at.z);
      blocks_.add(block, cell, densities_(frame.intensities[i], at));
      masks_[block] |= std::uint64_t{1} << cell;
      places_[i] = {block, static_cast<std::uint8_t>(cell)};
    }
  }

  /** \brief Computes the evidence of the voxels of a block.
   * \param[out] evidence of each voxel, in the order of the cells
   */
  void
  computeEvidence(std::uint32_t block, float* evidence)
  {
    blocks_.collect(block, masks_[block], window_);
    if (densities_.areFaces())
      sumNeighbourhoods<false>(window_, masks_[block], sums_);
    else
      sumNeighbourhoods<true>(window_, masks_[block], sums_);
    for (std::uint64_t cells = masks_[block]; cells != 0; cells &= cells - 1) {
      const NeighbourhoodSums& sums = sums_[lowestBit(cells)];
      // f is in quarters of 255ths of a face.
      const float unit = densities_.areFaces() ? 4.0f * 255.0f
                                               : static_cast<float>(sums.all) /
                                                     static_cast<float>(sums.occupied);
      *evidence++ = evidenceOf(sums, unit);
    }
  }

  /** \brief Enforces the limit of blocks between frames. */
  void
  limitHistory()
  {
    if (frame_blocks_.size() > settings_.max_blocks) {
      releaseAll();
      return;
    }
    if (!settings_.use_history) {
      blocks_.clear();
      return;
    }
    if (blocks_.size() <= settings_.max_blocks)
      return;
    std::sort(frame_blocks_.begin(), frame_blocks_.end());
    blocks_.keepOnly(frame_blocks_);
  }

  /** \brief Drops all blocks and releases the memory. */
  void
  releaseAll()
  {
    blocks_ = DensityBlocks();
    releaseFrame();
  }

  void
  releaseFrame()
  {
    std::vector<Place>().swap(places_);
    std::vector<std::uint64_t>().swap(masks_);
    std::vector<std::uint32_t>().swap(frame_blocks_);
    std::vector<std::uint32_t>().swap(first_voxels_);
    std::vector<float>().swap(evidence_);
  }

  VoxelOutlierRemovalSettings settings_;
  bool has_valid_settings_;
  VoxelDensities densities_;
  PlacedGrid grid_;
  DensityBlocks blocks_;

  // Of the current frame; members so that their memory is reused.
  float offset_ = 0.0f;
  std::vector<Place> places_;               // of each voxel
  std::vector<std::uint64_t> masks_;        // of each block, occupied cells
  std::vector<std::uint32_t> frame_blocks_; // blocks with voxels
  std::vector<std::uint32_t> first_voxels_; // of each block, index into the next
  std::vector<float> evidence_;             // of each voxel, by block and cell
  DensityWindow window_;
  std::array<NeighbourhoodSums, 64> sums_;
  bool is_interrupted_ = false;
  io::MemoryRule memory_rule_;
};

OutlierRemovalStatus
checkSettings(const VoxelOutlierRemovalSettings& settings)
{
  const auto invalid = [](const std::string& message) {
    return OutlierRemovalStatus(OutlierRemovalCode::InvalidSettings, message);
  };
  if (!std::isfinite(settings.min_log_odds))
    return invalid("min_log_odds is " + std::to_string(settings.min_log_odds) +
                   "; it must be a finite number");
  if (settings.unit != DensityUnit::Automatic && settings.unit != DensityUnit::Faces &&
      settings.unit != DensityUnit::Points)
    return invalid("unit is " + std::to_string(static_cast<int>(settings.unit)) +
                   "; it must be Automatic, Faces or Points");
  if (!std::isfinite(settings.full_intensity) || !(settings.full_intensity > 0.0f))
    return invalid("full_intensity is " + std::to_string(settings.full_intensity) +
                   "; it must be a finite number above 0");
  return {};
}

VoxelOutlierRemoval::VoxelOutlierRemoval(const VoxelOutlierRemovalSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

bool
VoxelOutlierRemoval::isMadeFor(double resolution)
{
  // With a tolerance for rounded resolutions.
  constexpr double rounding = 1e-6;
  return resolution >= min_resolution * (1.0 - rounding) &&
         resolution <= max_resolution * (1.0 + rounding);
}

VoxelOutlierRemoval::~VoxelOutlierRemoval() = default;
VoxelOutlierRemoval::VoxelOutlierRemoval(VoxelOutlierRemoval&&) noexcept = default;
VoxelOutlierRemoval&
VoxelOutlierRemoval::operator=(VoxelOutlierRemoval&&) noexcept = default;

std::size_t
VoxelOutlierRemoval::filter(io::VoxelFrame& frame)
{
  return implementation_->filter(frame);
}

void
VoxelOutlierRemoval::score(const io::VoxelFrame& frame, std::vector<float>& log_odds)
{
  implementation_->score(frame, log_odds);
}

void
VoxelOutlierRemoval::reset()
{
  implementation_->reset();
}

std::size_t
VoxelOutlierRemoval::rememberedBlocks() const
{
  return implementation_->rememberedBlocks();
}

} // namespace pcl_ext
