// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_encoder.h>

#include "bytes/exceptions.h"
#include "codec/payload_coder.h"
#include "codec/published/frame.h"
#include "stream/version1_encoder.h"
#include "stream/version1_header.h"
#include "voxels/grid_fit.h"
#include "voxels/memory_rule.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <string>

namespace pcl_ext {
namespace io {

class FrameEncoder::Implementation {
public:
  Implementation(StreamFormat format,
                 unsigned int i_frame_rate,
                 Effort effort,
                 std::uint32_t first_frame_number)
  : format_(format)
  , effort_(effort == Effort::Fast || effort == Effort::Small ? effort
                                                              : Effort::Balanced)
  , i_frame_rate_(std::max(i_frame_rate, 1u))
  , version1_(effort_, i_frame_rate_ > 1)
  {
    version1_.startAt(first_frame_number);
  }

  bool
  isIFrameDue() const
  {
    return is_i_frame_requested_ || frames_since_i_frame_ >= i_frame_rate_ ||
           version1_.wantsIFrame();
  }

  bool
  takesImages() const
  {
    return version1_.takesImages(isIFrameDue());
  }

  void
  requestIFrame()
  {
    is_i_frame_requested_ = true;
  }

  void
  setEffort(Effort effort)
  {
    if (effort == effort_)
      return;
    effort_ = effort;
    version1_.setEffort(effort);
    requestIFrame();
  }

  void
  dropLastFrame()
  {
    if (format_ == StreamFormat::Version1)
      version1_.takeBack();
    else
      --published_.frame_number;
    requestIFrame();
  }

  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes)
  {
    const auto encode = [&] {
      bytes.clear();
      CompressionStatus status = check(frame, stamp);
      if (status.ok())
        encodeFrame(frame, stamp, bytes);
      return status;
    };
    // If memory runs out the state of the coders is undefined.
    const auto out_of_memory = [&] {
      bytes.clear();
      version1_.forgetHistory();
      requestIFrame();
      return outOfMemoryStatus<CompressionStatus>();
    };
    CompressionStatus status = callOrElse(encode, out_of_memory);
    if (status.ok())
      followStream(frame);
    return status;
  }

  const CodedFrameStatistics&
  statistics() const
  {
    return statistics_;
  }

private:
  CompressionStatus
  check(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp) const
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
      return {CompressionCode::InvalidInput,
              "in stream version 1 the grid must be within 2^20 voxels of its origin"};
    if (frame.size() > DecoderLimits::most_voxels)
      return {CompressionCode::InvalidInput,
              "the frame has " + std::to_string(frame.size()) +
                  " voxels; at most 2^28 are supported"};
    if (frame.size() > most_blocks && countBlocks(frame.keys) > most_blocks)
      return {CompressionCode::InvalidInput,
              "the frame has more than 2^26 blocks of 4 x 4 x 4 voxels"};
    if (stamp && stamp->frame_id.size() > max_frame_id_size)
      return {CompressionCode::InvalidInput,
              "frame_id has " + std::to_string(stamp->frame_id.size()) +
                  " bytes; at most " + std::to_string(max_frame_id_size) +
                  " are supported"};
    return {};
  }

  void
  encodeFrame(const VoxelFrame& frame,
              const std::optional<FrameStamp>& stamp,
              std::vector<std::uint8_t>& bytes)
  {
    CodedFrameStatistics statistics;
    bool is_of_changes = false;
    statistics.voxels = frame.size();
    statistics.is_i_frame = isIFrameDue();
    if (format_ == StreamFormat::Published) {
      // PCL's empty octree loses its depth, so that a frame without voxels and the
      // frame after it are I-frames, as in the authors' encoder.
      statistics.is_i_frame |=
          frame.grid != published_.grid || frame.keys.empty() || is_last_empty_;
      published::encodeFrame(
          frame, statistics.is_i_frame, published_, bytes, statistics);
    }
    else {
      const bool is_i_frame = isIFrameDue() || version1_.needsIFrame(frame, stamp);
      is_of_changes = !is_i_frame && version1_.hasFewChanges(frame, was_of_changes_);
      if (is_of_changes)
        version1_.encodeChanges(frame, stamp, bytes, statistics);
      else
        version1_.encode(frame,
                         is_i_frame ? nullptr : &version1_.match(frame),
                         stamp,
                         bytes,
                         statistics);
      // The history knows little of the frame. An I-frame takes hardly more bytes, and
      // frames of changes may follow it.
      const bool leaves_changes =
          was_of_changes_ && !version1_.mayBeFollowedByChanges();
      if (!statistics.is_i_frame && (leaves_changes || version1_.lacksBytes())) {
        encodeAgain(frame, stamp, bytes, statistics);
        is_of_changes = false;
      }
    }
    is_last_empty_ = frame.keys.empty();
    is_i_frame_requested_ = false;
    was_of_changes_ = is_of_changes;
    frames_since_i_frame_ = statistics.is_i_frame ? 1 : frames_since_i_frame_ + 1;
    statistics_ = statistics;
  }

  /** \brief Replaces a P-frame by an I-frame. */
  void
  encodeAgain(const VoxelFrame& frame,
              const std::optional<FrameStamp>& stamp,
              std::vector<std::uint8_t>& bytes,
              CodedFrameStatistics& statistics)
  {
    bytes.clear();
    version1_.takeBack();
    version1_.encode(frame, nullptr, stamp, bytes, statistics);
  }

  /** \brief Releases memory that recent frames did not need. */
  void
  followStream(const VoxelFrame& frame)
  {
    if (memory_rule_.shouldRelease(version1_.endFrame(frame)) &&
        format_ == StreamFormat::Version1)
      version1_.releaseMemory();
  }

  StreamFormat format_;
  Effort effort_;
  std::uint32_t i_frame_rate_;
  std::uint32_t frames_since_i_frame_ = 0;
  bool is_i_frame_requested_ = true;
  bool is_last_empty_ = false;
  bool was_of_changes_ = false; // the last frame
  CodedFrameStatistics statistics_;

  published::History published_;

  Version1Encoder version1_;
  MemoryRule memory_rule_;
};

FrameEncoder::FrameEncoder(StreamFormat format,
                           unsigned int i_frame_rate,
                           Effort effort,
                           std::uint32_t first_frame_number)
: implementation_(std::make_unique<Implementation>(
      format, i_frame_rate, effort, first_frame_number))
{}

FrameEncoder::~FrameEncoder() = default;
FrameEncoder::FrameEncoder(FrameEncoder&&) noexcept = default;
FrameEncoder&
FrameEncoder::operator=(FrameEncoder&&) noexcept = default;

bool
FrameEncoder::isIFrameDue() const
{
  return implementation_->isIFrameDue();
}

bool
FrameEncoder::takesImages() const
{
  return implementation_->takesImages();
}

void
FrameEncoder::requestIFrame()
{
  implementation_->requestIFrame();
}

void
FrameEncoder::setEffort(Effort effort)
{
  implementation_->setEffort(effort);
}

void
FrameEncoder::dropLastFrame()
{
  implementation_->dropLastFrame();
}

CompressionStatus
FrameEncoder::encode(const VoxelFrame& frame,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(frame, stamp, bytes);
}

const CodedFrameStatistics&
FrameEncoder::statistics() const
{
  return implementation_->statistics();
}

} // namespace io
} // namespace pcl_ext
