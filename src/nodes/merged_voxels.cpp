// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/merged_voxels.h"

#include <pcl_ext/compression/compression_settings.h>

#include "platforms/run_at_once.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

constexpr float no_limit = std::numeric_limits<float>::infinity();
constexpr unsigned int most_threads = 8; // more would look at the same updates

/** \brief The lower one of the two middle values, which are reordered; 0 of none. */
double
median(std::vector<float>& values)
{
  if (values.empty())
    return 0.0;
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

bool
isAllowedOrigin(const std::array<double, 3>& origin)
{
  io::EncoderSettings settings;
  settings.origin = origin;
  return io::checkSettings(settings).ok();
}

} // namespace

MergedVoxels::MergedVoxels(double resolution,
                           const std::optional<Origin>& origin,
                           unsigned int threads)
: has_fixed_origin_(origin.has_value())
, threads_(std::min(threads, most_threads))
, sums_(threads_)
{
  scale_.grid.resolution = resolution;
  scale_.grid.origin = origin.value_or(Origin{});
  scale_.limit = no_limit;
}

std::vector<MergedStream>
MergedVoxels::merge(const Streams& streams, const FrameSelection& selection)
{
  // Behind what is written of the last one.
  if (std::exchange(is_release_due_, false))
    releaseMemory();
  setEntries(streams, selection);
  updateSums(selection);
  constexpr std::size_t bytes_of_voxel = 32;
  is_release_due_ = memory_rule_.shouldRelease(voxelCount() * bytes_of_voxel);
  std::vector<MergedStream> merged_streams;
  for (const auto& [name, stream] : streams) {
    const Entry& entry = entries_.at(name);
    stream->setMergedVoxels(entry.voxels.outsideLattice(),
                            entry.voxels.countAbove(scale_.limit));
    merged_streams.push_back({name, entry.frame});
  }
  return merged_streams;
}

void
MergedVoxels::releaseMemory() noexcept
{
  entries_.clear();
  all_.clear();
  sums_.clear();
  are_changes_listed_ = false;
  has_grid_ = false;
  writer_.releaseMemory();
}

/** \brief Calls work(entry, thread) for all streams. */
template <typename WorkT>
void
MergedVoxels::forEachEntry(const WorkT& work)
{
  constexpr std::size_t few = 16; // hardly worth a thread
  std::atomic<std::size_t> next{0};
  io::runAtOnce(std::min(threads_, 1 + all_.size() / few), [&](std::size_t thread) {
    for (std::size_t i = next++; i < all_.size(); i = next++)
      work(*all_[i], thread);
  });
}

void
MergedVoxels::setEntries(const Streams& streams, const FrameSelection& selection)
{
  for (const auto& [name, stream] : streams) {
    Entry& entry = entries_[name];
    entry.source = stream;
    entry.has_any_time = selection.stamps && selection.stamps->streams.count(name) > 0;
  }
  all_.clear();
  for (auto& [name, entry] : entries_)
    all_.push_back(&entry);
}

/** \brief Takes what has changed in all streams.
 * \return false if that is not known of all, so that all has to be entered anew */
bool
MergedVoxels::follow(const FrameSelection& selection)
{
  std::atomic<bool> are_known{true};
  forEachEntry([&](Entry& entry, std::size_t) {
    if (!followStream(selection, entry))
      are_known = false;
  });
  return are_known;
}

bool
MergedVoxels::followStream(const FrameSelection& selection, Entry& entry)
{
  const bool has_voxels = entry.frame.has_value();
  const bool is_same_stream =
      entry.source != nullptr && entry.stream.lock() == entry.source;
  TakenChanges& taken = entry.voxels.taken();
  const std::size_t known = is_same_stream && has_voxels ? entry.frame->number : 0;
  static const FrameSelection any_time;
  entry.frame.reset();
  if (entry.source != nullptr)
    entry.frame =
        entry.source->take(entry.has_any_time ? any_time : selection, known, taken);
  entry.stream = entry.source;
  // Those of another stream are known to nobody.
  if (!taken.are_known || (has_voxels && !is_same_stream))
    return false;
  entry.voxels.follow();
  return true;
}

/** \brief Enters what has changed in streams. */
void
MergedVoxels::updateSums(const FrameSelection& selection)
{
  if (!follow(selection) || !updateChanged())
    enterAll(selection);
  endUpdate();
}

/** \brief Adds what has changed to the sums.
 * \return false if all has to be entered anew */
bool
MergedVoxels::updateChanged()
{
  const bool are_any_changed =
      std::any_of(all_.begin(), all_.end(), [](const Entry* entry) {
        return entry->voxels.isChanged();
      });
  if (setScale() || !has_grid_ || !writeUpdates())
    return false;
  if (are_any_changed && !has_fixed_origin_ && outsideLattice() > 0)
    return false; // another origin may be better
  addUpdates(areUpdatesFew());
  return !isGridFarTooLarge();
}

/** \brief Whether changes are so few that it helps to know them. */
bool
MergedVoxels::areUpdatesFew() const
{
  std::size_t updates = 0;
  for (const Entry* entry : all_)
    updates += entry->voxels.updates().updates.size();
  return updates <= sums_.size() / 2;
}

void
MergedVoxels::endUpdate()
{
  forEachEntry([](Entry& entry, std::size_t) { entry.voxels.endUpdate(); });
  for (auto entry = entries_.begin(); entry != entries_.end();)
    entry = entry->second.source == nullptr ? entries_.erase(entry) : std::next(entry);
  all_.clear();
  for (auto& [name, entry] : entries_) {
    entry.source.reset();
    all_.push_back(&entry);
  }
}

/** \brief Writes the updates of all streams.
 * \return false if voxels came outside of the grid */
bool
MergedVoxels::writeUpdates()
{
  std::atomic<bool> are_all_in_grid{true};
  forEachEntry([&](Entry& entry, std::size_t) {
    if (!entry.voxels.writeUpdates(scale_))
      are_all_in_grid = false;
  });
  return are_all_in_grid;
}

void
MergedVoxels::addUpdates(bool lists_changes)
{
  are_changes_listed_ = lists_changes;
  std::vector<const VoxelUpdates*> of_streams;
  for (const Entry* entry : all_)
    of_streams.push_back(&entry->voxels.updates());
  sums_.add(of_streams, lists_changes);
}

/** \brief Enters all voxels of all streams anew, on a grid that has them. */
void
MergedVoxels::enterAll(const FrameSelection& selection)
{
  sums_.clear();
  for (Entry* entry : all_) {
    entry->voxels.forget();
    entry->frame.reset();
  }
  follow(selection);
  setScale();
  std::optional<io::LatticeRange> range;
  if (moveOrigin(measureAll(scale_.grid.origin, range)))
    measureAll(scale_.grid.origin, range);
  constexpr bool may_refit = true; // merged frames are independent
  if (range)
    scale_.grid = io::adaptGrid(scale_.grid, has_grid_, may_refit, *range);
  has_grid_ |= range.has_value();
  writeUpdates();
  addUpdates(false);
}

/** \brief Number of voxels on the lattice of an origin.
 * \param[out] range of their indices; nothing if there are none */
std::size_t
MergedVoxels::measureAll(const Origin& origin,
                         std::optional<io::LatticeRange>& range) const
{
  range.reset();
  std::size_t on_lattice = 0;
  for (const Entry* entry : all_)
    on_lattice += entry->voxels.measure(scale_.grid.resolution, origin, range);
  return on_lattice;
}

std::size_t
MergedVoxels::outsideLattice() const
{
  std::size_t outside = 0;
  for (const Entry* entry : all_)
    outside += entry->voxels.outsideLattice();
  return outside;
}

std::size_t
MergedVoxels::voxelCount() const
{
  std::size_t count = 0;
  for (const Entry* entry : all_)
    count += entry->voxels.size();
  return count;
}

/** \brief Moves the origin to where more voxels are on its lattice, if there is such a
 * one.
 * \param[in] on_lattice number of voxels on that of the origin */
bool
MergedVoxels::moveOrigin(std::size_t on_lattice)
{
  const Origin before = scale_.grid.origin;
  const std::size_t all = voxelCount();
  if (has_fixed_origin_ || on_lattice == all)
    return false;
  const auto try_origin = [&](const Origin& origin) {
    if (on_lattice == all || !isAllowedOrigin(origin))
      return;
    std::optional<io::LatticeRange> range;
    const std::size_t count = measureAll(origin, range);
    if (count <= on_lattice)
      return;
    on_lattice = count;
    scale_.grid.origin = origin;
  };
  try_origin(Origin{});
  for (const Entry* entry : all_) {
    if (!entry->frame)
      continue;
    // A corner of a voxel about the world's origin, amid the stream's grid.
    const io::VoxelGrid& grid = entry->voxels.grid();
    const auto half = static_cast<std::uint32_t>(grid.size() / 2);
    Origin corner;
    for (std::size_t axis = 0; axis < 3; ++axis)
      corner[axis] = std::round(grid.centre(axis, half) / scale_.grid.resolution) *
                     scale_.grid.resolution;
    try_origin(corner);
  }
  return scale_.grid.origin != before;
}

/** \brief Whether a grid for the voxels alone would be another one, see adaptGrid(). */
bool
MergedVoxels::isGridFarTooLarge() const
{
  constexpr unsigned int levels_of_quarters = 2;
  if (!has_grid_ || scale_.grid.depth <= levels_of_quarters)
    return false;
  // A grid that is far too large has voxels in two adjacent quarters of each axis at
  // most.
  const unsigned int bits_of_part = 3 * (scale_.grid.depth - levels_of_quarters);
  std::array<unsigned int, 3> quarters{}; // a bit for each
  constexpr std::uint64_t parts = 64;
  for (std::uint64_t part = 0; part < parts; ++part)
    if (sums_.hasAnyBetween(part << bits_of_part, (part + 1) << bits_of_part)) {
      const io::VoxelPosition position = io::voxelPosition(part);
      quarters[0] |= 1u << position.x;
      quarters[1] |= 1u << position.y;
      quarters[2] |= 1u << position.z;
    }
  const auto are_adjacent = [](unsigned int mask) {
    return mask == 1 || mask == 2 || mask == 4 || mask == 8 || mask == 3 || mask == 6 ||
           mask == 12;
  };
  if (!std::all_of(quarters.begin(), quarters.end(), are_adjacent))
    return false;
  const auto range = rangeOfSums();
  return range && io::adaptGrid(scale_.grid, true, true, *range) != scale_.grid;
}

/** \brief Range of the indices of the merged voxels; nothing if there are none. */
std::optional<io::LatticeRange>
MergedVoxels::rangeOfSums() const
{
  std::optional<io::LatticeRange> range;
  const CentreLattice::Index& first = scale_.grid.first_index;
  sums_.forEach([&](std::uint64_t key, std::int64_t, const SummedColour&) {
    const io::VoxelPosition position = io::voxelPosition(key);
    const CentreLattice::Index index{first[0] + static_cast<std::int32_t>(position.x),
                                     first[1] + static_cast<std::int32_t>(position.y),
                                     first[2] + static_cast<std::int32_t>(position.z)};
    range = range ? io::unite(*range, {index, index}) : io::LatticeRange{index, index};
  });
  return range;
}

double
MergedVoxels::typicalIntensity() const
{
  std::vector<float> medians;
  for (const Entry* entry : all_)
    if (const std::optional<float> magnitude = entry->voxels.medianMagnitude())
      medians.push_back(*magnitude);
  return median(medians);
}

/** \brief The largest magnitude of an intensity beside which those of all streams have
 * steps on a scale of 16 bits, see CentralNode::merge; no_limit if none is larger. */
float
MergedVoxels::intensityLimit() const
{
  constexpr double most_steps = 65535.0;
  constexpr double steps_of_typical = 64.0;
  io::CommonStep step;
  float highest = 0.0f;
  std::size_t streams = 0;
  for (const Entry* entry : all_) {
    entry->voxels.addTo(step);
    highest = std::max(highest, entry->voxels.highest());
    streams += entry->frame ? 1 : 0;
  }
  const double exact = step.divisor() == 0 ? 0.0 : most_steps / step.divisor();
  if (static_cast<double>(highest) <= exact || streams < 2)
    return no_limit;
  // As long as a typical intensity has a step, those above it are as bright as they
  // are.
  const double typical = typicalIntensity();
  if (static_cast<double>(highest) <= typical * most_steps)
    return no_limit;
  const double limit = std::max(exact, typical * most_steps / steps_of_typical);
  return limit < static_cast<double>(highest) ? static_cast<float>(limit) : no_limit;
}

/** \brief Sets what intensities add to sums.
 * \return whether it is something else than before */
bool
MergedVoxels::setScale()
{
  // A sum of 2^28 of the largest intensities, as many as a frame may have, has less than
  // 63 bits.
  constexpr int bits_of_highest = 34;
  constexpr int spare_bits = 1;
  constexpr int most_spare_bits = 5;
  const float limit = intensityLimit();
  float highest = 0.0f;
  for (const Entry* entry : all_)
    highest = std::max(highest, std::min(limit, entry->voxels.highest()));
  const bool is_other_limit = limit != scale_.limit;
  scale_.limit = limit;
  int exponent = 0;
  std::frexp(highest, &exponent);
  if (highest == 0.0f || (highest_exponent_ && exponent <= *highest_exponent_ &&
                          exponent >= *highest_exponent_ - most_spare_bits))
    return is_other_limit;
  highest_exponent_ = exponent + spare_bits;
  scale_.units = std::ldexp(1.0, bits_of_highest - *highest_exponent_);
  return true;
}

/** \brief The common step of the intensities on the lattice. */
io::CommonStep
MergedVoxels::commonStep() const
{
  io::CommonStep common;
  for (const Entry* entry : all_) {
    const EnteredStream& voxels = entry->voxels;
    if (voxels.outsideLattice() == voxels.size())
      continue;
    if (scale_.limit < voxels.highest())
      voxels.addTo(common, scale_.limit);
    else
      voxels.addTo(common);
  }
  return common;
}

bool
MergedVoxels::listChanges(io::VoxelChanges& changes)
{
  return are_changes_listed_ &&
         writer_.listChanges({sums_, scale_, commonStep()}, changes);
}

void
MergedVoxels::write(io::VoxelFrame& merged)
{
  writer_.write({sums_, scale_, commonStep()}, merged);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
