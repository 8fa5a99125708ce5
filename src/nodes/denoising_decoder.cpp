// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/denoising_decoder.h"

#include "bytes/exceptions.h"
#include "stream/version1_header.h"
#include "voxels/memory_rule.h"
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

  void
  releaseVoxels() noexcept
  {
    decoded = io::VoxelFrame();
    changes = io::VoxelChanges();
  }
};

ThreadMemory&
memoryOfThread()
{
  thread_local ThreadMemory memory;
  return memory;
}

/** \brief Voxels and points that a frame has memory for. */
std::size_t
capacityOf(const io::VoxelFrame& frame)
{
  return frame.keys.capacity() + frame.points.positions.capacity();
}

std::size_t
capacityOf(const ThreadMemory& memory)
{
  return capacityOf(memory.decoded) + capacityOf(memory.changes.gone) +
         capacityOf(memory.changes.came);
}

/** \brief True for a frame of which no voxels were made, as nothing was filtered. */
bool
hasPointsOnly(const io::VoxelFrame& frame)
{
  return frame.keys.empty() && !frame.points.indices.empty();
}

/** \brief Moves the voxels of a frame, and not much more memory than they need. */
void
moveVoxels(io::VoxelFrame& frame, io::VoxelFrame& kept)
{
  if (capacityOf(frame) <= 2 * (frame.keys.size() + frame.points.positions.size()))
    std::swap(kept, frame);
  else
    kept = frame;
}

} // namespace

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

DenoisingDecoder::DenoisingDecoder(float min_intensity, const io::DecoderLimits& limits)
: decoder_(limits)
, min_intensity_(min_intensity)
, frame_min_intensity_(min_intensity)
, applied_min_intensity_(min_intensity)
{}

void
DenoisingDecoder::setOutlierRemoval(
    const std::optional<VoxelOutlierRemovalSettings>& settings)
{
  const std::lock_guard<std::mutex> lock(settings_mutex_);
  if (settings == outlier_settings_)
    return;
  outlier_settings_ = settings;
  are_outlier_settings_new_ = true;
}

bool
DenoisingDecoder::begin(const std::vector<std::uint8_t>& bytes)
{
  makeOutlierRemoval();
  needed_ = 0;
  frame_min_intensity_ = min_intensity_;
  return is_plain_ && !outlier_removal_ &&
         frame_min_intensity_ == applied_min_intensity_ &&
         io::beginsFrameOfChanges(bytes.data(), bytes.size());
}

io::CompressionStatus
DenoisingDecoder::decode(const std::vector<std::uint8_t>& bytes, bool by_changes)
{
  ThreadMemory& memory = memoryOfThread();
  const std::size_t capacity = capacityOf(memory);
  const io::CompressionStatus status =
      by_changes
          ? decoder_.decode(bytes.data(), bytes.size(), memory.changes, memory.coding)
          : decoder_.decode(bytes.data(), bytes.size(), memory.decoded, memory.coding);
  // A failed frame may have taken more memory than any other needs.
  if (!status.ok() && capacityOf(memory) > capacity)
    memory.releaseVoxels();
  return status;
}

DenoisedFrame
DenoisingDecoder::denoise(io::VoxelFrame& voxels)
{
  io::VoxelFrame& decoded = memoryOfThread().decoded;
  needed_ = bytesOf(decoded);
  applied_min_intensity_ = frame_min_intensity_;
  DenoisedFrame denoised;
  denoised.outliers = removeOutliers(decoded);
  const std::size_t removed_below = removeVoxelsBelow(decoded, applied_min_intensity_);
  is_plain_ = !outlier_removal_;
  if (is_packed_)
    decoded.layout.reset();
  moveVoxels(decoded, voxels);
  denoised.voxels =
      hasPointsOnly(voxels) ? decoder_.statistics().voxels : voxels.size();
  denoised.all_voxels = denoised.voxels + removed_below + denoised.outliers.removed;
  denoised.resolution = voxels.grid.resolution;
  denoised.has_intensities = voxels.hasIntensities();
  denoised.points_outside_grid = voxels.points.outside_grid;
  return denoised;
}

DenoisedFrame
DenoisingDecoder::denoiseChanges(std::size_t voxels_before)
{
  io::VoxelChanges& changes = memoryOfThread().changes;
  needed_ = bytesOf(changes.gone) + bytesOf(changes.came);
  applied_min_intensity_ = frame_min_intensity_;
  removeVoxelsBelow(changes.gone, applied_min_intensity_);
  removeVoxelsBelow(changes.came, applied_min_intensity_);
  DenoisedFrame denoised;
  denoised.changes = &changes;
  denoised.voxels = (changes.is_from_nothing ? 0 : voxels_before) +
                    changes.came.size() - changes.gone.size();
  denoised.all_voxels = decoder_.statistics().voxels;
  denoised.resolution = changes.came.grid.resolution;
  denoised.has_intensities = changes.came.hasIntensities();
  return denoised;
}

void
DenoisingDecoder::end()
{
  ThreadMemory& memory = memoryOfThread();
  if (memory.rule.shouldRelease(needed_))
    memory.releaseVoxels();
}

void
DenoisingDecoder::discard() noexcept
{
  memoryOfThread().decoded = io::VoxelFrame();
  is_plain_ = false; // the voxels are not those of the decoder any more
}

bool
DenoisingDecoder::latestVoxels(io::VoxelFrame& voxels)
{
  if (!decoder_.latestVoxels(voxels))
    return false;
  removeVoxelsBelow(voxels, applied_min_intensity_);
  if (is_packed_)
    voxels.layout.reset();
  return true;
}

const io::VoxelFrame&
DenoisingDecoder::latestVoxels()
{
  io::VoxelFrame& voxels = memoryOfThread().decoded;
  if (!latestVoxels(voxels))
    voxels = io::VoxelFrame();
  return voxels;
}

void
DenoisingDecoder::dropHistory() noexcept
{
  outlier_removal_.reset();
  const std::lock_guard<std::mutex> lock(settings_mutex_);
  are_outlier_settings_new_ = outlier_settings_.has_value();
}

/** \brief Removes the outliers of a decoded frame, if a filter is set. A filter that
 * throws is replaced by a new one, as its history may be incomplete.
 * \return its status; Ok without a filter
 */
OutlierRemovalStatus
DenoisingDecoder::removeOutliers(io::VoxelFrame& frame)
{
  if (!outlier_removal_)
    return {};
  const auto replace_filter = [&] {
    outlier_removal_.reset();
    const std::lock_guard<std::mutex> lock(settings_mutex_);
    are_outlier_settings_new_ = true;
  };
  return callOrCleanUp([&] { return outlier_removal_->filter(frame); }, replace_filter);
}

void
DenoisingDecoder::makeOutlierRemoval()
{
  const std::lock_guard<std::mutex> lock(settings_mutex_);
  if (!are_outlier_settings_new_)
    return;
  outlier_removal_.reset();
  if (outlier_settings_)
    outlier_removal_.emplace(*outlier_settings_);
  // Not reached without memory for the filter: the next frame then creates it.
  are_outlier_settings_new_ = false;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
