// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "bytes/reserve_ahead.h"
#include "outliers/direction_depths.h"
#include "outliers/frame_ticks.h"
#include "outliers/rays_beyond.h"
#include "outliers/sensor_rest.h"
#include "outliers/tracked_voxels.h"
#include "outliers/voxel_presence.h"
#include "voxels/intensity_symbols.h"
#include "voxels/memory_rule.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

namespace {

/** \brief A frame that has less than this part of the voxels that were shown before it,
 * one in so many, is of another scene: with noise that is larger than the voxels, less
 * than the second one. */
constexpr std::size_t same_scene_part = 8;
constexpr std::size_t same_noisy_scene_part = 64;

/** \brief The most voxels of the history. Surfaces and usual noise have up to four for
 * each voxel of a frame. */
constexpr std::size_t
mostTracked(std::size_t frame_voxels)
{
  return 8 * frame_voxels + (std::size_t{1} << 16);
}

constexpr HeldColour new_colour{};
constexpr std::uint64_t no_key = std::numeric_limits<std::uint64_t>::max();

/** \brief A position, unless it is not known. */
std::optional<std::array<double, 3>>
finite(const std::optional<std::array<double, 3>>& position)
{
  const bool is_finite =
      position && std::all_of(position->begin(), position->end(), [](double value) {
        return std::isfinite(value);
      });
  return is_finite ? position : std::nullopt;
}

/** \brief With a depth model values are numbers of points, as the coders derive them
 * (doc/bitstream.md, "Depth model"): a shown symbol is then what they predict. */
std::uint16_t
valueOf(const io::VoxelFrame& frame, std::size_t voxel)
{
  const std::uint64_t symbol = frame.intensities[voxel];
  const std::uint64_t point =
      frame.depth_model
          ? frame.depth_model->pointSymbol(io::voxelPosition(frame.keys[voxel]))
          : 0;
  return static_cast<std::uint16_t>(
      point < 0x10000 ? symbol : ((symbol << 16) + point / 2) / point);
}

/** \brief The symbol of a value at a voxel of the frame's grid. */
std::uint16_t
symbolOf(const io::VoxelFrame& frame, std::uint64_t key, std::uint16_t value)
{
  const std::uint64_t point =
      frame.depth_model ? frame.depth_model->pointSymbol(io::voxelPosition(key)) : 0;
  const std::uint64_t symbol = point < 0x10000 ? value : (value * point + 0x8000) >> 16;
  return static_cast<std::uint16_t>(
      std::min<std::uint64_t>(symbol, frame.intensity_scale.maxSymbol()));
}

} // namespace

class TemporalVoxelFilter::Implementation {
public:
  Implementation(unsigned int frames, bool holds)
  : frames_(frames), holds_(holds), presence_(frames, holds)
  {}

  TemporalFilterStatus
  filter(io::VoxelFrame& frame, const SensorView& view)
  {
    TemporalFilterStatus status = check(frame);
    if (status.ok())
      filterChecked(frame, view, status);
    rays_.clear();
    return status;
  }

  void
  seeBeyond(io::PointBatches& points,
            const io::BoundingBox& box,
            const std::array<double, 3>& position)
  {
    rays_.clear();
    addPointsBeyond(points, box, position, rays_);
  }

  void
  reset()
  {
    Implementation fresh(frames_, holds_);
    std::swap(fresh.rays_, rays_); // of the next frame
    *this = std::move(fresh);
  }

  std::size_t
  rememberedVoxels() const
  {
    return tracked_.count;
  }

private:
  TemporalFilterStatus
  check(const io::VoxelFrame& frame) const
  {
    if (frames_ < least_frames || frames_ > most_frames)
      return {TemporalFilterCode::InvalidSettings,
              "frames is " + std::to_string(frames_) + "; it must be 2 to 64"};
    if (frame.has_point_counts || frame.points.areThere() || !frame.fields.empty())
      return {TemporalFilterCode::HasPointCounts,
              "the frame was not filtered: numbers of points and fields are those of "
              "one cloud"};
    return {};
  }

  void
  filterChecked(io::VoxelFrame& frame,
                const SensorView& view,
                TemporalFilterStatus& status)
  {
    if (is_interrupted_)
      reset();
    is_interrupted_ = true;
    follow(frame);
    const unsigned int ticks = frame_ticks_.take(view.time);
    presence_.beginFrame(frame, finite(view.position), rays_, ticks);
    status.sensor_motion =
        rest_.judge(frame, presence_.surfaces(), finite(view.position), ticks);
    if (status.sensor_motion == io::SensorMotion::Moving)
      forgetVoxels();
    else
      filterVoxels(frame, status);
    if (memory_rule_.shouldRelease(tracked_.count))
      releaseMemory();
    is_interrupted_ = false;
  }

  /** \brief The voxels of a sensor that rests, unless they show that it moves. */
  void
  filterVoxels(io::VoxelFrame& frame, TemporalFilterStatus& status)
  {
    presence_.beginVoxels(tracked_, frame.grid.depth);
    update(frame, status);
    const std::size_t part =
        presence_.isAnyNoisy() ? same_noisy_scene_part : same_scene_part;
    if (part * hit_count_ < shown_count_ ||
        tracked_.count > mostTracked(frame.size())) {
      forgetVoxels();
      status = TemporalFilterStatus();
      update(frame, status);
    }
    if (isLeft(16) && presence_.returnsRarely()) {
      rest_.setMoving();
      forgetVoxels();
      status = TemporalFilterStatus();
      status.sensor_motion = io::SensorMotion::Moving;
      return;
    }
    judgeHolding();
    shown_count_ = keys_.size();
    frame.keys.swap(keys_);
    frame.intensities.swap(shown_intensities_);
    frame.colours.swap(shown_colours_);
  }

  void
  follow(const io::VoxelFrame& frame);

  void
  moveTo(const io::VoxelGrid& grid);

  void
  changeScale(const io::IntensityScale& scale);

  void
  forgetVoxels();

  void
  releaseMemory();

  void
  update(const io::VoxelFrame& frame, TemporalFilterStatus& status);

  /** \brief The cells of a block that are tracked, and those of the frame. */
  struct BlockCells {
    std::uint64_t key;
    std::uint64_t shown;
    std::uint64_t seldom;
    std::uint64_t hits;
  };

  /** \brief The voxels that come next. */
  struct Walk {
    const io::VoxelFrame& frame;
    TemporalFilterStatus& status;
    std::size_t tracked = 0;
    std::size_t hit = 0;
  };

  void
  updateBlock(const BlockCells& block, Walk& walk);

  void
  updateVoxel(const BlockCells& block,
              std::uint64_t bit,
              std::uint64_t is_near,
              Walk& walk);

  void
  learnValues(const io::VoxelFrame& frame, std::size_t voxel);

  void
  show(const io::VoxelFrame& frame, std::uint64_t key);

  /** \brief True if more than one of so many shown voxels has nothing near in the
   * frame. */
  bool
  isLeft(std::size_t part) const
  {
    return part * left_count_ > keys_.size();
  }

  void
  judgeHolding();

  unsigned int frames_;
  bool holds_; // what has nothing near may be held at all
  VoxelPresence presence_;
  std::optional<io::VoxelGrid> grid_; // of the last frame
  io::IntensityScale scale_;
  unsigned int colour_bits_ = 0;
  bool has_depth_model_ = false;
  TrackedVoxels tracked_;
  std::size_t shown_count_ = 0; // by the last frame
  std::size_t hit_count_ = 0;   // of these, those that the current frame has
  UsualDeviations usual_intensities_;
  UsualDeviations usual_colours_;

  DirectionDepths rays_;  // beyond the next frame, metres
  bool holds_now_ = true; // and is not too much
  FrameTicks frame_ticks_;
  SensorRest rest_;

  // Of the current frame; members so that their memory is reused.
  std::size_t left_count_ = 0; // shown voxels, or held ones, that it has nothing near
  TrackedVoxels next_;
  std::vector<std::uint64_t> keys_; // of the shown ones in the end
  std::vector<std::uint16_t> shown_intensities_;
  std::vector<io::VoxelColour> shown_colours_;
  bool is_interrupted_ = false;
  io::MemoryRule memory_rule_;
};

/** \brief Drops the history where the frame's values do not compare with it, and moves
 * it to the frame's grid. */
void
TemporalVoxelFilter::Implementation::follow(const io::VoxelFrame& frame)
{
  const io::VoxelGrid& grid = frame.grid;
  if (grid_ && (grid.resolution != grid_->resolution || grid.origin != grid_->origin ||
                frame.hasIntensities() != (scale_.bits > 0) ||
                frame.colour_bits != colour_bits_ ||
                frame.depth_model.has_value() != has_depth_model_)) {
    reset();
    is_interrupted_ = true;
  }
  // With a depth model values are numbers of points, whatever the scale.
  if (grid_ && frame.intensity_scale != scale_ && !has_depth_model_)
    changeScale(frame.intensity_scale);
  if (grid_ && grid != *grid_)
    moveTo(grid);
  grid_ = grid;
  scale_ = frame.intensity_scale;
  colour_bits_ = frame.colour_bits;
  has_depth_model_ = frame.depth_model.has_value();
}

/** \brief Changes the keys of the tracked voxels to those of another grid of the same
 * lattice, and drops those that are not in it. */
void
TemporalVoxelFilter::Implementation::moveTo(const io::VoxelGrid& grid)
{
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  order.reserve(tracked_.count);
  std::size_t voxel = 0;
  for (std::size_t i = 0; i < tracked_.blocks.size(); ++i)
    for (std::uint64_t left = tracked_.shown[i] | tracked_.seldom[i]; left != 0;
         left &= left - 1, ++voxel) {
      const io::VoxelPosition from =
          io::voxelPosition(tracked_.blocks[i] << io::block_key_bits | lowestBit(left));
      std::array<std::int64_t, 3> to = {from.x, from.y, from.z};
      bool is_inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        to[axis] += std::int64_t{grid_->first_index[axis]} - grid.first_index[axis];
        is_inside = is_inside && to[axis] >= 0 && to[axis] < grid.size();
      }
      if (is_inside)
        order.emplace_back(io::mortonKey({static_cast<std::uint32_t>(to[0]),
                                          static_cast<std::uint32_t>(to[1]),
                                          static_cast<std::uint32_t>(to[2])}),
                           voxel);
    }
  std::sort(order.begin(), order.end());
  next_.clear();
  next_.reserve(order.size(), colour_bits_ > 0);
  for (const auto& [key, i] : order) {
    next_.push(tracked_.voxels[i], tracked_.colourOf(i));
    const std::uint64_t cell = std::uint64_t{1} << key % io::block_cells;
    const bool is_shown = tracked_.voxels[i].is_shown;
    next_.pushBlock(
        key >> io::block_key_bits, is_shown ? cell : 0, is_shown ? 0 : cell);
  }
  std::swap(tracked_, next_);
}

/** \brief Changes the shown symbols to those of another scale, and learns values anew.
 */
void
TemporalVoxelFilter::Implementation::changeScale(const io::IntensityScale& scale)
{
  for (std::size_t i = 0; i < tracked_.count; ++i) {
    TrackedVoxel& voxel = tracked_.voxels[i];
    const std::uint32_t symbol =
        io::lowestSymbol(scale, scale_.value(voxel.intensity.shown()));
    voxel.intensity.restart(
        static_cast<std::uint16_t>(std::min(symbol, scale.maxSymbol())));
  }
  usual_intensities_ = UsualDeviations();
}

void
TemporalVoxelFilter::Implementation::forgetVoxels()
{
  tracked_.clear();
  presence_.forgetVoxels();
  shown_count_ = 0;
}

/** \brief Releases memory that the tracked voxels do not need. */
void
TemporalVoxelFilter::Implementation::releaseMemory()
{
  tracked_.shrinkToFit();
  next_ = TrackedVoxels();
  keys_ = std::vector<std::uint64_t>();
  shown_intensities_ = std::vector<std::uint16_t>();
  shown_colours_ = std::vector<io::VoxelColour>();
  presence_.releaseMemory();
  rays_ = DirectionDepths();
}

/** \brief Sets whether what has nothing near is held in the next frame: not where that is
 * a large part of what is shown. */
void
TemporalVoxelFilter::Implementation::judgeHolding()
{
  if (holds_now_) {
    holds_now_ = !isLeft(8);
    return;
  }
  // Where none is held the count is that of a frame, not of the time they may stay.
  holds_now_ = !isLeft(16 * presence_.framesHeld());
}

/** \brief Takes the intensity and the colour of a voxel of the frame for the last voxel
 * of next_. */
void
TemporalVoxelFilter::Implementation::learnValues(const io::VoxelFrame& frame,
                                                 std::size_t voxel)
{
  if (frame.hasIntensities())
    next_.voxels[next_.count - 1].intensity.add(valueOf(frame, voxel),
                                                usual_intensities_);
  if (frame.colour_bits > 0) {
    HeldColour& colour = next_.colours[next_.count - 1];
    colour[0].add(frame.colours[voxel].r, usual_colours_);
    colour[1].add(frame.colours[voxel].g, usual_colours_);
    colour[2].add(frame.colours[voxel].b, usual_colours_);
  }
}

/** \brief Lists the last voxel of next_ as shown. */
void
TemporalVoxelFilter::Implementation::show(const io::VoxelFrame& frame,
                                          std::uint64_t key)
{
  keys_.push_back(key);
  if (frame.hasIntensities())
    shown_intensities_.push_back(
        symbolOf(frame, key, next_.voxels[next_.count - 1].intensity.shown()));
  if (frame.colour_bits > 0) {
    HeldColour& colour = next_.colours[next_.count - 1];
    shown_colours_.push_back({static_cast<std::uint8_t>(colour[0].shown()),
                              static_cast<std::uint8_t>(colour[1].shown()),
                              static_cast<std::uint8_t>(colour[2].shown())});
  }
}

/** \brief Merges the frame's voxels with the tracked ones, and lists the shown ones. */
void
TemporalVoxelFilter::Implementation::update(const io::VoxelFrame& frame,
                                            TemporalFilterStatus& status)
{
  hit_count_ = 0;
  left_count_ = 0;
  next_.clear();
  keys_.clear();
  shown_intensities_.clear();
  shown_colours_.clear();
  next_.reserve(tracked_.count + frame.size(), frame.colour_bits > 0);
  const io::BlockList& hits = presence_.surfaces().occupied(0).blocks();
  Walk walk{frame, status};
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < tracked_.blocks.size() || j < hits.size()) {
    const std::uint64_t tracked =
        i < tracked_.blocks.size() ? tracked_.blocks[i] : no_key;
    const std::uint64_t hit = j < hits.size() ? hits.keys[j] : no_key;
    BlockCells block{std::min(tracked, hit), 0, 0, 0};
    if (tracked <= hit) {
      block.shown = tracked_.shown[i];
      block.seldom = tracked_.seldom[i++];
    }
    if (hit <= tracked)
      block.hits = hits.masks[j++];
    updateBlock(block, walk);
  }
  std::swap(tracked_, next_);
}

/** \brief Merges the voxels of a block. */
void
TemporalVoxelFilter::Implementation::updateBlock(const BlockCells& block, Walk& walk)
{
  const std::uint64_t is_near =
      presence_.nextToShown(
          tracked_, block.key, block.shown, block.hits & ~block.shown) |
      presence_.nextToHits(block.key, block.hits, block.shown & ~block.hits);
  const std::uint64_t tracked = block.shown | block.seldom;
  std::uint64_t shown = 0;
  std::uint64_t seldom = 0;
  for (std::uint64_t left = tracked | block.hits; left != 0; left &= left - 1) {
    const std::uint64_t bit = left & (0 - left);
    const bool is_tracked = (tracked & bit) != 0;
    if (is_tracked)
      next_.push(tracked_.voxels[walk.tracked], tracked_.colourOf(walk.tracked));
    else
      next_.push(TrackedVoxel(), next_.colours.empty() ? nullptr : &new_colour);
    walk.tracked += is_tracked ? 1 : 0;
    TrackedVoxel& voxel = next_.voxels[next_.count - 1];
    if (((block.shown | block.hits) & bit) != 0)
      updateVoxel(block, bit, is_near & bit, walk);
    else
      presence_.countMiss(voxel);
    const bool is_forgotten = (block.hits & bit) == 0 && presence_.isForgotten(voxel);
    const std::uint64_t kept = is_forgotten ? 0 : bit;
    next_.count -= is_forgotten ? 1 : 0;
    shown |= voxel.is_shown ? bit : 0;
    seldom |= voxel.is_shown ? 0 : kept;
  }
  hit_count_ += bitCount(block.shown & block.hits);
  next_.pushBlock(block.key, shown, seldom);
}

/** \brief Takes the last voxel of next_, which is shown or which the frame has.
 * \param[in] bit of its cell
 * \param[in] is_near whether one of the 26 around it is shown, if it is not, or the frame
 * has one, if it has it not */
void
TemporalVoxelFilter::Implementation::updateVoxel(const BlockCells& block,
                                                 std::uint64_t bit,
                                                 std::uint64_t is_near,
                                                 Walk& walk)
{
  const std::uint64_t key = block.key << io::block_key_bits | lowestBit(bit);
  const bool is_hit = (block.hits & bit) != 0;
  TrackedVoxel& voxel = next_.voxels[next_.count - 1];
  if (voxel.is_shown)
    presence_.countShown(key, voxel, is_hit);
  if (is_hit) {
    presence_.countHit(tracked_, key, is_near != 0, voxel);
    learnValues(walk.frame, walk.hit++);
    walk.status.hidden += voxel.is_shown ? 0 : 1;
  }
  else {
    left_count_ += presence_.countMiss(key, is_near != 0, holds_now_, voxel) ? 1 : 0;
    walk.status.held += voxel.is_shown ? 1 : 0;
  }
  if (voxel.is_shown)
    show(walk.frame, key);
}

TemporalVoxelFilter::TemporalVoxelFilter(unsigned int frames, bool holds)
: implementation_(std::make_unique<Implementation>(frames, holds))
{}

TemporalVoxelFilter::~TemporalVoxelFilter() = default;
TemporalVoxelFilter::TemporalVoxelFilter(TemporalVoxelFilter&&) noexcept = default;
TemporalVoxelFilter&
TemporalVoxelFilter::operator=(TemporalVoxelFilter&&) noexcept = default;

TemporalFilterStatus
TemporalVoxelFilter::filter(io::VoxelFrame& frame, const SensorView& view)
{
  return implementation_->filter(frame, view);
}

void
TemporalVoxelFilter::seeBeyond(io::PointBatches& points,
                               const io::BoundingBox& box,
                               const std::array<double, 3>& position)
{
  implementation_->seeBeyond(points, box, position);
}

void
TemporalVoxelFilter::reset()
{
  implementation_->reset();
}

std::size_t
TemporalVoxelFilter::rememberedVoxels() const
{
  return implementation_->rememberedVoxels();
}

} // namespace pcl_ext::PCL_EXT_ABI
