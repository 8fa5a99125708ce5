// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/received_stream.h"

#include <pcl_ext/compression/cloud_encoder.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"
#include "voxels/point_voxels.h"

#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

ReceivedStream::ReceivedStream(const std::string& name,
                               float min_intensity,
                               const io::DecoderLimits& limits)
: decoder_(min_intensity, limits), share_(limits.budget, [this] { dropVoxels(); })
{
  health_.name = name;
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
  const std::lock_guard<std::mutex> lock(decode_mutex_);
  return decoder_.latestVoxels();
}

/** \brief Bytes that are kept beside the decoder's, an estimate that is rather too
 * high. */
std::size_t
ReceivedStream::keptBytes() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return 2 * bytesOf(latest_) + pending_.bytes() + decoder_.filterBytes(latest_.size());
}

/** \brief Drops the voxels and the filter's history, as the memory is needed elsewhere.
 */
void
ReceivedStream::dropVoxels() noexcept
{
  decoder_.dropHistory();
  kept_ = io::VoxelFrame();
  const std::lock_guard<std::mutex> lock(mutex_);
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
  const bool is_by_changes = decoder_.begin(frame.bytes) && !are_voxels_wanted_;
  if (!is_by_changes && areChangesKept())
    makeLatestWhole();
  io::CompressionStatus status = decoder_.decode(frame.bytes, is_by_changes);
  is_decoded = status.ok();
  const auto make_latest = [&] {
    // Only this thread changes what is reported.
    const DenoisedFrame denoised = is_by_changes
                                       ? decoder_.denoiseChanges(health_.kept_voxels)
                                       : decoder_.denoise(kept_);
    makeLatest(denoised, frame, start, clock);
    if (!is_by_changes)
      status = io::statusOfVoxels(latest_); // filters make voxels, too
  };
  const auto discard = [&] {
    decoder_.discard();
    kept_ = io::VoxelFrame();
    const std::lock_guard<std::mutex> latest_lock(mutex_);
    pending_.end();
  };
  if (is_decoded)
    callOrCleanUp(make_latest, discard);
  decoder_.end();
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
  const bool is_listed = decoder_.latestVoxels(kept_);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!is_listed) {
    pending_.end();
    return;
  }
  std::swap(kept_, latest_);
  is_whole_ = true;
}

/** \brief Makes what was denoised the latest voxels, or throws and leaves them as they
 * are. */
void
ReceivedStream::makeLatest(const DenoisedFrame& denoised,
                           const WaitingFrame& frame,
                           std::chrono::steady_clock::time_point start,
                           const Clock& clock)
{
  const bool is_whole = denoised.changes == nullptr;
  const std::chrono::duration<double> cycle = std::chrono::steady_clock::now() - start;

  Time stamp = frame.stamp.value_or(Time(0));
  if (!frame.stamp && decoder_.stamp())
    stamp = io::timeOfStamp(decoder_.stamp()->stamp);
  const Time now = clock();
  const io::CodedFrameStatistics& coding = decoder_.statistics();

  {
    const std::lock_guard<std::mutex> lock(mutex_);
    OutlierRemovalStatus outliers = denoised.outliers;
    if (is_whole)
      pending_.add(latest_, kept_);
    else
      pending_.add(*denoised.changes);
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
    if (is_whole)
      std::swap(kept_, latest_);
    is_whole_ = is_whole;
    has_latest_ = true;
    latest_stamp_ = stamp;
  }
  frames_by_changes_ = is_whole ? 0 : frames_by_changes_ + 1;
  // Either of the two swapped frames may be too large; by changes none is needed.
  if (frames_by_changes_ == io::MemoryRule::frames) {
    const std::lock_guard<std::mutex> lock(mutex_);
    latest_ = io::VoxelFrame();
    frames_to_release_ = 1;
  }
  else if (is_whole && memory_rule_.shouldRelease(bytesOf(latest_)))
    frames_to_release_ = 2;
  if (frames_to_release_ == 0)
    return;
  --frames_to_release_;
  kept_ = io::VoxelFrame();
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
    if (!is_whole_ && !decoder_.latestVoxels(voxels))
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
