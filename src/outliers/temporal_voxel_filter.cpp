#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "bytes/reserve_ahead.h"
#include "outliers/block_neighbours.h"
#include "outliers/direction_depths.h"
#include "outliers/frame_ticks.h"
#include "outliers/held_value.h"
#include "outliers/region_filters.h"
#include "outliers/seen_depths.h"
#include "outliers/sensor_rest.h"
#include "outliers/surface_support.h"
#include "voxelizing/point_batches.h"
#include "voxels/intensity_symbols.h"
#include "voxels/memory_rule.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
inline namespace PCL_EXT_ABI {

namespace {

constexpr std::uint32_t one = 0xffff; // of an occupancy

/** \brief A voxel of the last frames. */
struct TrackedVoxel {
  std::uint64_t key;
  std::uint16_t occupancy;  ///< running mean, 2^16 is 1
  std::uint8_t empty_ticks; ///< since the last frame in which it was occupied
  bool is_shown;
  HeldValue intensity;
};

/** \brief When a voxel is shown by its occupancy and hidden. */
struct Persistence {
  std::uint32_t shown_above;  ///< occupancy
  std::uint32_t hidden_below; ///< occupancy
  unsigned int eighths;       ///< of the strength, that it may be empty
};

constexpr Persistence dense = {one * 3 / 5, one * 3 / 10, 5};

/** \brief Where not each frame hits all voxels of a surface: they are shown sooner and
 * hidden later. */
constexpr Persistence sparse = {one * 2 / 5, one / 7, 8};

using HeldColour = std::array<HeldValue, 3>;

/** \brief Of the voxels around one, tracked but not shown: where noise is usual. */
constexpr unsigned int least_seldom_neighbours = 2;
constexpr unsigned int most_seldom_neighbours = 5;

/** \brief One voxel of so many is asked whether the sensor can see it. */
constexpr std::size_t behind_sample_step = 32;

/** \brief A voxel is hidden when the sensor has seen through it for longer, ticks. In the
 * first of frames that follow sooner, most voxels that are empty are of a surface that is
 * in the next voxel there. */
constexpr unsigned int ticks_to_look = 4;

/** \brief A frame that has less than this part of the voxels that were shown before it,
 * one in so many, is of another scene. */
constexpr std::size_t same_scene_part = 8;

/** \brief The most voxels of the history. Surfaces and usual noise have up to four for
 * each voxel of a frame. */
constexpr std::size_t
mostTracked(std::size_t frame_voxels)
{
  return 8 * frame_voxels + (std::size_t{1} << 16);
}

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
  : frames_(frames)
  , holds_(holds)
  , rate_(0x10000 / std::max(frames, 1u))
  , least_occupancy_(rate_ * 3 / 4)
  {}

  TemporalFilterStatus
  filter(io::VoxelFrame& frame, const SensorView& view)
  {
    const DirectionDepths* rays = finite(view.position) ? &rays_ : nullptr;
    const TemporalFilterStatus status = filter(frame, view, rays);
    rays_.clear();
    return status;
  }

  TemporalFilterStatus
  filter(io::VoxelFrame& frame, const SensorView& view, const DirectionDepths* rays)
  {
    TemporalFilterStatus status = check(frame);
    if (!status.ok())
      return status;
    if (frame.regions) {
      if (!of_regions_)
        of_regions_ = std::make_unique<RegionTemporalFilter>(frames_, holds_);
      return of_regions_->filter(frame, view, rays);
    }
    if (is_interrupted_)
      reset();
    is_interrupted_ = true;
    follow(frame);
    takeTime(view.time);
    look(frame, finite(view.position), rays);
    surfaces_.learn(frame, [this](std::uint64_t key) { return distanceOf(key); });
    status.sensor_motion = rest_.judge(frame, surfaces_, finite(view.position), ticks_);
    if (status.sensor_motion == io::SensorMotion::Moving)
      forgetVoxels();
    else
      filterVoxels(frame, status);
    if (memory_rule_.shouldRelease(tracked_.size()))
      releaseMemory();
    is_interrupted_ = false;
    return status;
  }

  /** \brief The voxels of a sensor that rests. */
  void
  filterVoxels(io::VoxelFrame& frame, TemporalFilterStatus& status)
  {
    listSeldomVoxels(frame.grid.depth);
    update(frame, status);
    if (same_scene_part * hit_count_ < shown_count_ ||
        tracked_.size() > mostTracked(frame.size())) {
      forgetVoxels();
      status = TemporalFilterStatus();
      update(frame, status);
    }
    judgeHolding();
    shown_.assign(keys_, frame.grid.depth);
    shown_count_ = keys_.size();
    frame.keys.swap(keys_);
    frame.intensities.swap(shown_intensities_);
    frame.colours.swap(shown_colours_);
  }

  void
  seeBeyond(io::PointBatches& points,
            const io::BoundingBox& box,
            const std::array<double, 3>& position);

  void
  reset()
  {
    DirectionDepths rays = std::move(rays_); // of the next frame
    *this = Implementation(frames_, holds_);
    rays_ = std::move(rays);
  }

  std::size_t
  rememberedVoxels() const
  {
    return tracked_.size() + (of_regions_ ? of_regions_->rememberedVoxels() : 0);
  }

private:
  TemporalFilterStatus
  check(const io::VoxelFrame& frame) const
  {
    if (frames_ < least_frames || frames_ > most_frames)
      return {TemporalFilterCode::InvalidSettings,
              "frames is " + std::to_string(frames_) + "; it must be 2 to 64"};
    if (frame.has_point_counts || !frame.fields.empty())
      return {TemporalFilterCode::HasPointCounts,
              "the frame was not filtered: numbers of points and fields are those of "
              "one cloud"};
    return {};
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
  takeTime(const std::optional<std::chrono::nanoseconds>& time)
  {
    ticks_ = frame_ticks_.take(time);
    fall_ = std::min(ticks_ * 0x10000 / (FrameTicks::usual * frames_), one);
  }

  void
  look(const io::VoxelFrame& frame,
       const std::optional<std::array<double, 3>>& sensor_position,
       const DirectionDepths* rays);

  void
  listSeldomVoxels(unsigned int depth);

  bool
  isAmongSeldomVoxels(std::uint64_t key) const;

  void
  update(const io::VoxelFrame& frame, TemporalFilterStatus& status);

  void
  learnValues(const io::VoxelFrame& frame, std::size_t voxel);

  void
  show(const io::VoxelFrame& frame);

  bool
  hasEnded(const TrackedVoxel& voxel, const Persistence& persistence) const
  {
    return voxel.occupancy < persistence.hidden_below ||
           8 * voxel.empty_ticks > persistence.eighths * frames_ * FrameTicks::usual;
  }

  void
  countHit(TrackedVoxel& voxel) const;

  void
  countMiss(TrackedVoxel& voxel);

  void
  judgeHolding();

  /** \brief Square of the distance from the sensor, in voxels; 0 without one. */
  std::uint64_t
  distanceOf(std::uint64_t key) const
  {
    return has_depths_ ? depths_.squaredDistance(key) : 0;
  }

  unsigned int frames_;
  bool holds_; // what has nothing near may be held at all
  std::unique_ptr<RegionTemporalFilter> of_regions_; // made when it is needed
  std::uint32_t rate_;                               // of the running means, 2^16 is 1
  /** \brief Empty voxels of a lower one are forgotten. */
  std::uint32_t least_occupancy_;
  std::optional<io::VoxelGrid> grid_; // of the last frame
  io::IntensityScale scale_;
  unsigned int colour_bits_ = 0;
  bool has_depth_model_ = false;
  std::vector<TrackedVoxel> tracked_; // keys ascending
  std::vector<HeldColour> colours_;   // of each, with colours
  BlockNeighbours shown_;             // by the last frame
  std::size_t shown_count_ = 0;       // voxels of these
  std::size_t hit_count_ = 0;         // of these, those that the current frame has
  BlockNeighbours seldom_;            // tracked, but not shown by it
  SurfaceSupport surfaces_;
  UsualDeviations usual_intensities_;
  UsualDeviations usual_colours_;

  DirectionDepths rays_;  // beyond the next frame, metres
  bool holds_now_ = true; // and is not too much
  FrameTicks frame_ticks_;
  SensorRest rest_;

  // Of the current frame; members so that their memory is reused.
  unsigned int ticks_ = FrameTicks::usual; // since the last one
  std::size_t left_count_ = 0; // shown voxels, or held ones, that it has nothing near
  std::uint32_t fall_ = 0;     // of an occupancy where there is nothing, 2^16 is 1
  SeenDepths depths_;
  bool has_depths_ = false;
  std::vector<TrackedVoxel> next_;
  std::vector<HeldColour> next_colours_;
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
  order.reserve(tracked_.size());
  for (std::size_t i = 0; i < tracked_.size(); ++i) {
    const io::VoxelPosition from = io::voxelPosition(tracked_[i].key);
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
                         i);
  }
  std::sort(order.begin(), order.end());
  next_.clear();
  next_colours_.clear();
  keys_.clear();
  for (const auto& [key, i] : order) {
    next_.push_back(tracked_[i]);
    next_.back().key = key;
    if (!colours_.empty())
      next_colours_.push_back(colours_[i]);
    if (tracked_[i].is_shown)
      keys_.push_back(key);
  }
  tracked_.swap(next_);
  colours_.swap(next_colours_);
  shown_.assign(keys_, grid.depth);
}

/** \brief Changes the shown symbols to those of another scale, and learns values anew.
 */
void
TemporalVoxelFilter::Implementation::changeScale(const io::IntensityScale& scale)
{
  for (TrackedVoxel& voxel : tracked_) {
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
  colours_.clear();
  shown_.releaseMemory();
  seldom_.releaseMemory();
  shown_count_ = 0;
}

/** \brief Releases memory that the tracked voxels do not need. */
void
TemporalVoxelFilter::Implementation::releaseMemory()
{
  tracked_.shrink_to_fit();
  colours_.shrink_to_fit();
  keys_ = std::vector<std::uint64_t>();
  next_ = std::vector<TrackedVoxel>();
  next_colours_ = std::vector<HeldColour>();
  shown_intensities_ = std::vector<std::uint16_t>();
  shown_colours_ = std::vector<io::VoxelColour>();
  seldom_.releaseMemory();
  surfaces_.releaseMemory();
  depths_.releaseMemory();
  rays_ = DirectionDepths();
}

/** \brief Takes the ends of rays outside of a box. */
void
TemporalVoxelFilter::Implementation::seeBeyond(io::PointBatches& points,
                                               const io::BoundingBox& box,
                                               const std::array<double, 3>& position)
{
  rays_.clear();
  io::visitPoints(points, [&](const auto* point) {
    std::array<float, 3> from_sensor;
    bool is_inside = true;
    bool is_finite = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<double>(point[axis]);
      is_inside = is_inside && at >= box.min[axis] && at <= box.max[axis];
      from_sensor[axis] = static_cast<float>(at - position[axis]);
      is_finite = is_finite && std::isfinite(from_sensor[axis]);
    }
    if (is_finite && !is_inside)
      rays_.add(DirectionDepths::directionOf(from_sensor));
  });
}

/** \brief Sets what the sensor sees, if it can be at its position. */
void
TemporalVoxelFilter::Implementation::look(
    const io::VoxelFrame& frame,
    const std::optional<std::array<double, 3>>& sensor_position,
    const DirectionDepths* rays)
{
  has_depths_ = false;
  if (!sensor_position)
    return;
  depths_.assign(frame.keys, frame.grid, *sensor_position);
  std::size_t behind = 0;
  for (std::size_t i = 0; i < frame.size(); i += behind_sample_step)
    behind += depths_.isBehindOthers(frame.keys[i]) ? 1 : 0;
  has_depths_ = 4 * behind_sample_step * behind <= frame.size();
  if (rays != nullptr)
    depths_.add(*rays, frame.grid.resolution);
}

void
TemporalVoxelFilter::Implementation::listSeldomVoxels(unsigned int depth)
{
  keys_.resize(tracked_.size());
  std::size_t count = 0;
  for (const TrackedVoxel& voxel : tracked_) {
    keys_[count] = voxel.key;
    count += voxel.is_shown ? 0 : 1;
  }
  keys_.resize(count);
  seldom_.assign(keys_, depth);
}

/** \brief True where voxels come and go, as at the edges of things, whose pixels are
 * partly of what is behind. With more of them it is a surface that appears. */
bool
TemporalVoxelFilter::Implementation::isAmongSeldomVoxels(std::uint64_t key) const
{
  const unsigned int around = seldom_.count(key, most_seldom_neighbours + 1);
  return around >= least_seldom_neighbours && around <= most_seldom_neighbours;
}

void
TemporalVoxelFilter::Implementation::countHit(TrackedVoxel& voxel) const
{
  voxel.empty_ticks = 0;
  voxel.occupancy = static_cast<std::uint16_t>(
      voxel.occupancy + (((one - voxel.occupancy) * rate_) >> 16));
  if (voxel.is_shown)
    return;
  // Most voxels end here, next to a shown one.
  if (voxel.occupancy <= sparse.shown_above && shown_.count(voxel.key, 1) != 0)
    return;
  const std::uint64_t distance = distanceOf(voxel.key);
  const bool is_sparse = surfaces_.isSparse(distance);
  const bool is_frequent = voxel.occupancy > (is_sparse ? sparse : dense).shown_above;
  if (!is_frequent && shown_.count(voxel.key, 1) != 0)
    return;
  Support support = surfaces_.of(voxel.key, distance);
  if (support == Support::Enough && !is_frequent && !is_sparse &&
      isAmongSeldomVoxels(voxel.key))
    support = surfaces_.of(voxel.key, distance, 1);
  if (support == Support::Enough && !is_frequent)
    voxel.occupancy = one;
  voxel.is_shown =
      support == Support::Enough || (is_frequent && support == Support::Some);
}

void
TemporalVoxelFilter::Implementation::countMiss(TrackedVoxel& voxel)
{
  // A surface that is in the next voxel of this frame may be in this one in the next.
  const bool counts_frames = !voxel.is_shown || surfaces_.hasNeighbour(voxel.key);
  voxel.empty_ticks = static_cast<std::uint8_t>(std::min(
      voxel.empty_ticks + (counts_frames ? FrameTicks::usual : ticks_), 0xffu));
  voxel.occupancy = static_cast<std::uint16_t>(
      voxel.occupancy - ((voxel.occupancy * (counts_frames ? rate_ : fall_)) >> 16));
  if (!voxel.is_shown)
    return;
  if (has_depths_ && voxel.empty_ticks > ticks_to_look &&
      depths_.isSeenThrough(voxel.key)) {
    voxel.is_shown = false;
    voxel.occupancy = 0;
    return;
  }
  if (hasEnded(voxel, dense) &&
      (hasEnded(voxel, sparse) || !surfaces_.isSparse(distanceOf(voxel.key))))
    voxel.is_shown = false;
  else if (!counts_frames) {
    ++left_count_;
    voxel.is_shown = holds_ && holds_now_;
  }
}

/** \brief Sets whether what has nothing near is held in the next frame: not where that is
 * a large part of what is shown, as where a sensor moves slowly. Where two of three shown
 * voxels are empty it is the noise, which is larger than the voxels. */
void
TemporalVoxelFilter::Implementation::judgeHolding()
{
  if (holds_now_) {
    const bool is_noise = 3 * hit_count_ < shown_count_;
    holds_now_ = is_noise || 8 * left_count_ <= keys_.size();
    return;
  }
  // Where none is held the count is that of a frame, not of the time they may stay.
  const std::size_t frames_held =
      std::max(1u, dense.eighths * frames_ * FrameTicks::usual / 8 / ticks_);
  holds_now_ = 16 * left_count_ * frames_held <= keys_.size();
}

/** \brief Takes the intensity and the colour of a voxel of the frame for the last voxel
 * of next_. */
void
TemporalVoxelFilter::Implementation::learnValues(const io::VoxelFrame& frame,
                                                 std::size_t voxel)
{
  if (frame.hasIntensities())
    next_.back().intensity.add(valueOf(frame, voxel), usual_intensities_);
  if (frame.colour_bits > 0) {
    HeldColour& colour = next_colours_.back();
    colour[0].add(frame.colours[voxel].r, usual_colours_);
    colour[1].add(frame.colours[voxel].g, usual_colours_);
    colour[2].add(frame.colours[voxel].b, usual_colours_);
  }
}

/** \brief Lists the last voxel of next_ as shown. */
void
TemporalVoxelFilter::Implementation::show(const io::VoxelFrame& frame)
{
  TrackedVoxel& voxel = next_.back();
  keys_.push_back(voxel.key);
  if (frame.hasIntensities())
    shown_intensities_.push_back(symbolOf(frame, voxel.key, voxel.intensity.shown()));
  if (frame.colour_bits > 0) {
    HeldColour& colour = next_colours_.back();
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
  const bool has_colours = frame.colour_bits > 0;
  hit_count_ = 0;
  left_count_ = 0;
  next_.clear();
  next_colours_.clear();
  keys_.clear();
  shown_intensities_.clear();
  shown_colours_.clear();
  io::reserveAhead(next_, tracked_.size() + frame.size());
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < tracked_.size() || j < frame.size()) {
    const std::uint64_t tracked = i < tracked_.size() ? tracked_[i].key : no_key;
    const std::uint64_t hit = j < frame.size() ? frame.keys[j] : no_key;
    // In place, as a copy of the record would wait for its members to be written.
    TrackedVoxel& voxel = next_.emplace_back();
    if (has_colours)
      next_colours_.emplace_back();
    if (tracked <= hit) {
      if (has_colours)
        next_colours_.back() = colours_[i];
      voxel = tracked_[i++];
    }
    else
      voxel.key = hit;
    if (hit <= tracked) {
      hit_count_ += voxel.is_shown ? 1 : 0;
      countHit(voxel);
      learnValues(frame, j++);
      status.hidden += voxel.is_shown ? 0 : 1;
    }
    else {
      countMiss(voxel);
      status.held += voxel.is_shown ? 1 : 0;
    }
    if (voxel.is_shown)
      show(frame);
    else if (hit > tracked && voxel.occupancy < least_occupancy_) {
      next_.pop_back();
      if (has_colours)
        next_colours_.pop_back();
    }
  }
  tracked_.swap(next_);
  colours_.swap(next_colours_);
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

TemporalFilterStatus
TemporalVoxelFilter::filter(io::VoxelFrame& frame,
                            const SensorView& view,
                            const DirectionDepths* rays)
{
  return implementation_->filter(frame, view, rays);
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

} // namespace PCL_EXT_ABI
} // namespace pcl_ext
