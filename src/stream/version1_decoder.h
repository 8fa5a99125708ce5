#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/status.h>

#include "bytes/byte_source.h"
#include "codec/payload_coder.h"
#include "stream/frame_order.h"
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
  explicit Version1Decoder(const DecoderLimits& limits) : limits_(limits)
  {
    limits_.max_voxels = std::min(limits.max_voxels, largest_frame);
  }

  /** \brief Reads and decodes a frame, of which the magic bytes have been read.
   *
   * A frame that fails leaves what is known as it was. An exception leaves it so, too, or
   * leaves nothing known until the next I-frame.
   * \param[in,out] source behind the magic bytes
   * \param[in,out] work memory for the frame
   * \param[out] frame the voxels; unspecified on failure
   * \param[out] statistics of this frame, without its size
   */
  CompressionStatus
  decode(ByteSource& source,
         CodingWorkspace& work,
         VoxelFrame& frame,
         CodedFrameStatistics& statistics);

  /** \brief What the last decoded frame carried of a cloud's header, if anything. */
  const std::optional<FrameStamp>&
  stamp() const
  {
    return stamp_;
  }

  /** \brief What the last frame may have taken, decoded or not, in voxels and bytes. */
  std::size_t
  memoryTaken() const
  {
    return memory_taken_;
  }

  /** \brief Voxels that are known of the frames before. */
  std::size_t
  recordCount() const
  {
    return has_history_ ? coders_.recordCount(effort_) : 0;
  }

  /** \brief Forgets all frames, as if none had been decoded. */
  void
  forget() noexcept;

  /** \brief Tells that the input ended; see FrameOrder. */
  void
  inputEnded() noexcept
  {
    order_.inputEnded();
  }

  /** \brief Gives back the memory that what is known does not need. */
  void
  giveBackMemory();

private:
  CompressionStatus
  readFrame(ByteSource& source, std::uint32_t& checksum);

  static CompressionStatus
  readFailure(const ByteSource& source);

  CompressionStatus
  checkOrder(std::uint32_t checksum);

  CompressionStatus
  checkSum(std::uint32_t checksum) const;

  CompressionStatus
  decodePayload(CodingWorkspace& work, VoxelFrame& frame, PayloadSizes& sizes);

  CompressionStatus
  prepareFrame(const std::uint8_t*& payload, VoxelFrame& frame);

  void
  prepareStamp();

  void
  learn(std::uint32_t checksum, const VoxelFrame& frame) noexcept;

  DecoderLimits limits_;

  FrameOrder order_{true};
  // Of the frames that were decoded.
  bool has_history_ = false;
  std::uint32_t frame_number_ = 0;
  std::uint32_t checksum_ = 0;
  VoxelGrid grid_;
  IntensityScale intensity_scale_;
  Effort effort_ = Effort::Balanced;
  std::optional<DepthModel> depth_model_;
  std::string frame_id_;
  std::uint64_t last_stamp_ = 0;
  std::optional<FrameStamp> stamp_;
  PayloadCoders coders_;

  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  std::vector<std::uint8_t> checked_bytes_;
  std::size_t header_size_ = 0; // of the checked bytes
  std::size_t memory_taken_ = 0;
  std::optional<FrameStamp> next_stamp_;
};

} // namespace io
} // namespace pcl_ext
