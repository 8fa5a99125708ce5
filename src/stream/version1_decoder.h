// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "codec/frame_order.h"
#include "codec/payload_coder.h"
#include "codec/scan/scan_frame.h"
#include "stream/stream_state.h"
#include "stream/version1_header.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Decodes the frames of one stream of version 1 (doc/bitstream.md). */
class Version1Decoder {
public:
  explicit Version1Decoder(const DecoderLimits& limits) : limits_(limits) {}

  /** \brief Reads a frame after the magic bytes, and checks that it is complete, not
   * old, and can be decoded.
   *
   * A frame that fails here or in decode() does not change the history. An exception
   * does not change it, or drops it until the next I-frame.
   * \param[in,out] source after the magic bytes
   */
  CompressionStatus
  read(ByteSource& source);

  /** \brief Decodes the frame that was read.
   * \param[in,out] work scratch memory
   * \param[out] frame the voxels; unspecified on failure
   * \param[out] statistics of this frame, without its size
   */
  CompressionStatus
  decode(CodingWorkspace& work, VoxelFrame& frame, CodedFrameStatistics& statistics)
  {
    return decode(work, frame, nullptr, statistics);
  }

  /** \brief Decodes the frame that was read, which has to be one of changes to a frame
   * that is known.
   * \param[in,out] work scratch memory
   * \param[out] changes unspecified on failure
   * \param[out] statistics of this frame, without its size
   */
  CompressionStatus
  decodeChanges(CodingWorkspace& work,
                VoxelChanges& changes,
                CodedFrameStatistics& statistics)
  {
    return decode(work, changes.came, &changes.gone, statistics);
  }

  /** \brief Whether the frame that was read is one of changes. */
  bool
  isOfChanges() const
  {
    return header_.is_of_changes;
  }

  /** \brief Whether all voxels of the last frame are known, as frames of changes refer
   * to them. */
  bool
  knowsLastVoxels() const
  {
    return has_history_ && state_.mayBeFollowedByChanges();
  }

  /** \brief Sets a frame to the voxels of the last one, if they are known. */
  void
  listLastVoxels(VoxelFrame& frame) const;

  /** \brief Stamp and frame_id of the last decoded frame, if it has them. */
  const std::optional<FrameStamp>&
  stamp() const
  {
    return stamp_;
  }

  /** \brief Voxels and bytes that memory was allocated for in the last call, which may
   * have failed. */
  std::size_t
  memoryTaken() const
  {
    return memory_taken_;
  }

  /** \brief Number of records in the history. */
  std::size_t
  trackedVoxels() const
  {
    return has_history_ ? state_.coders.trackedVoxels(state_.effort) : 0;
  }

  /** \brief Bytes of the history but for its voxels, an estimate that is rather too
   * high. */
  std::size_t
  memoryBytes() const
  {
    return state_.coders.memoryBytes();
  }

  /** \brief Drops the history, as if no frame had been decoded. */
  void
  forget() noexcept;

  /** \brief The same, with all memory, as it is needed elsewhere: the status of the
   * P-frames that follow tells it. */
  void
  drop() noexcept;

  /** \brief Reports the end of the input; see FrameOrder. */
  void
  inputEnded() noexcept
  {
    order_.inputEnded();
  }

  /** \brief Releases memory that the history does not need. */
  void
  releaseMemory();

private:
  CompressionStatus
  decode(CodingWorkspace& work,
         VoxelFrame& frame,
         VoxelFrame* gone,
         CodedFrameStatistics& statistics);

  std::uint64_t
  bytesOfVoxels() const;

  CompressionStatus
  limitFrame();

  CompressionStatus
  tooManyBlocks() const;

  CompressionStatus
  checkOrder();

  CompressionStatus
  verifyChecksum() const;

  CompressionStatus
  decodePayload(CodingWorkspace& work,
                VoxelFrame& frame,
                VoxelFrame* gone,
                PayloadSizes& sizes);

  CompressionStatus
  decodeVoxels(CodingWorkspace& work,
               const std::uint8_t* begin,
               const std::uint8_t* end,
               VoxelFrame& frame,
               PayloadSizes& sizes);

  CompressionStatus
  decodeFrameOfChanges(CodingWorkspace& work,
                       const std::uint8_t* begin,
                       const std::uint8_t* end,
                       VoxelFrame& frame,
                       VoxelFrame* gone,
                       PayloadSizes& sizes);

  bool
  listChanges(VoxelFrame& gone, VoxelFrame& came) const;

  CompressionStatus
  decodeScan(const std::uint8_t* begin,
             const std::uint8_t* end,
             VoxelFrame& frame,
             PayloadSizes& sizes);

  bool
  hasOtherPoints(const VoxelFrame& frame) const;

  bool
  decodeSupplement(const std::uint8_t* begin,
                   const std::uint8_t* end,
                   VoxelFrame& frame,
                   PayloadSizes& sizes);

  void
  prepareStamp();

  void
  learn() noexcept;

  DecoderLimits limits_;

  FrameOrder order_{true};
  bool has_history_ = false;
  bool is_dropped_ = false; // there was a history
  StreamState state_;       // after the last decoded frame
  std::optional<FrameStamp> stamp_;

  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  std::uint32_t checksum_ = 0;
  std::size_t header_bytes_ = 0; // with the magic ones
  FrameLimits frame_limits_{};
  std::size_t blocks_by_memory_ = most_blocks;
  std::vector<std::uint8_t> checked_bytes_;
  std::size_t header_size_ = 0; // in checked_bytes_
  std::size_t memory_taken_ = 0;
  std::optional<FrameStamp> next_stamp_;
  VoxelFrame coarse_voxels_; // with a refinement
  scan::ScanFrame scan_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
