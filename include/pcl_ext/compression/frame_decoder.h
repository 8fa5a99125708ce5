#pragma once

#include <pcl_ext/compression/coding_memory.h>
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/compression_status.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <streambuf>

namespace pcl_ext {
namespace io {

/** \brief Turns the bytes of one stream back into voxel frames. Knows no points and no
 * PCL.
 *
 * Any bytes are safe: decoding ends in bounded time and memory (DecoderLimits), never
 * throws, and a frame is either decoded whole or not at all. A frame that fails leaves
 * the history as it was, so that the stream goes on with the next frame that depends on
 * what was decoded, at the latest with the next I-frame. Where memory runs out
 * (OutOfMemory) nothing may be known until then. Frames that come late or twice are
 * dropped (OldFrame); an input that ended, and is read again from its first frame, is not
 * old. doc/robustness.md has all that is promised.
 */
class PCL_EXT_EXPORT FrameDecoder {
public:
  /** \brief A decoder at the start of a stream.
   * \param[in] limits what decoding may cost
   */
  explicit FrameDecoder(const DecoderLimits& limits = DecoderLimits());
  ~FrameDecoder();
  FrameDecoder(FrameDecoder&&) noexcept;
  FrameDecoder&
  operator=(FrameDecoder&&) noexcept;

  /** \brief Decodes the next frame found in a stream buffer, whichever the format.
   *
   * Bytes before the frame are skipped and counted. After a failure a buffer that can
   * seek is left one byte behind the start of the failed frame, so that the next call
   * looks for another one; the bytes of one that cannot are lost, and so are those that were
   * read again too often, as where many beginnings of frames lie one behind the other. A
   * frame that is old or lacks its reference is passed over whole if another frame, or
   * nothing, follows it.
   * \param[in,out] source where to read; no byte behind the frame is taken
   * \param[out] frame the voxels; empty unless the status is Ok
   * \return Ok, or why there is no frame
   */
  CompressionStatus
  decode(std::streambuf& source, VoxelFrame& frame);

  /** \brief The same for bytes in memory: the first frame in them. It and what was skipped
   * before it are statistics().skipped_bytes + statistics().bytes; the next call may go on
   * behind them.
   * \param[in] bytes begin of the bytes
   * \param[in] size their number
   * \param[out] frame the voxels; empty unless the status is Ok
   */
  CompressionStatus
  decode(const std::uint8_t* bytes, std::size_t size, VoxelFrame& frame);

  /** \brief The same with memory that several decoders take turns with.
   * \param[in,out] memory not to be used by another call at the same time
   */
  CompressionStatus
  decode(const std::uint8_t* bytes,
         std::size_t size,
         VoxelFrame& frame,
         CodingMemory& memory);

  /** \brief What the last decoded frame carried of a cloud's header, if anything. */
  const std::optional<FrameStamp>&
  stamp() const;

  /** \brief Figures of the last frame that was decoded. */
  const CodedFrameStatistics&
  statistics() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace io
} // namespace pcl_ext
