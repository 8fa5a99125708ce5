// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/received_stream.h"

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"
#include "stream/version1_header.h"
#include "voxels/point_voxels.h"

#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief Scratch memory of a thread for decoding, shared by all streams that it
 * decodes, so that it stays in the caches. */
struct ThreadMemory {
  io::DecodingMemory coding;
  io::VoxelFrame decoded;
  io::VoxelChanges changes;
  io::MemoryRule rule; ///< for `decoded` and `changes`
};

ThreadMemory&
memoryOfThread()
{
  thread_local ThreadMemory memory;
  return memory;
}

/** \brief Bytes of memory of the voxels and points of a frame. */
std::size_t
bytesOf(const io::VoxelFrame& frame)
{
  return frame.keys.size() * sizeof(frame.keys[0]) +
         frame.intensities.size() * sizeof(frame.intensities[0]) +
         frame.colours.size() * sizeof(frame.colours[0]) +
         frame.point_counts.size() * sizeof(frame.point_counts[0]) +
         frame.fieldValueCount() * sizeof(std::uint64_t) +
         frame.points.indices.size() * sizeof(frame.points.indices[0]) +
         frame.points.positions.size() * sizeof(frame.points.positions[0]) +
         frame.points.intensities.size() * sizeof(frame.points.intensities[0]) +
         frame.points.colours.size() * sizeof(frame.points.colours[0]);
}

/** \brief Voxels and points that a frame has memory for. */
std::size_t
capacityOf(const io::VoxelFrame& frame)
{
  return frame.keys.capacity() + frame.points.positions.capacity();
}

std::size_t
capacityOf(const io::VoxelChanges& changes)
{
  return capacityOf(changes.gone) + capacityOf(changes.came);
}

/** \brief True for a frame of which no voxels were made, as nothing was filtered. */
bool
hasPointsOnly(const io::VoxelFrame& frame)
{
  return frame.keys.empty() && !frame.points.indices.empty();
}

} // namespace

ReceivedStream::ReceivedStream(const std::string& name,
                               float min_intensity,
                               const io::DecoderLimits& limits)
: decoder_(limits)
, applied_min_intensity_(min_intensity)
, min_intensity_(min_intensity)
, share_(limits.budget, [this] { dropVoxels(); })
{
  health_.name = name;
}

void
ReceivedStream::setOutlierRemoval(
    const std::optional<VoxelOutlierRemovalSettings>& settings)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (settings == outlier_settings_)
    return;
  outlier_settings_ = settings;
  are_outlier_settings_new_ = true;
}

ReceivedStream::WaitingFrame
ReceivedStream::takeNext()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  WaitingFrame next = std::move(waiting_.front());
  waiting_.pop_front();
  sequence_.refuse(next.refused_before);
  return next;
}

void
ReceivedStream::refuseNext()
{
  takeNext();
  const std::lock_guard<std::mutex> lock(mutex_);
  ++health_.frames_refused;
  sequence_.refuse(1);
}

bool
ReceivedStream::endTurn()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  has_turn_ = !waiting_.empty();
  return has_turn_;
}

void
ReceivedStream::decodeNext(const Clock& clock, const FrameListener& listener)
{
  share_.begin();
  const auto start = std::chrono::steady_clock::now();
  const WaitingFrame frame = takeNext();
  bool is_decoded = false;
  io::CompressionStatus status = callOrElse(
      [&] { return decode(frame, start, clock, is_decoded); },
      outOfMemoryStatus<io::CompressionStatus>,
      [](const std::string& reason) {
        return io::CompressionStatus(io::CompressionCode::InputFailed, reason);
      });
  const bool has_voxels = status.ok();
  bool wants_i_frame = false;
  // Read below without the lock, as only this thread changes what is reported.
  const io::CompressionStatus* reported = &status;
  if (status.code() == io::CompressionCode::OldFrame) {
    const std::lock_guard<std::mutex> lock(mutex_);
    wants_i_frame = sequence_.addDropped(health_);
  }
  else if (!has_voxels) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::optional<std::uint32_t> none;
    wants_i_frame = sequence_.addFailed(
        std::move(status),
        is_decoded ? std::optional(decoder_.statistics().frame_number) : none,
        health_);
    reported = &health_.last_failure;
  }

  static const io::VoxelFrame no_voxels;
  static const io::CodedFrameStatistics no_statistics;
  are_voxels_wanted_ = false;
  const std::function<const io::VoxelFrame&()> voxels = [&]() -> const io::VoxelFrame& {
    return has_voxels ? listVoxels() : no_voxels;
  };
  if (listener)
    listener({health_.name,
              has_voxels ? latest_stamp_ : frame.stamp.value_or(Time(0)),
              *reported,
              voxels,
              has_voxels ? decoder_.statistics() : no_statistics,
              wants_i_frame});
  share_.end(keptBytes());
}

/** \brief The latest voxels, for the listener; empty if there is no memory for them. */
const io::VoxelFrame&
ReceivedStream::listVoxels()
{
  are_voxels_wanted_ = true;
  if (is_whole_)
    return latest_;
  io::VoxelFrame& voxels = memoryOfThread().decoded;
  const std::lock_guard<std::mutex> lock(decode_mutex_);
  if (!listDecoded(voxels))
    voxels = io::VoxelFrame();
  return voxels;
}

/** \brief Bytes that are kept beside the decoder's, an estimate that is rather too
 * high. */
std::size_t
ReceivedStream::keptBytes() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return 2 * bytesOf(latest_) + pending_.bytes() +
         (outlier_removal_ ? VoxelOutlierRemoval::bytes_of_voxel * latest_.size() : 0);
}

/** \brief Drops the voxels and the filter's history, as the memory is needed elsewhere.
 */
void
ReceivedStream::dropVoxels() noexcept
{
  outlier_removal_.reset();
  kept_ = io::VoxelFrame();
  const std::lock_guard<std::mutex> lock(mutex_);
  are_outlier_settings_new_ = outlier_settings_.has_value();
  latest_ = io::VoxelFrame();
  has_latest_ = false;
  pending_.end();
  ++health_.memory_drops;
  health_.lacks_voxels = true;
}

io::CompressionStatus
ReceivedStream::decode(const WaitingFrame& frame,
                       std::chrono::steady_clock::time_point start,
                       const Clock& clock,
                       bool& is_decoded)
{
  const std::lock_guard<std::mutex> lock(decode_mutex_);
  ThreadMemory& memory = memoryOfThread();
  const std::size_t capacity = capacityOf(memory.decoded) + capacityOf(memory.changes);
  makeOutlierRemoval();
  const float min_intensity = min_intensity_;
  const bool is_by_changes =
      is_plain_ && !outlier_removal_ && !are_voxels_wanted_ &&
      min_intensity == applied_min_intensity_ &&
      io::beginsFrameOfChanges(frame.bytes.data(), frame.bytes.size());
  if (!is_by_changes && areChangesKept())
    makeLatestWhole();
  io::CompressionStatus status =
      is_by_changes
          ? decoder_.decode(
                frame.bytes.data(), frame.bytes.size(), memory.changes, memory.coding)
          : decoder_.decode(
                frame.bytes.data(), frame.bytes.size(), memory.decoded, memory.coding);
  is_decoded = status.ok();
  std::size_t needed = 0;
  const auto make_latest = [&] {
    applied_min_intensity_ = min_intensity;
    const Denoised denoised = is_by_changes ? denoise(memory.changes, needed)
                                            : denoise(memory.decoded, needed);
    makeLatest(denoised, frame, start, clock);
    if (!is_by_changes)
      status = io::statusOfVoxels(latest_); // filters make voxels, too
  };
  const auto release = [&] {
    memory.decoded = io::VoxelFrame();
    kept_ = io::VoxelFrame();
    // The voxels are not those of the decoder any more.
    is_plain_ = false;
    const std::lock_guard<std::mutex> latest_lock(mutex_);
    pending_.end();
  };
  if (is_decoded)
    callOrCleanUp(make_latest, release);
  // A failed frame may have taken more memory than any other needs.
  const bool is_too_large =
      !is_decoded && capacityOf(memory.decoded) + capacityOf(memory.changes) > capacity;
  if (memory.rule.shouldRelease(needed) || is_too_large) {
    memory.decoded = io::VoxelFrame();
    memory.changes = io::VoxelChanges();
  }
  return status;
}

/** \brief Whether somebody takes the changes. */
bool
ReceivedStream::areChangesKept() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return pending_.areKept();
}

/** \brief Lists the latest voxels that are known from changes alone, before the decoder
 * forgets them, to compare the next ones with. */
void
ReceivedStream::makeLatestWhole()
{
  if (is_whole_)
    return;
  const bool is_listed = listDecoded(kept_);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!is_listed) {
    pending_.end();
    return;
  }
  std::swap(kept_, latest_);
  is_whole_ = true;
}

/** \brief Lists the voxels of the decoder's last frame that are not noise; decode_mutex_
 * is locked.
 * \return false if they are not known, or there is no memory for them */
bool
ReceivedStream::listDecoded(io::VoxelFrame& voxels)
{
  if (!decoder_.latestVoxels(voxels))
    return false;
  removeVoxelsBelow(voxels, applied_min_intensity_);
  if (is_packed_)
    voxels.layout.reset();
  return true;
}

/** \brief Takes the voxels of a frame, and not much more memory than they need. */
void
ReceivedStream::keep(io::VoxelFrame& frame)
{
  if (capacityOf(frame) <= 2 * (frame.keys.size() + frame.points.positions.size()))
    std::swap(kept_, frame);
  else
    kept_ = frame;
}

/** \brief Denoises a frame, and keeps it for makeLatest().
 * \param[out] needed bytes of memory
 */
ReceivedStream::Denoised
ReceivedStream::denoise(io::VoxelFrame& decoded, std::size_t& needed)
{
  needed = bytesOf(decoded);
  Denoised denoised;
  denoised.is_whole = true;
  denoised.outliers = removeOutliers(decoded);
  const std::size_t removed_below = removeVoxelsBelow(decoded, applied_min_intensity_);
  is_plain_ = !outlier_removal_;
  if (is_packed_)
    decoded.layout.reset();
  keep(decoded);
  denoised.voxels = hasPointsOnly(kept_) ? decoder_.statistics().voxels : kept_.size();
  denoised.all_voxels = denoised.voxels + removed_below + denoised.outliers.removed;
  denoised.resolution = kept_.grid.resolution;
  denoised.has_intensities = kept_.hasIntensities();
  denoised.points_outside_grid = kept_.points.outside_grid;
  return denoised;
}

/** \brief Denoises the changes of a frame.
 * \param[out] needed bytes of memory
 */
ReceivedStream::Denoised
ReceivedStream::denoise(io::VoxelChanges& changes, std::size_t& needed)
{
  needed = bytesOf(changes.gone) + bytesOf(changes.came);
  removeVoxelsBelow(changes.gone, applied_min_intensity_);
  removeVoxelsBelow(changes.came, applied_min_intensity_);
  Denoised denoised;
  // Only this thread changes what is reported.
  const std::size_t before = changes.is_from_nothing ? 0 : health_.kept_voxels;
  denoised.voxels = before + changes.came.size() - changes.gone.size();
  denoised.all_voxels = decoder_.statistics().voxels;
  denoised.resolution = changes.came.grid.resolution;
  denoised.has_intensities = changes.came.hasIntensities();
  return denoised;
}

/** \brief Makes what was denoised the latest voxels, or throws and leaves them as they
 * are. */
void
ReceivedStream::makeLatest(const Denoised& denoised,
                           const WaitingFrame& frame,
                           std::chrono::steady_clock::time_point start,
                           const Clock& clock)
{
  const std::chrono::duration<double> cycle = std::chrono::steady_clock::now() - start;

  Time stamp = frame.stamp.value_or(Time(0));
  if (!frame.stamp && decoder_.stamp())
    stamp = io::timeOfStamp(decoder_.stamp()->stamp);
  const Time now = clock();
  const io::CodedFrameStatistics& coding = decoder_.statistics();

  {
    const std::lock_guard<std::mutex> lock(mutex_);
    OutlierRemovalStatus outliers = denoised.outliers;
    if (denoised.is_whole)
      pending_.add(latest_, kept_);
    else
      pending_.add(memoryOfThread().changes);
    // The last statement that can throw.
    window_.add({now,
                 frame.bytes.size(),
                 cycle.count(),
                 latencySeconds(stamp, now).value_or(0.0)});
    sequence_.addDecoded(coding.frame_number, health_);
    health_.lacks_voxels = false;
    health_.decode_times.add(cycle.count());
    health_.kept_voxels = denoised.voxels;
    health_.voxels = denoised.all_voxels;
    health_.resolution = denoised.resolution;
    health_.has_intensities = denoised.has_intensities;
    health_.points_outside_grid += denoised.points_outside_grid;
    health_.outliers_removed = outliers.removed;
    health_.outlier_removal = std::move(outliers);
    health_.last_decoded = now;
    if (denoised.is_whole)
      std::swap(kept_, latest_);
    is_whole_ = denoised.is_whole;
    has_latest_ = true;
    latest_stamp_ = stamp;
  }
  frames_by_changes_ = denoised.is_whole ? 0 : frames_by_changes_ + 1;
  // Either of the two swapped frames may be too large; by changes none is needed.
  if (frames_by_changes_ == io::MemoryRule::frames) {
    const std::lock_guard<std::mutex> lock(mutex_);
    latest_ = io::VoxelFrame();
    frames_to_release_ = 1;
  }
  else if (denoised.is_whole && memory_rule_.shouldRelease(bytesOf(latest_)))
    frames_to_release_ = 2;
  if (frames_to_release_ == 0)
    return;
  --frames_to_release_;
  kept_ = io::VoxelFrame();
}

OutlierRemovalStatus
ReceivedStream::removeOutliers(io::VoxelFrame& frame)
{
  if (!outlier_removal_)
    return {};
  const auto replace_filter = [&] {
    outlier_removal_.reset();
    const std::lock_guard<std::mutex> lock(mutex_);
    are_outlier_settings_new_ = true;
  };
  return callOrCleanUp([&] { return outlier_removal_->filter(frame); }, replace_filter);
}

void
ReceivedStream::makeOutlierRemoval()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!are_outlier_settings_new_)
    return;
  outlier_removal_.reset();
  if (outlier_settings_)
    outlier_removal_.emplace(*outlier_settings_);
  // Not reached without memory for the filter: the next frame then creates it.
  are_outlier_settings_new_ = false;
}

std::optional<LatestFrame>
ReceivedStream::latestVoxels(io::VoxelFrame& voxels)
{
  const std::lock_guard<std::mutex> lock(decode_mutex_);
  return listLatest(voxels);
}

/** \brief Copies the latest voxels; decode_mutex_ is locked.
 * \return nothing if there are none */
std::optional<LatestFrame>
ReceivedStream::listLatest(io::VoxelFrame& voxels)
{
  const auto list = [&]() -> std::optional<LatestFrame> {
    if (!is_whole_ && !listDecoded(voxels))
      return std::nullopt;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!has_latest_)
      return std::nullopt;
    if (is_whole_)
      voxels = latest_;
    return latestFrame();
  };
  // After an exception the copy may have keys without intensities.
  return callOrCleanUp(list, [&] { voxels = io::VoxelFrame(); });
}

std::optional<LatestFrame>
ReceivedStream::take(const FrameSelection& selection,
                     std::size_t known,
                     TakenChanges& taken)
{
  taken.clear();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool is_selected = isSelected(selection);
    if (!is_selected && known == 0)
      return std::nullopt;
    if (is_selected && takePending(known, taken))
      return latestFrame();
  }
  const std::lock_guard<std::mutex> lock(decode_mutex_);
  return takeAll(selection, known, taken);
}

/** \brief Takes the changes since a frame; mutex_ is locked.
 * \return false if they are not known */
bool
ReceivedStream::takePending(std::size_t known, TakenChanges& taken)
{
  if (!pending_.areSince(known))
    return false;
  if (!pending_.areEmpty())
    pending_.take(health_.frames_decoded, taken.add());
  return true;
}

/** \brief As take(), but with all voxels, which came or are gone; decode_mutex_ is
 * locked. */
std::optional<LatestFrame>
ReceivedStream::takeAll(const FrameSelection& selection,
                        std::size_t known,
                        TakenChanges& taken)
{
  io::VoxelFrame voxels;
  const auto latest = listLatest(voxels);
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool is_selected = latest && isSelected(selection);
  // What is known is gone: it is brought up to the latest voxels first.
  taken.are_known = known == 0 || (latest && takePending(known, taken));
  if (is_selected && known != 0 && taken.are_known)
    return latest; // decoded meanwhile
  if (!is_selected) {
    pending_.end();
    if (known != 0 && taken.are_known)
      taken.addGone(voxels);
    return std::nullopt;
  }
  pending_.begin(latest->number);
  taken.addCame(voxels);
  return latest;
}

/** \brief Whether the latest voxels are of a selection; mutex_ is locked. If a clock was
 * set back, voxels may be newer than its time. */
bool
ReceivedStream::isSelected(const FrameSelection& selection) const
{
  const bool was_decoded_then = health_.last_decoded >= selection.oldest &&
                                health_.last_decoded <= selection.newest;
  const bool has_such_a_stamp = selection.stamps &&
                                latest_stamp_ >= selection.stamps->oldest &&
                                latest_stamp_ <= selection.stamps->newest;
  return has_latest_ && (was_decoded_then || has_such_a_stamp);
}

void
ReceivedStream::setMergedVoxels(std::size_t outside_grid,
                                std::size_t intensities_reduced)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  health_.voxels_outside_grid = outside_grid;
  health_.intensities_reduced = intensities_reduced;
  health_.merges_outside_grid += outside_grid > 0 ? 1 : 0;
  health_.merges_reduced += intensities_reduced > 0 ? 1 : 0;
}

StreamHealth
ReceivedStream::health(Time now) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  StreamHealth health = health_;
  health.rates = window_.rates(now);
  return health;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
