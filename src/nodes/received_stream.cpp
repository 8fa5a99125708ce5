// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/received_stream.h"

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include "bytes/exceptions.h"
#include "nodes/latency.h"
#include "voxels/point_voxels.h"

#include <utility>

namespace pcl_ext {
namespace nodes {

namespace {

/** \brief Scratch memory of a thread for decoding, shared by all streams that it
 * decodes, so that it stays in the caches. */
struct ThreadMemory {
  io::DecodingMemory coding;
  io::VoxelFrame decoded;
  io::MemoryRule rule; ///< for `decoded`
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

/** \brief True for a frame of which no voxels were made, as nothing was filtered. */
bool
hasPointsOnly(const io::VoxelFrame& frame)
{
  return frame.keys.empty() && !frame.points.indices.empty();
}

/** \brief True if the bytes had no frame, so that no frame of the sender is lost. */
bool
wasNoFrame(io::CompressionCode code)
{
  return code == io::CompressionCode::NoFrame ||
         code == io::CompressionCode::EndOfStream;
}

} // namespace

ReceivedStream::ReceivedStream(const std::string& name,
                               float min_intensity,
                               const io::DecoderLimits& limits)
: decoder_(limits)
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
  unnumbered_ += next.refused_before;
  return next;
}

void
ReceivedStream::refuseNext()
{
  takeNext();
  const std::lock_guard<std::mutex> lock(mutex_);
  ++health_.frames_refused;
  ++unnumbered_;
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
  if (status.code() == io::CompressionCode::OldFrame)
    wants_i_frame = countDropped();
  else if (!has_voxels) {
    wants_i_frame = countFailed(std::move(status), is_decoded);
    reported = &health_.last_failure;
  }

  static const io::VoxelFrame no_voxels;
  static const io::CodedFrameStatistics no_statistics;
  if (listener)
    listener({health_.name,
              has_voxels ? latest_stamp_ : frame.stamp.value_or(Time(0)),
              *reported,
              has_voxels ? latest_ : no_voxels,
              has_voxels ? decoder_.statistics() : no_statistics,
              wants_i_frame});
  share_.end(keptBytes());
}

/** \brief Bytes that are kept beside the decoder's, an estimate that is rather too
 * high. */
std::size_t
ReceivedStream::keptBytes() const
{
  return 2 * bytesOf(latest_) +
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
  ++health_.memory_drops;
  health_.lacks_voxels = true;
}

io::CompressionStatus
ReceivedStream::decode(const WaitingFrame& frame,
                       std::chrono::steady_clock::time_point start,
                       const Clock& clock,
                       bool& is_decoded)
{
  ThreadMemory& memory = memoryOfThread();
  io::VoxelFrame& decoded = memory.decoded;
  const std::size_t capacity = capacityOf(decoded);
  io::CompressionStatus status =
      decoder_.decode(frame.bytes.data(), frame.bytes.size(), decoded, memory.coding);
  is_decoded = status.ok();
  const std::size_t needed = bytesOf(decoded);
  const auto release = [&] {
    decoded = io::VoxelFrame();
    kept_ = io::VoxelFrame();
  };
  if (is_decoded) {
    callOrCleanUp([&] { makeLatest(decoded, frame, start, clock); }, release);
    status = io::statusOfVoxels(latest_); // filters make voxels, too
  }
  // A failed frame may have taken more memory than any other needs.
  const bool is_too_large = !is_decoded && capacityOf(decoded) > capacity;
  if (memory.rule.shouldRelease(needed) || is_too_large)
    decoded = io::VoxelFrame();
  return status;
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

void
ReceivedStream::makeLatest(io::VoxelFrame& decoded,
                           const WaitingFrame& frame,
                           std::chrono::steady_clock::time_point start,
                           const Clock& clock)
{
  OutlierRemovalStatus outliers = removeOutliers(decoded);
  const std::size_t removed_below = removeVoxelsBelow(decoded, min_intensity_);
  if (is_packed_)
    decoded.layout.reset();
  keep(decoded);
  const std::chrono::duration<double> cycle = std::chrono::steady_clock::now() - start;

  Time stamp = frame.stamp.value_or(Time(0));
  if (!frame.stamp && decoder_.stamp())
    stamp = io::timeOfStamp(decoder_.stamp()->stamp);
  const Time now = clock();
  const io::CodedFrameStatistics& coding = decoder_.statistics();

  {
    const std::lock_guard<std::mutex> lock(mutex_);
    // The last statement that can throw.
    window_.add({now,
                 frame.bytes.size(),
                 cycle.count(),
                 latencySeconds(stamp, now).value_or(0.0)});
    follow(coding.frame_number);
    ++health_.frames_decoded;
    health_.lacks_voxels = false;
    health_.decode_times.add(cycle.count());
    health_.kept_voxels = hasPointsOnly(kept_) ? coding.voxels : kept_.size();
    health_.voxels = health_.kept_voxels + removed_below + outliers.removed;
    health_.resolution = kept_.grid.resolution;
    health_.has_intensities = kept_.hasIntensities();
    health_.points_outside_grid += kept_.points.outside_grid;
    health_.outliers_removed = outliers.removed;
    health_.outlier_removal = std::move(outliers);
    health_.last_decoded = now;
    std::swap(kept_, latest_);
    has_latest_ = true;
    latest_stamp_ = stamp;
  }
  // Either of the two swapped frames may be too large.
  if (memory_rule_.shouldRelease(bytesOf(latest_)))
    frames_to_release_ = 2;
  if (frames_to_release_ == 0)
    return;
  --frames_to_release_;
  kept_ = io::VoxelFrame();
}

OutlierRemovalStatus
ReceivedStream::removeOutliers(io::VoxelFrame& frame)
{
  makeOutlierRemoval();
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

bool
ReceivedStream::wantsIFrame(io::CompressionCode code)
{
  switch (code) {
  case io::CompressionCode::MissingReference:
  case io::CompressionCode::Corrupt:
  case io::CompressionCode::Truncated:
  case io::CompressionCode::InputFailed:
  case io::CompressionCode::OutOfMemory:
    // Repeated, as a request may be lost; not every time, as the I-frame takes a while.
    return failures_in_a_row_++ % 3 == 0;
  default:
    return false;
  }
}

void
ReceivedStream::follow(std::uint32_t frame_number)
{
  // A number that is not above the last one means that the sender was restarted.
  if (last_number_ && frame_number > *last_number_) {
    const std::size_t missing = frame_number - *last_number_ - 1;
    if (missing > unnumbered_)
      health_.frames_lost += missing - unnumbered_;
  }
  last_number_ = frame_number;
  unnumbered_ = 0;
  failures_in_a_row_ = 0;
  dropped_in_a_row_ = 0;
  health_.in_sync = true;
}

bool
ReceivedStream::countDropped()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++health_.frames_dropped;
  // A restarted sender has old numbers. If its first frame was lost, all others are
  // dropped until it sends an I-frame.
  const bool wants_i_frame = ++dropped_in_a_row_ % 3 == 0;
  health_.i_frame_requests += wants_i_frame ? 1 : 0;
  return wants_i_frame;
}

bool
ReceivedStream::countFailed(io::CompressionStatus status, bool is_decoded)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  ++health_.frames_failed;
  health_.last_failure = std::move(status);
  if (is_decoded) {
    follow(decoder_.statistics().frame_number);
    return false;
  }
  const io::CompressionCode code = health_.last_failure.code();
  if (!wasNoFrame(code)) {
    ++unnumbered_;
    health_.in_sync = false;
  }
  const bool wants_i_frame = wantsIFrame(code);
  health_.i_frame_requests += wants_i_frame ? 1 : 0;
  return wants_i_frame;
}

std::optional<LatestFrame>
ReceivedStream::latestVoxels(Time oldest,
                             Time newest,
                             io::VoxelFrame& voxels,
                             const std::optional<StampRange>& stamps,
                             std::size_t known) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool was_decoded_then =
      health_.last_decoded >= oldest && health_.last_decoded <= newest;
  const bool has_such_a_stamp =
      stamps && latest_stamp_ >= stamps->oldest && latest_stamp_ <= stamps->newest;
  if (!has_latest_ || (!was_decoded_then && !has_such_a_stamp))
    return std::nullopt;
  // After an exception the copy may have keys without intensities.
  if (known != health_.frames_decoded)
    callOrCleanUp([&] { voxels = latest_; }, [&] { voxels = io::VoxelFrame(); });
  return LatestFrame{latest_stamp_, health_.frames_decoded};
}

void
ReceivedStream::setMergedVoxels(std::size_t outside_grid,
                                std::size_t intensities_reduced)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  health_.voxels_outside_grid = outside_grid;
  health_.intensities_reduced = intensities_reduced;
}

StreamHealth
ReceivedStream::health(Time now) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  StreamHealth health = health_;
  health.rates = window_.rates(now);
  return health;
}

} // namespace nodes
} // namespace pcl_ext
