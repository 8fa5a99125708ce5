// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "outliers/direction_depths.h"
#include "outliers/frame_ticks.h"
#include "outliers/sensor_rest.h"
#include "outliers/voxel_history.h"
#include "voxels/memory_rule.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

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
    rays_.addBeyond(points, box, position);
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
    return history_.size();
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
    if (memory_rule_.shouldRelease(rememberedVoxels())) {
      history_.moveTo(frame.grid, frame.grid); // where it is, without spare memory
      presence_.releaseMemory();
      rays_ = DirectionDepths();
    }
    is_interrupted_ = false;
  }

  /** \brief The voxels of a sensor that rests, unless they show that it moves. */
  void
  filterVoxels(io::VoxelFrame& frame, TemporalFilterStatus& status)
  {
    presence_.beginVoxels();
    counts_ = history_.update(frame, presence_, holds_ && holds_now_);
    const std::size_t part =
        presence_.hitShares().isAnyNoisy() ? same_noisy_scene_part : same_scene_part;
    if (part * counts_.hit < shown_count_ ||
        rememberedVoxels() > mostTracked(frame.size())) {
      forgetVoxels();
      status = TemporalFilterStatus();
      counts_ = history_.update(frame, presence_, holds_ && holds_now_);
    }
    status.held = counts_.held;
    status.hidden = frame.size() - (counts_.shown - counts_.held);
    if (isLeft(16) && presence_.hitShares().returnsRarely()) {
      rest_.setMoving();
      forgetVoxels();
      status = TemporalFilterStatus();
      status.sensor_motion = io::SensorMotion::Moving;
      return;
    }
    // What has nothing near is held in the next frame if it is not a large part of what
    // is shown. Where none is held the count is that of a frame, not of the time they may
    // stay.
    holds_now_ = !isLeft(holds_now_ ? 8 : 16 * presence_.framesHeld());
    shown_count_ = counts_.shown;
    history_.show(frame, shown_count_);
  }

  /** \brief Drops the history where the frame's values do not compare with it, and moves
   * it to the frame's grid. */
  void
  follow(const io::VoxelFrame& frame)
  {
    const io::VoxelGrid& grid = frame.grid;
    if (grid_ &&
        (grid.resolution != grid_->resolution || grid.origin != grid_->origin ||
         frame.hasIntensities() != (scale_.bits > 0) ||
         frame.colour_bits != colour_bits_ ||
         frame.depth_model.has_value() != has_depth_model_)) {
      reset();
      is_interrupted_ = true;
    }
    // With a depth model values are numbers of points, whatever the scale.
    if (grid_ && frame.intensity_scale != scale_ && !has_depth_model_)
      history_.changeScale(frame.intensity_scale, scale_);
    if (grid_ && grid != *grid_)
      history_.moveTo(grid, *grid_);
    grid_ = grid;
    scale_ = frame.intensity_scale;
    colour_bits_ = frame.colour_bits;
    has_depth_model_ = frame.depth_model.has_value();
  }

  void
  forgetVoxels()
  {
    history_.forget();
    shown_count_ = 0;
  }

  /** \brief True if more than one of so many shown voxels has nothing near in the
   * frame. */
  bool
  isLeft(std::size_t part) const
  {
    return part * counts_.left > counts_.shown;
  }

  unsigned int frames_;
  bool holds_; // what has nothing near may be held at all
  VoxelPresence presence_;
  std::optional<io::VoxelGrid> grid_; // of the last frame
  io::IntensityScale scale_;
  unsigned int colour_bits_ = 0;
  bool has_depth_model_ = false;
  VoxelHistory history_;
  VoxelHistory::Counts counts_; // of the current frame
  std::size_t shown_count_ = 0; // by the last frame
  DirectionDepths rays_;        // beyond the next frame, metres
  bool holds_now_ = true;       // and is not too much
  FrameTicks frame_ticks_;
  SensorRest rest_;
  bool is_interrupted_ = false;
  io::MemoryRule memory_rule_;
};

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
