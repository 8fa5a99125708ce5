// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
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

namespace pcl_ext {
namespace io {

/** \brief Decodes the frames of one stream of version 1 (doc/bitstream.md). */
class Version1Decoder {
public:
  explicit Version1Decoder(const DecoderLimits& limits) : limits_(limits) {}

  /** \brief Reads and decodes a frame after the magic bytes.
   *
   * A frame that fails does not change the history. An exception does not change it, or
   * drops it until the next I-frame.
   * \param[in,out] source after the magic bytes
   * \param[in,out] work scratch memory
   * \param[out] frame the voxels; unspecified on failure
   * \param[out] statistics of this frame, without its size
   */
  CompressionStatus
  decode(ByteSource& source,
         CodingWorkspace& work,
         VoxelFrame& frame,
         CodedFrameStatistics& statistics);

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
  readFrame(ByteSource& source, std::uint32_t& checksum);

  std::uint64_t
  bytesOfVoxels() const;

  CompressionStatus
  limitFrame();

  CompressionStatus
  tooManyBlocks() const;

  CompressionStatus
  checkOrder(std::uint32_t checksum);

  CompressionStatus
  verifyChecksum(std::uint32_t checksum) const;

  CompressionStatus
  decodePayload(CodingWorkspace& work, VoxelFrame& frame, PayloadSizes& sizes);

  CompressionStatus
  decodeVoxels(CodingWorkspace& work,
               const std::uint8_t* begin,
               const std::uint8_t* end,
               VoxelFrame& frame,
               PayloadSizes& sizes);

  CompressionStatus
  decodeChanges(CodingWorkspace& work,
                const std::uint8_t* begin,
                const std::uint8_t* end,
                VoxelFrame& frame,
                PayloadSizes& sizes);

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

  CompressionStatus
  prepareFrame(const std::uint8_t*& payload, VoxelFrame& frame);

  CompressionStatus
  prepareFields(VoxelFrame& frame);

  CompressionStatus
  prepareContent(VoxelFrame& frame);

  CompressionStatus
  completeHeader();

  CompressionStatus
  readPayloadsDepthModel(const std::uint8_t*& payload);

  void
  prepareStamp();

  void
  learn(std::uint32_t checksum) noexcept;

  DecoderLimits limits_;

  FrameOrder order_{true};
  bool has_history_ = false;
  bool is_dropped_ = false; // there was a history
  StreamState state_;       // after the last decoded frame
  std::optional<FrameStamp> stamp_;

  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  FrameLimits frame_limits_{};
  std::size_t blocks_by_memory_ = most_blocks;
  std::vector<std::uint8_t> checked_bytes_;
  std::size_t header_size_ = 0; // in checked_bytes_
  std::size_t memory_taken_ = 0;
  std::optional<FrameStamp> next_stamp_;
  VoxelFrame coarse_voxels_; // with a refinement
  scan::ScanFrame scan_;
};

} // namespace io
} // namespace pcl_ext
