// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/version1_encoder.h"

#include "bytes/exceptions.h"
#include "codec/frame_limits.h"
#include "codec/supplement/coarse_voxels.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <numeric>

namespace pcl_ext::PCL_EXT_ABI::io {

Version1Encoder::Version1Encoder(Effort effort,
                                 bool has_p_frames,
                                 std::uint32_t first_frame_number)
: effort_(effort), has_p_frames_(has_p_frames)
{
  state_.frame_number = first_frame_number - 1;
}

bool
Version1Encoder::encodeTaken(const VoxelChanges& changes,
                             const std::optional<FrameStamp>& stamp,
                             std::vector<std::uint8_t>& bytes,
                             CodedFrameStatistics& statistics)
{
  beginHeader(false, stamp);
  if (!encodeChanges(changes.came))
    return false;
  header_.voxel_count = taken_.voxels;
  statistics.voxels = taken_.voxels;
  const std::size_t blocks = taken_.voxels > free_blocks ? taken_.blocks : 0;
  const std::uint32_t checksum = writeFrame(
      {header_.voxel_count, blocks, 0, 0}, {payload_.size(), 0, 0}, bytes, statistics);
  learn(checksum, changes.came.depth_model.has_value());
  return true;
}

void
Version1Encoder::encode(FrameKind kind,
                        const VoxelFrame& frame,
                        const std::optional<FrameStamp>& stamp,
                        std::vector<std::uint8_t>& bytes,
                        CodedFrameStatistics& statistics)
{
  beginHeader(kind == FrameKind::Intra, stamp);
  header_.grid = frame.grid;
  header_.intensity_scale = frame.intensity_scale;
  header_.layout = frame.layout;
  PayloadSizes sizes;
  if (kind == FrameKind::Changes && encodeChanges(frame))
    sizes.occupancy = payload_.size();
  else
    sizes = kind == FrameKind::Intra ? encodeIFrame(frame) : encodePFrame(frame);
  header_.voxel_count = frame.size();
  const VoxelFrame& coded = header_.content.hasVoxels() ? coarse_voxels_ : frame;
  const std::uint32_t checksum =
      writeFrame({header_.voxel_count,
                  coded.size() > free_blocks ? countBlocks(coded.keys) : 0,
                  header_.content.has_point_counts ? header_.point_count : 0,
                  fieldValuesOf(header_, header_.fields)},
                 sizes,
                 bytes,
                 statistics);
  if (has_p_frames_ && !header_.is_of_changes)
    state_.prepareChanges(header_, frame);
  learn(checksum, frame.depth_model.has_value());
}

/** \brief Learns a frame of voxels that was written. */
void
Version1Encoder::learn(std::uint32_t checksum, bool has_depth_model)
{
  state_.learn(header_, checksum);
  was_of_changes_ = header_.is_of_changes;
  had_depth_model_ = has_depth_model;
}

void
Version1Encoder::encode(bool is_i_frame,
                        const scan::ScanFrame& scan,
                        const std::optional<FrameStamp>& stamp,
                        unsigned int threads,
                        std::vector<std::uint8_t>& bytes,
                        CodedFrameStatistics& statistics)
{
  beginHeader(is_i_frame, stamp);
  Version1Header& header = header_;
  header.grid = scan.grid;
  header.intensity_scale = scan.intensity_scale;
  header.depth_model.reset();
  header.content = supplement::Content();
  header.content.has_scan = true;
  header.content.has_point_counts = true;
  header.content.colour_bits = scan.colour_bits;
  header.content.has_fields = !scan.fields.empty();
  header.fields.assign(scan.fields.begin(), scan.fields.end());
  header.viewpoint = {};
  const ScanPlacement placement = placementOf(scan);
  if (!is_i_frame && placement != placementOf(state_.scan))
    header.placement = placement;
  header.scan = scan;
  header.layout = scan.layout;
  header.point_count = scan.pixels.size();
  header.voxel_count = header.point_count;
  header.supplement_size = 0;
  payload_.clear();
  const std::size_t geometry =
      state_.scanCoder().encode(is_i_frame, scan, payload_, threads);
  const std::uint32_t checksum =
      writeFrame({header.voxel_count,
                  0,
                  std::max<std::uint64_t>(header.point_count, scan.pixelCount()),
                  fieldValuesOf(header, header.fields)},
                 {geometry, payload_.size() - geometry, 0},
                 bytes,
                 statistics);
  if (has_p_frames_)
    state_.prepareChanges(header_, coarse_voxels_); // none may follow
  state_.learn(header_, checksum);
  was_of_changes_ = false;
  had_depth_model_ = false;
}

/** \brief Sets what the header has of the stamp and the frames before. */
void
Version1Encoder::beginHeader(bool is_i_frame, const std::optional<FrameStamp>& stamp)
{
  Version1Header& header = header_;
  header.is_i_frame = is_i_frame;
  header.is_of_changes = false;
  header.has_depth_model = false;
  header.effort = effort_;
  header.frame_number = state_.frame_number + 1;
  header.stamp.reset();
  header.has_frame_id = stamp && (is_i_frame || stamp->frame_id != state_.frame_id);
  header.frame_id.clear();
  if (stamp)
    header.stamp = is_i_frame ? static_cast<std::int64_t>(stamp->stamp)
                              : state_.stampChange(stamp->stamp);
  if (header.has_frame_id)
    header.frame_id = stamp->frame_id;
  header.placement.reset();
  if (!is_i_frame)
    state_.complete(header);
}

/** \brief Encodes payload and supplement of an I-frame. */
PayloadSizes
Version1Encoder::encodeIFrame(const VoxelFrame& frame)
{
  setContent(frame);
  return encodeContent(frame, codedVoxels(frame));
}

/** \brief Encodes payload and supplement of a P-frame. */
PayloadSizes
Version1Encoder::encodePFrame(const VoxelFrame& frame)
{
  const VoxelFrame& coded = codedVoxels(frame);
  const std::size_t tracked = coder().match(work_, coded);
  if (!header_.content.hasVoxels())
    refinement_choice_.followHistory(tracked, coded.size());
  return encodeContent(frame, coded);
}

/** \brief Encodes a frame of changes, after hasFewChanges() or takeChanges().
 * \param[in] frame as ChangeCoder::encode takes it
 * \return false if the changes are not those of the last frame
 */
bool
Version1Encoder::encodeChanges(const VoxelFrame& frame)
{
  payload_.clear();
  header_.is_of_changes = state_.changes->encode(work_, frame, payload_);
  if (header_.is_of_changes)
    header_.content = supplement::Content();
  return header_.is_of_changes;
}

/** \brief Sets what an I-frame has besides its voxels. */
void
Version1Encoder::setContent(const VoxelFrame& frame)
{
  supplement::Content& content = header_.content;
  content.colour_bits = frame.colour_bits;
  content.has_point_counts = frame.has_point_counts;
  content.has_fields = !frame.fields.empty();
  content.has_scan = false;
  content.refinement_levels = refinement_choice_.levelsFor(frame);
  header_.fields.assign(frame.fields.begin(), frame.fields.end());
  header_.viewpoint = frame.viewpoint;
  header_.scan = scan::ScanLayout();
}

/** \brief What the coder of voxels codes: with a refinement the coarse voxels. */
const VoxelFrame&
Version1Encoder::codedVoxels(const VoxelFrame& frame)
{
  const supplement::Content& content = header_.content;
  if (!content.hasVoxels())
    return frame;
  coarse_voxels_.keys.clear();
  coarse_voxels_.grid = frame.grid;
  coarse_voxels_.grid.depth -= content.refinement_levels;
  coarse_voxels_.intensity_scale.bits = 0;
  supplement::coarseVoxelsOf(
      frame.keys, content.refinement_levels, coarse_voxels_.keys);
  return coarse_voxels_;
}

/** \brief Encodes payload and supplement of a frame.
 * \param[in] coded result of codedVoxels
 */
PayloadSizes
Version1Encoder::encodeContent(const VoxelFrame& frame, const VoxelFrame& coded)
{
  header_.coarse_voxel_count = coded.size();
  PayloadSizes sizes =
      header_.is_i_frame
          ? encodeIPayload(coded)
          : encodePayload(state_.depth_model ? coded : withoutModel(coded));
  const std::size_t supplement_begin = payload_.size();
  encodeSupplement(frame, coded, sizes);
  header_.supplement_size = payload_.size() - supplement_begin;
  return sizes;
}

/** \brief Appends the supplement to the payload, if the content has one. */
void
Version1Encoder::encodeSupplement(const VoxelFrame& frame,
                                  const VoxelFrame& coarse_voxels,
                                  PayloadSizes& sizes)
{
  header_.point_count = std::accumulate(
      frame.point_counts.begin(), frame.point_counts.end(), std::uint64_t{0});
  if (header_.content.refinement_levels > 0 && has_p_frames_)
    refinement_choice_.remember(frame.keys);
  if (!header_.content.hasSupplement() || frame.keys.empty())
    return;
  const supplement::Sizes added = state_.supplementCoder().encode({header_.content,
                                                                   coarse_voxels.keys,
                                                                   effort_,
                                                                   header_.is_i_frame,
                                                                   frame.size(),
                                                                   header_.point_count,
                                                                   header_.viewpoint},
                                                                  frame,
                                                                  payload_);
  sizes.occupancy += added.voxels;
  sizes.attributes += added.attributes;
}

/** \brief Encodes the payload of an I-frame. With a depth model it is encoded with and
 * without it, as the model does not help if most symbols are saturated. The smaller
 * variant is used until the next I-frame. */
PayloadSizes
Version1Encoder::encodeIPayload(const VoxelFrame& frame)
{
  if (!frame.depth_model)
    return encodePayload(frame);
  encodePayload(withoutModel(frame));
  const std::size_t size_without = payload_.size();
  const PayloadSizes sizes = encodePayload(frame);
  return frame.keys.empty() || payload_.size() <= size_without
             ? sizes
             : encodePayload(frame_without_model_);
}

/** \brief A frame without its depth model. */
const VoxelFrame&
Version1Encoder::withoutModel(const VoxelFrame& frame)
{
  if (!frame.depth_model)
    return frame;
  frame_without_model_.grid = frame.grid;
  frame_without_model_.intensity_scale = frame.intensity_scale;
  frame_without_model_.keys = frame.keys;
  frame_without_model_.intensities = frame.intensities;
  frame_without_model_.has_point_counts = frame.has_point_counts;
  frame_without_model_.point_counts = frame.point_counts;
  return frame_without_model_;
}

PayloadSizes
Version1Encoder::encodePayload(const VoxelFrame& frame)
{
  payload_.clear();
  const bool is_known = !header_.is_i_frame && frame.depth_model == state_.depth_model;
  header_.has_depth_model = frame.depth_model && !is_known;
  if (header_.has_depth_model)
    writeDepthModel(*frame.depth_model, payload_);
  header_.depth_model = frame.depth_model;
  return coder().encode(work_, frame, header_.is_i_frame, payload_);
}

/** \brief Gives an I-frame as many bytes as decoders of default limits demand for what it
 * has.
 * \return false if a P-frame has too few
 */
bool
Version1Encoder::pad(const FrameCounts& counts)
{
  Version1Header& header = header_;
  header.padding_size = 0;
  const std::uint64_t fewest = fewestBytes(counts);
  const std::uint64_t bytes =
      payload_.size() + (header.is_i_frame ? 0 : state_.bytes_since_i_frame);
  if (bytes >= fewest || !header.is_i_frame)
    return bytes >= fewest;
  header.padding_size = fewest - bytes;
  payload_.resize(static_cast<std::size_t>(fewest));
  return true;
}

/** \brief Appends the frame whose payload is encoded.
 * \param[in] counts of what is in it
 * \return its checksum
 */
std::uint32_t
Version1Encoder::writeFrame(const FrameCounts& counts,
                            const PayloadSizes& sizes,
                            std::vector<std::uint8_t>& bytes,
                            CodedFrameStatistics& statistics)
{
  Version1Header& header = header_;
  needs_replacement_ = !pad(counts);
  header.payload_size = payload_.size();
  const std::uint32_t checksum = writeVersion1Frame(
      header, payload_, header.is_i_frame ? 0 : state_.checksum, bytes);

  statistics.is_i_frame = header.is_i_frame;
  statistics.is_of_changes = header.is_of_changes;
  statistics.has_points = header.content.has_scan;
  statistics.frame_number = header.frame_number;
  statistics.bytes = bytes.size();
  statistics.header_bytes = bytes.size() - payload_.size();
  statistics.occupancy_bytes =
      sizes.occupancy + static_cast<std::size_t>(header.padding_size);
  statistics.attribute_bytes = sizes.attributes;
  statistics.intensity_bytes =
      payload_.size() - statistics.occupancy_bytes - sizes.attributes;
  return checksum;
}

std::size_t
Version1Encoder::endFrame(std::size_t elements)
{
  const std::size_t needed =
      elements + payload_.size() + state_.coders.trackedVoxels(effort_);
  work_.endFrame(needed, needed);
  return needed;
}

void
Version1Encoder::releaseMemory()
{
  payload_ = std::vector<std::uint8_t>();
  coarse_voxels_ = VoxelFrame();
  frame_without_model_ = VoxelFrame();
  refinement_choice_.releaseMemory();
  // Without memory for smaller copies the memory stays as it is.
  callOrElse([this] { state_.releaseMemory(); }, [] {});
}

void
Version1Encoder::forgetVoxels()
{
  state_.forgetVoxels();
}

} // namespace pcl_ext::PCL_EXT_ABI::io
