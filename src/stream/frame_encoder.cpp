// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/frame_encoder.h"

#include "bytes/exceptions.h"
#include "stream/version1_header.h"
#include "voxels/grid_fit.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

CompressionStatus
checkHeader(const std::optional<FrameStamp>& stamp, const MessageLayout* layout)
{
  if (layout != nullptr && !isLayout(*layout))
    return {CompressionCode::InvalidInput,
            "the layout of messages has a field that is not within a point, or is too "
            "large"};
  if (stamp && stamp->frame_id.size() > max_frame_id_size)
    return {CompressionCode::InvalidInput,
            "frame_id has " + std::to_string(stamp->frame_id.size()) +
                " bytes; at most " + std::to_string(max_frame_id_size) +
                " are supported"};
  return {};
}

} // namespace

FrameEncoder::FrameEncoder(StreamFormat format,
                           unsigned int i_frame_rate,
                           Effort effort,
                           std::uint32_t first_frame_number,
                           double i_frame_every)
: format_(format)
, i_frame_rate_(std::max(i_frame_rate, 1u))
, i_frame_every_(std::round(1e9 * i_frame_every))
, version1_(effort == Effort::Fast || effort == Effort::Small ? effort
                                                              : Effort::Balanced,
            i_frame_rate_ > 1,
            first_frame_number)
{}

/** \brief Why the next frame has to be an I-frame, whatever it is. */
IFrameReasons
FrameEncoder::reasonsOfStream() const
{
  IFrameReasons reasons;
  reasons.is_requested = is_i_frame_requested_;
  reasons.is_scheduled = frames_since_i_frame_ >= i_frame_rate_;
  reasons.is_late = isLate();
  return reasons;
}

/** \brief Whether the next frame is so far from the last I-frame in time that it has to
 * be one. */
bool
FrameEncoder::isLate() const
{
  if (i_frame_every_ == 0.0 || !time_ || !i_frame_time_)
    return false;
  const auto [first, last] = std::minmax(*time_, *i_frame_time_);
  // Unsigned, as it may be outside the range of the clock.
  const std::uint64_t apart = static_cast<std::uint64_t>(last.count()) -
                              static_cast<std::uint64_t>(first.count());
  return static_cast<double>(apart) >= i_frame_every_;
}

void
FrameEncoder::setTime(const std::optional<std::chrono::nanoseconds>& time)
{
  time_ = time;
  if (!i_frame_time_)
    i_frame_time_ = time;
}

bool
FrameEncoder::isIFrameDue() const
{
  return reasonsOfStream().any();
}

bool
FrameEncoder::mustBeIFrame(const scan::ScanFrame& scan,
                           const std::optional<FrameStamp>& stamp) const
{
  IFrameReasons reasons = reasonsOfStream();
  if (!reasons.any() && checkHeader(stamp, scan.layout.get()).ok())
    version1_.addReasons(scan, stamp, reasons);
  return reasons.any();
}

void
FrameEncoder::requestIFrame()
{
  is_i_frame_requested_ = true;
}

void
FrameEncoder::setEffort(Effort effort)
{
  if (effort == version1_.effort())
    return;
  version1_.setEffort(effort);
  requestIFrame();
}

void
FrameEncoder::dropLastFrame()
{
  if (format_ == StreamFormat::Version1)
    version1_.takeBack();
  else
    --published_.frame_number;
  requestIFrame();
}

CompressionStatus
FrameEncoder::encode(const VoxelFrame& frame,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes)
{
  CompressionStatus status = encodeSafely(bytes, [&] {
    CompressionStatus checked = check(frame, stamp);
    if (checked.ok())
      encodeFrame(frame, stamp, bytes);
    return checked;
  });
  releaseSpareMemory(status, frame.size() + frame.fieldValueCount());
  return status;
}

std::optional<CompressionStatus>
FrameEncoder::encode(const VoxelChanges& changes,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes)
{
  const auto is_plain = [](const VoxelFrame& frame) {
    return isConsistent(frame) && !frame.has_point_counts && frame.fields.empty();
  };
  if (format_ != StreamFormat::Version1 || isIFrameDue() || changes.is_from_nothing ||
      !changes.areOfOneGrid() || !is_plain(changes.gone) || !is_plain(changes.came) ||
      !checkHeader(stamp, changes.came.layout.get()).ok())
    return std::nullopt;
  bool is_encoded = false;
  CodedFrameStatistics statistics;
  CompressionStatus status = encodeSafely(bytes, [&] {
    is_encoded = version1_.takeChanges(changes, stamp) &&
                 version1_.encodeTaken(changes, stamp, bytes, statistics);
    if (is_encoded && version1_.needsReplacement()) {
      bytes.clear();
      dropLastFrame();
      is_encoded = false;
    }
    if (is_encoded)
      endFrame(statistics, statistics.voxels == 0);
    return CompressionStatus();
  });
  if (status.ok() && !is_encoded)
    return std::nullopt;
  releaseSpareMemory(status, statistics.voxels);
  return status;
}

CompressionStatus
FrameEncoder::encode(const scan::ScanFrame& scan,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes,
                     unsigned int threads)
{
  CompressionStatus status = encodeSafely(bytes, [&] {
    CompressionStatus checked = checkHeader(stamp, scan.layout.get());
    if (!checked.ok())
      return checked;
    CodedFrameStatistics statistics;
    statistics.voxels = scan.pixels.size();
    version1_.encode(
        mustBeIFrame(scan, stamp), scan, stamp, threads, bytes, statistics);
    if (version1_.needsReplacement()) {
      bytes.clear();
      version1_.takeBack();
      version1_.encode(true, scan, stamp, threads, bytes, statistics);
    }
    endFrame(statistics, scan.pixels.empty());
    return checked;
  });
  releaseSpareMemory(status, scan.pixelCount());
  return status;
}

/** \brief Encodes a frame; without memory the next one is an I-frame. */
template <typename EncodeT>
CompressionStatus
FrameEncoder::encodeSafely(std::vector<std::uint8_t>& bytes, const EncodeT& encode)
{
  bytes.clear();
  // If memory runs out the state of the coders is undefined.
  return callOrElse(encode, [&] {
    bytes.clear();
    version1_.forgetVoxels();
    requestIFrame();
    return outOfMemoryStatus<CompressionStatus>();
  });
}

/** \brief Releases memory that recent frames did not need.
 * \param[in] elements of the frame that was encoded, if the status is Ok
 */
void
FrameEncoder::releaseSpareMemory(const CompressionStatus& status, std::size_t elements)
{
  if (status.ok() && memory_rule_.shouldRelease(version1_.endFrame(elements)) &&
      format_ == StreamFormat::Version1)
    version1_.releaseMemory();
}

CompressionStatus
FrameEncoder::check(const VoxelFrame& frame,
                    const std::optional<FrameStamp>& stamp) const
{
  if (!isConsistent(frame))
    return {CompressionCode::InvalidInput,
            "the voxel frame is inconsistent: keys must ascend within the grid, with "
            "one intensity symbol within the scale for each, and so for colours and "
            "numbers of points where it has them"};
  if (format_ == StreamFormat::Published) {
    if (stamp)
      return {CompressionCode::InvalidInput,
              "the published layout has no fields for stamp and frame_id"};
    if (frame.intensity_scale != IntensityScale())
      return {CompressionCode::InvalidInput,
              "in the published layout intensities must be 0 to 255 in steps of 1"};
    if (frame.colour_bits > 0 || frame.has_point_counts || !frame.fields.empty())
      return {CompressionCode::InvalidInput,
              "the published layout has no room for colours, numbers of points and "
              "further fields"};
  }
  else if (!isOrigin(frame.grid.origin) || leavesLattice(frame.grid))
    return {
        CompressionCode::InvalidInput,
        SettingText{"the voxels are not within 2^20 voxels of their grid's origin: "
                    "set {origin} amid the points, or leave out those too far away"}};
  if (frame.size() > DecoderLimits::most_voxels)
    return {CompressionCode::InvalidInput,
            "the frame has " + std::to_string(frame.size()) +
                " voxels; at most 2^28 are supported"};
  if (frame.size() > most_blocks && countBlocks(frame.keys) > most_blocks)
    return {CompressionCode::InvalidInput,
            "the frame has more than 2^26 blocks of 4 x 4 x 4 voxels"};
  return checkHeader(stamp, frame.layout.get());
}

void
FrameEncoder::encodeFrame(const VoxelFrame& frame,
                          const std::optional<FrameStamp>& stamp,
                          std::vector<std::uint8_t>& bytes)
{
  CodedFrameStatistics statistics;
  statistics.voxels = frame.size();
  if (format_ == StreamFormat::Published)
    encodePublished(frame, bytes, statistics);
  else
    version1_.encode(kindOf(frame, stamp), frame, stamp, bytes, statistics);
  if (version1_.needsReplacement()) {
    bytes.clear();
    version1_.takeBack();
    version1_.encode(FrameKind::Intra, frame, stamp, bytes, statistics);
  }
  endFrame(statistics, frame.keys.empty());
}

/** \brief Follows a frame that was encoded. */
void
FrameEncoder::endFrame(const CodedFrameStatistics& statistics, bool is_empty)
{
  is_last_empty_ = is_empty;
  is_i_frame_requested_ = false;
  if (statistics.is_i_frame) {
    frames_since_i_frame_ = 0;
    bytes_since_i_frame_ = 0;
    i_frame_time_ = time_;
  }
  ++frames_since_i_frame_;
  bytes_since_i_frame_ += statistics.bytes - statistics.header_bytes;
  statistics_ = statistics;
}

void
FrameEncoder::encodePublished(const VoxelFrame& frame,
                              std::vector<std::uint8_t>& bytes,
                              CodedFrameStatistics& statistics)
{
  // PCL's empty octree loses its depth, so that a frame without voxels and the frame
  // after it are I-frames, as in the authors' encoder.
  statistics.is_i_frame = isIFrameDue() || frame.grid != published_.grid ||
                          frame.keys.empty() || is_last_empty_;
  published::encodeFrame(frame, statistics.is_i_frame, published_, bytes, statistics);
}

FrameKind
FrameEncoder::kindOf(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp)
{
  IFrameReasons reasons = reasonsOfStream();
  if (!reasons.any())
    version1_.addReasons(frame, stamp, reasons);
  if (reasons.any())
    return FrameKind::Intra;
  return version1_.hasFewChanges(frame) ? FrameKind::Changes : FrameKind::Predicted;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
