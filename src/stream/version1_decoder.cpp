// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/version1_decoder.h"

#include "bytes/checksum.h"
#include "bytes/exceptions.h"
#include "codec/frame_failures.h"
#include "codec/scan/scan_points.h"
#include "stream/frame_preparation.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Decodes the frame that was read.
 * \param[out] frame its voxels, or if there is a `gone` those of a frame of changes that
 * came
 * \param[out] gone of a frame of changes; null for all voxels
 */
CompressionStatus
Version1Decoder::decode(CodingWorkspace& work,
                        VoxelFrame& frame,
                        VoxelFrame* gone,
                        CodedFrameStatistics& statistics)
{
  memory_taken_ = checked_bytes_.size() + static_cast<std::size_t>(header_.voxel_count);
  if (header_.content.has_fields)
    memory_taken_ += static_cast<std::size_t>(std::min<std::uint64_t>(
        frame_limits_.max_field_values,
        fieldValuesOf(header_, header_.is_i_frame ? header_.fields : state_.fields)));
  if (header_.is_of_changes && state_.changes) // those of the last frame may all change
    memory_taken_ += state_.changes->blockCount();
  PayloadSizes sizes;
  prepareStamp();
  // If memory runs out the state of the coder is undefined.
  const auto reset = [this] {
    forget();
    // Without a history an old I-frame cannot break the references of later frames.
    order_ = FrameOrder(true);
  };
  if (CompressionStatus status =
          callOrCleanUp([&] { return decodePayload(work, frame, gone, sizes); }, reset);
      !status.ok())
    return status;
  const auto payload_size = static_cast<std::size_t>(header_.payload_size);
  statistics.frame_number = header_.frame_number;
  statistics.is_i_frame = header_.is_i_frame;
  statistics.voxels = static_cast<std::size_t>(header_.voxel_count);
  statistics.is_of_changes = header_.is_of_changes;
  statistics.has_points = header_.content.has_scan;
  statistics.occupancy_bytes = sizes.occupancy;
  statistics.attribute_bytes = sizes.attributes;
  statistics.intensity_bytes = payload_size - sizes.occupancy - sizes.attributes;
  statistics.header_bytes = header_bytes_;
  learn();
  return {};
}

CompressionStatus
Version1Decoder::read(ByteSource& source)
{
  memory_taken_ = 0;
  if (CompressionStatus status = readVersion1Header(source,
                                                    limits_,
                                                    header_,
                                                    checksum_,
                                                    checked_bytes_,
                                                    state_.bytes_since_i_frame);
      !status.ok())
    return status;
  if (CompressionStatus status = limitFrame(); !status.ok())
    return status;
  header_size_ = checked_bytes_.size();
  header_bytes_ = version1_magic_size + source.consumed();
  const auto payload_size = static_cast<std::size_t>(header_.payload_size);
  // Without its reference the checksum of a P-frame cannot be verified: its size is not
  // trusted, and the payload is skipped.
  if (CompressionStatus status =
          header_.is_i_frame ? CompressionStatus() : checkOrder();
      !status.ok()) {
    source.skip(payload_size);
    return source.failure() == ByteSource::Failure::None
               ? status
               : failedRead(source, "a payload");
  }
  source.read(payload_size, checked_bytes_);
  memory_taken_ = checked_bytes_.size();
  if (source.failure() != ByteSource::Failure::None)
    return failedRead(source, "a payload");
  if (CompressionStatus status = verifyChecksum(); !status.ok())
    return status;
  return header_.is_i_frame ? checkOrder() : CompressionStatus();
}

/** \brief The memory that the voxels of a frame take, without their blocks. */
std::uint64_t
Version1Decoder::bytesOfVoxels() const
{
  // Half of it is for the history. A pixel without a point takes much less.
  const scan::ScanLayout& scan = header_.is_i_frame ? header_.scan : state_.scan;
  const std::uint64_t of_pixels =
      header_.content.has_scan ? scan.pixelCount() / 4 : std::uint64_t{0};
  return (header_.is_i_frame ? bytes_of_voxel / 2 : bytes_of_voxel) *
         std::max(header_.voxel_count, of_pixels);
}

/** \brief Sets the limits of a frame by its bytes and by the memory that there is. */
CompressionStatus
Version1Decoder::limitFrame()
{
  frame_limits_ = limitsOf(header_, limits_, state_.bytes_since_i_frame);
  blocks_by_memory_ = most_blocks;
  if (!limits_.budget)
    return {};
  const std::uint64_t limit = limits_.budget->limit();
  const std::uint64_t least = bytesOfVoxels();
  if (least > limit)
    return tooMuchMemory(least, limits_.budget->limit());
  blocks_by_memory_ = static_cast<std::size_t>((limit - least) / bytes_of_block);
  frame_limits_.max_blocks = std::min(frame_limits_.max_blocks, blocks_by_memory_);
  return {};
}

/** \brief A frame with more blocks than its limit. */
CompressionStatus
Version1Decoder::tooManyBlocks() const
{
  if (limits_.budget && frame_limits_.max_blocks == blocks_by_memory_)
    return tooMuchMemory(bytesOfVoxels() +
                             (std::uint64_t{blocks_by_memory_} + 1) * bytes_of_block,
                         limits_.budget->limit());
  return {CompressionCode::LimitExceeded,
          "the blocks of " + std::to_string(header_.voxel_count) +
              " voxels exceed the limit of " +
              std::to_string(frame_limits_.max_blocks)};
}

CompressionStatus
Version1Decoder::verifyChecksum() const
{
  if (chainedChecksum(header_.is_i_frame ? 0 : state_.checksum,
                      checked_bytes_.data(),
                      checked_bytes_.size()) == checksum_)
    return {};
  return corruptFrame(
      "checksum mismatch of frame " + std::to_string(header_.frame_number) +
      (header_.is_i_frame ? ": it is damaged"
                          : ": it is damaged, or belongs to another stream"));
}

/** \brief Checks that a frame is not old, and that its reference was decoded. */
CompressionStatus
Version1Decoder::checkOrder()
{
  if (order_.isOld(header_.frame_number, checksum_, header_.is_i_frame))
    return oldFrame(header_.frame_number);
  if (header_.is_i_frame ||
      (has_history_ && header_.frame_number - 1 == state_.frame_number))
    return {};
  if (is_dropped_)
    return droppedReference(header_.frame_number, limits_.budget->limit());
  return missingReference(header_.frame_number,
                          has_history_ ? std::optional(state_.frame_number)
                                       : std::nullopt);
}

/** \brief Decodes the payload without changing the history. */
CompressionStatus
Version1Decoder::decodePayload(CodingWorkspace& work,
                               VoxelFrame& frame,
                               VoxelFrame* gone,
                               PayloadSizes& sizes)
{
  const std::uint8_t* payload = checked_bytes_.data() + header_size_;
  const std::uint8_t* const padding_end = payload + header_.payload_size;
  const std::uint8_t* const end = padding_end - header_.padding_size;
  if (std::any_of(end, padding_end, [](std::uint8_t byte) { return byte != 0; }))
    return corruptFrame("padding of other bytes than 0");
  if (CompressionStatus status = prepareFrame(
          {state_, frame_limits_, header_, coarse_voxels_}, payload, frame);
      !status.ok())
    return status;
  if (header_.is_of_changes)
    return decodeFrameOfChanges(work, payload, end, frame, gone, sizes);
  if (header_.content.has_scan)
    return decodeScan(payload, end, frame, sizes);
  const std::uint8_t* const supplement = end - header_.supplement_size;
  if (CompressionStatus status = decodeVoxels(work, payload, supplement, frame, sizes);
      !status.ok())
    return status;
  if (!decodeSupplement(supplement, end, frame, sizes)) {
    state_.coders.of(header_.effort).discard();
    return corruptFrame("the supplement does not decode to " +
                        std::to_string(header_.voxel_count) + " voxels");
  }
  if (!isConsistent(frame) || hasOtherPoints(frame)) {
    state_.coders.of(header_.effort).discard();
    return corruptFrame("invalid voxels");
  }
  sizes.occupancy += static_cast<std::size_t>(header_.padding_size);
  state_.prepareChanges(header_, frame);
  return {};
}

/** \brief Decodes a frame of changes. */
CompressionStatus
Version1Decoder::decodeFrameOfChanges(CodingWorkspace& work,
                                      const std::uint8_t* begin,
                                      const std::uint8_t* end,
                                      VoxelFrame& frame,
                                      VoxelFrame* gone,
                                      PayloadSizes& sizes)
{
  if (!state_.mayBeFollowedByChanges())
    return corruptFrame("a frame of changes to one that it cannot refer to");
  if (state_.changes->blockCount() > maxTracked(frame_limits_.max_voxels))
    return {CompressionCode::LimitExceeded, "the history exceeds the limit on voxels"};
  sizes = {static_cast<std::size_t>(header_.payload_size), 0, 0};
  const bool is_whole =
      state_.changes->decode(work,
                             {begin,
                              end,
                              static_cast<std::size_t>(header_.voxel_count),
                              false,
                              frame_limits_.max_blocks},
                             frame);
  if (is_whole && gone != nullptr && listChanges(*gone, frame))
    return {};
  if (is_whole && gone == nullptr) {
    state_.changes->listVoxels(work, frame);
    if (isConsistent(frame))
      return {};
  }
  return corruptFrame("the payload does not decode to " +
                      std::to_string(header_.voxel_count) + " voxels");
}

/** \brief Lists the changes of a frame of changes.
 * \param[in,out] came grid, scale and the like are given
 * \return false if the frame is invalid
 */
bool
Version1Decoder::listChanges(VoxelFrame& gone, VoxelFrame& came) const
{
  gone.grid = came.grid;
  gone.intensity_scale = came.intensity_scale;
  gone.depth_model = came.depth_model;
  gone.colour_bits = 0;
  gone.has_point_counts = false;
  gone.fields.clear();
  came.viewpoint = {};
  gone.viewpoint = {};
  state_.changes->listChanges(gone, came);
  // That makes the whole frame consistent: its other voxels are of the last frame, which
  // was, and has the same grid and scale; keys ascend with the blocks and their cells;
  // and the coder has counted voxels and symbols.
  return isConsistent(came);
}

/** \brief Decodes the points of a scan. */
CompressionStatus
Version1Decoder::decodeScan(const std::uint8_t* begin,
                            const std::uint8_t* end,
                            VoxelFrame& frame,
                            PayloadSizes& sizes)
{
  static_cast<scan::ScanLayout&>(scan_) = header_.scan;
  scan_.grid = header_.grid;
  scan_.intensity_scale = header_.intensity_scale;
  scan_.colour_bits = header_.content.colour_bits;
  scan_.fields.swap(frame.fields); // as prepareFields() has set them
  if (!state_.scanCoder().decode(
          header_.is_i_frame, begin, end, header_.point_count, scan_))
    return corruptFrame("the payload does not decode to " +
                        std::to_string(header_.point_count) + " points");
  sizes = {static_cast<std::size_t>(header_.payload_size), 0, 0};
  scan::movePoints(scan_, frame);
  state_.prepareChanges(header_, frame); // none may follow
  return {};
}

/** \brief Decodes the voxels, or the coarse voxels of those that are in the
 * supplement. */
CompressionStatus
Version1Decoder::decodeVoxels(CodingWorkspace& work,
                              const std::uint8_t* begin,
                              const std::uint8_t* end,
                              VoxelFrame& frame,
                              PayloadSizes& sizes)
{
  PayloadCoder& coder = state_.coders.of(header_.effort);
  const bool supplement_has_voxels = header_.content.hasVoxels();
  const auto count = static_cast<std::size_t>(
      supplement_has_voxels ? header_.coarse_voxel_count : header_.voxel_count);
  if (!header_.is_i_frame &&
      (coder.trackedVoxels() > maxTracked(frame_limits_.max_voxels) ||
       coder.trackedBlocks() > maxTracked(frame_limits_.max_blocks) ||
       !fitsHistory(coder.trackedBlocks(), count)))
    return {CompressionCode::LimitExceeded, "the history exceeds the limit on voxels"};
  if (coder.decode(work,
                   {begin, end, count, header_.is_i_frame, frame_limits_.max_blocks},
                   supplement_has_voxels ? coarse_voxels_ : frame,
                   sizes))
    return {};
  if (sizes.has_too_many_blocks)
    return tooManyBlocks();
  return corruptFrame("the payload does not decode to " + std::to_string(count) +
                      (supplement_has_voxels ? " coarse voxels" : " voxels"));
}

/** \brief Whether the numbers of points do not add up to that of the header. */
bool
Version1Decoder::hasOtherPoints(const VoxelFrame& frame) const
{
  return std::accumulate(frame.point_counts.begin(),
                         frame.point_counts.end(),
                         std::uint64_t{0}) != header_.point_count;
}

bool
Version1Decoder::decodeSupplement(const std::uint8_t* begin,
                                  const std::uint8_t* end,
                                  VoxelFrame& frame,
                                  PayloadSizes& sizes)
{
  if (!header_.content.hasSupplement())
    return true;
  if (header_.voxel_count == 0) {
    frame.clearVoxels();
    return begin == end;
  }
  supplement::Sizes supplement_sizes;
  const bool is_whole =
      state_.supplementCoder().decode({header_.content,
                                       coarse_voxels_.keys,
                                       header_.effort,
                                       header_.is_i_frame,
                                       static_cast<std::size_t>(header_.voxel_count),
                                       header_.point_count,
                                       header_.viewpoint},
                                      begin,
                                      end,
                                      frame,
                                      supplement_sizes);
  sizes.occupancy += supplement_sizes.voxels;
  sizes.attributes += supplement_sizes.attributes;
  return is_whole;
}

/** \brief Computes the stamp of the current frame; before learn(), as it may
 * allocate. */
void
Version1Decoder::prepareStamp()
{
  if (!header_.stamp) {
    next_stamp_.reset();
    return;
  }
  if (!next_stamp_)
    next_stamp_.emplace();
  next_stamp_->stamp = state_.stampOf(header_);
  next_stamp_->frame_id =
      header_.has_frame_id || header_.is_i_frame ? header_.frame_id : state_.frame_id;
}

/** \brief Learns the frame that was decoded. */
void
Version1Decoder::learn() noexcept
{
  if (header_.is_of_changes) {
    state_.changes->learn();
  }
  else if (header_.content.has_scan) {
    state_.scans->learn();
    state_.coders.clear();
  }
  else {
    state_.coders.of(header_.effort).learn();
    state_.coders.keepOnly(header_.effort);
  }
  const bool is_empty = header_.voxel_count == 0;
  if (header_.content.hasSupplement() && !is_empty)
    state_.supplement->learn();
  state_.learn(header_, checksum_);
  stamp_.swap(next_stamp_);
  has_history_ = true;
  is_dropped_ = false;
  order_.decoded(state_.frame_number, checksum_, !is_empty || stamp_);
}

void
Version1Decoder::listLastVoxels(VoxelFrame& frame) const
{
  frame.clearVoxels();
  frame.grid = state_.grid;
  frame.intensity_scale = state_.intensity_scale;
  frame.depth_model = state_.depth_model;
  // Frames of changes have none, nor does what they refer to.
  frame.colour_bits = 0;
  frame.has_point_counts = false;
  frame.fields.clear();
  frame.viewpoint = {};
  frame.layout = state_.layout;
  state_.changes->listLastVoxels(frame);
}

void
Version1Decoder::forget() noexcept
{
  state_.forgetVoxels();
  has_history_ = false;
}

void
Version1Decoder::drop() noexcept
{
  is_dropped_ |= has_history_;
  forget();
  checked_bytes_ = std::vector<std::uint8_t>();
  coarse_voxels_ = VoxelFrame();
}

void
Version1Decoder::releaseMemory()
{
  checked_bytes_ = std::vector<std::uint8_t>();
  if (!has_history_) {
    state_.coders.clear();
    return;
  }
  state_.coders.keepOnly(state_.effort);
  state_.releaseMemory();
  coarse_voxels_ = VoxelFrame();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
