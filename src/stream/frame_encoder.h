// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include "codec/published/frame.h"
#include "stream/frame_kind.h"
#include "stream/version1_encoder.h"
#include "voxels/memory_rule.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Encodes the frames of one stream, voxels or points. */
class PCL_EXT_CODEC_EXPORT FrameEncoder {
public:
  /** \brief An encoder at the start of a stream.
   * \param[in] format bitstream to write
   * \param[in] i_frame_rate frames from one I-frame to the next; 0 counts as 1
   * \param[in] effort time against size; Version1 only
   * \param[in] first_frame_number see StreamSettings
   * \param[in] i_frame_every seconds; see StreamSettings
   */
  FrameEncoder(StreamFormat format,
               unsigned int i_frame_rate,
               Effort effort = Effort::Fast,
               std::uint32_t first_frame_number = 1,
               double i_frame_every = 0.0);

  /** \brief Sets the time of the next frame, before it is asked whether an I-frame is
   * due; none: the frame is counted only. */
  void
  setTime(const std::optional<std::chrono::nanoseconds>& time);

  /** \brief True if the next frame will be an I-frame for any content. */
  bool
  isIFrameDue() const;

  /** \brief Whether a scan has to be an I-frame as one is due, or as it differs from what
   * a P-frame may have. */
  bool
  mustBeIFrame(const scan::ScanFrame& scan,
               const std::optional<FrameStamp>& stamp) const;

  /** \brief Makes the next frame an I-frame. */
  void
  requestIFrame();

  /** \brief Sets the effort; the next frame is an I-frame if it is another one. */
  void
  setEffort(Effort effort);

  /** \brief Takes the last frame out of the stream, as it will not be sent: the next one
   * has its number, and is an I-frame. */
  void
  dropLastFrame();

  /** \brief Encodes the next frame of the stream. A frame may be empty and has at most
   * 2^28 voxels, in 2^26 blocks of 4 x 4 x 4.
   * \param[in] frame the voxels
   * \param[in] stamp stamp and frame_id of the cloud, to be coded if set; Version1 only
   * \param[out] bytes the encoded frame; empty unless the status is Ok
   * \return Ok; InvalidInput, which does not affect the stream; OutOfMemory, after
   * which the next frame is an I-frame
   */
  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes);

  /** \brief Encodes the next frame of the stream, known by how it differs from the last
   * one, if it is coded by that; Version1 only.
   * \param[in] changes of the frame that was encoded last
   * \return nothing if the frame is to be encoded by all of its voxels; else as encode()
   */
  std::optional<CompressionStatus>
  encode(const VoxelChanges& changes,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes);

  /** \brief Encodes the points of the next frame; Version1 only.
   * \param[in] scan of a consistent layout, with ascending pixels
   * \param[in] threads as in EncoderSettings
   */
  CompressionStatus
  encode(const scan::ScanFrame& scan,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes,
         unsigned int threads = 1);

  /** \brief Bytes of the payloads since the last I-frame, with its own; see
   * frameLimits(). */
  std::uint64_t
  bytesSinceIFrame() const
  {
    return bytes_since_i_frame_;
  }

  /** \brief Figures of the last frame. */
  const CodedFrameStatistics&
  statistics() const
  {
    return statistics_;
  }

private:
  CompressionStatus
  check(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp) const;

  void
  encodeFrame(const VoxelFrame& frame,
              const std::optional<FrameStamp>& stamp,
              std::vector<std::uint8_t>& bytes);

  template <typename EncodeT>
  CompressionStatus
  encodeSafely(std::vector<std::uint8_t>& bytes, const EncodeT& encode);

  void
  releaseSpareMemory(const CompressionStatus& status, std::size_t elements);

  void
  endFrame(const CodedFrameStatistics& statistics, bool is_empty);

  void
  encodePublished(const VoxelFrame& frame,
                  std::vector<std::uint8_t>& bytes,
                  CodedFrameStatistics& statistics);

  IFrameReasons
  reasonsOfStream() const;

  bool
  isLate() const;

  FrameKind
  kindOf(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp);

  StreamFormat format_;
  std::uint32_t i_frame_rate_;
  double i_frame_every_; // nanoseconds; 0: by count alone
  std::uint32_t frames_since_i_frame_ = 0;
  std::uint64_t bytes_since_i_frame_ = 0;
  bool is_i_frame_requested_ = true;
  std::optional<std::chrono::nanoseconds> time_; // of the next frame, or the last
  // Of the last I-frame, or of the first frame after it that had one.
  std::optional<std::chrono::nanoseconds> i_frame_time_;
  bool is_last_empty_ = false;
  CodedFrameStatistics statistics_;
  published::History published_;
  Version1Encoder version1_;
  MemoryRule memory_rule_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
