// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <streambuf>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

class CodingWorkspace;

/** \brief Scratch memory for decoding a frame; used during a call only.
 *
 * Each decoder has its own unless decode() is given one. Decoders called by one thread
 * in turn can share one, which then stays in the processor's caches; with hundreds of
 * streams that saves time. CentralNode has one for each of its threads. Not for two
 * calls at the same time. Memory of a large frame is released a few frames later.
 */
class PCL_EXT_CODEC_EXPORT DecodingMemory {
public:
  DecodingMemory();
  ~DecodingMemory();
  DecodingMemory(DecodingMemory&&) noexcept;
  DecodingMemory&
  operator=(DecodingMemory&&) noexcept;

private:
  friend class FrameDecoder;
  std::unique_ptr<CodingWorkspace> workspace_;
};

/** \brief Decodes the frames of one stream, in either format.
 *
 * Any bytes are safe: decoding ends in bounded time and memory (DecoderLimits), never
 * throws, and a frame is either decoded completely or not at all. A frame that fails
 * does not change the history, so that the stream continues with the next frame that
 * depends on a decoded one, at the latest with the next I-frame. After OutOfMemory the
 * history may be lost until then. Late and repeated frames are dropped (OldFrame); an
 * input that ended and is read again from its first frame is not old. See
 * doc/robustness.md.
 *
 * Who keeps the voxels, as a map or a display, can take only what changed:
 * \code
 * if (decoder.decode(bytes, size, changes).ok()) {
 *   if (changes.is_from_nothing)
 *     ; // drop all voxels
 *   ; // remove changes.gone, then add changes.came
 * }
 * \endcode
 */
class PCL_EXT_CODEC_EXPORT FrameDecoder {
public:
  /** \brief A decoder at the start of a stream.
   * \param[in] limits bounds on time and memory
   * \param[in] incomplete_frame what to do after Truncated with a buffer that can seek
   */
  explicit FrameDecoder(const DecoderLimits& limits = DecoderLimits(),
                        IncompleteFrame incomplete_frame = IncompleteFrame::Skip);
  ~FrameDecoder();
  FrameDecoder(FrameDecoder&&) noexcept;
  FrameDecoder&
  operator=(FrameDecoder&&) noexcept;

  /** \brief Decodes the next frame found in a stream buffer.
   *
   * Bytes before the frame are skipped and counted. After a failure a buffer that can
   * seek is left one byte after the start of the failed frame, so that the next call
   * searches from there, or at its start if it is incomplete and to be kept. The bytes
   * of a buffer that cannot seek are lost, and so are bytes that would be read again
   * too often, as in a run of forged frame starts. A frame that is old or lacks its
   * reference is skipped completely if another frame, or nothing, follows it.
   * \param[in,out] source where to read; no byte after the frame is consumed
   * \param[out] frame the voxels; empty unless the status is Ok
   * \return Ok, or why there is no frame
   */
  CompressionStatus
  decode(std::streambuf& source, VoxelFrame& frame);

  /** \brief Decodes the first frame found in memory. It ends at
   * statistics().skipped_bytes + statistics().bytes, where the next call may continue.
   * \param[in] bytes the first byte
   * \param[in] size number of bytes
   * \param[out] frame the voxels; empty unless the status is Ok
   */
  CompressionStatus
  decode(const std::uint8_t* bytes, std::size_t size, VoxelFrame& frame);

  /** \brief The same with scratch memory that several decoders share.
   * \param[in] bytes the first byte
   * \param[in] size number of bytes
   * \param[out] frame the voxels; empty unless the status is Ok
   * \param[in,out] memory not to be used by another call at the same time
   */
  CompressionStatus
  decode(const std::uint8_t* bytes,
         std::size_t size,
         VoxelFrame& frame,
         DecodingMemory& memory);

  /** \brief Decodes the first frame found in memory, as above, and tells how its voxels
   * differ from those of the last frame that was decoded, by whichever function.
   *
   * A frame of changes (CodedFrameStatistics::is_of_changes) takes less time than as a
   * whole; other frames are decoded and compared. Voxels are made of points that a frame
   * has, whatever setDecodesVoxels() says; the points, their numbers and fields are no
   * part of changes.
   *
   * VoxelChanges::is_from_nothing is set where the last frame is not known: for the
   * first frame, and for that after the memory was dropped to keep a MemoryBudget or
   * ran out. Frames before the first call of this function may be unknown, too, as
   * their voxels are not kept. After a failure nothing changed, and the next frame that
   * is decoded is compared with the same one as this.
   * \param[in] bytes the first byte
   * \param[in] size number of bytes
   * \param[out] changes its memory is reused; both parts are empty unless the status is
   * Ok
   */
  CompressionStatus
  decode(const std::uint8_t* bytes, std::size_t size, VoxelChanges& changes);

  /** \brief The same with scratch memory that several decoders share.
   * \param[in] bytes the first byte
   * \param[in] size number of bytes
   * \param[out] changes as above
   * \param[in,out] memory not to be used by another call at the same time
   */
  CompressionStatus
  decode(const std::uint8_t* bytes,
         std::size_t size,
         VoxelChanges& changes,
         DecodingMemory& memory);

  /** \brief All voxels of the last frame that was decoded, without points, their numbers
   * and fields: what the changes add up to.
   * \param[out] frame its memory is reused. Empty if they are not known, which the next
   * changes tell, too, see VoxelChanges::is_from_nothing
   * \return false if they are not known, or there is no memory for them
   */
  bool
  latestVoxels(VoxelFrame& frame);

  /** \brief Whether frames that have their points get their voxels, too, which takes as
   * much time as to decode them: true at first. Without them VoxelFrame::keys is empty,
   * and forEachPoint() gives what a decoded cloud has. Other frames always have voxels.
   * Points outside the grid have none and are left out; the status of decode() says how
   * many. */
  void
  setDecodesVoxels(bool decodes_voxels);

  /** \brief Stamp and frame_id of the last decoded frame, if it has them. */
  const std::optional<FrameStamp>&
  stamp() const;

  /** \brief Figures of the last frame that was decoded. */
  const CodedFrameStatistics&
  statistics() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/** \brief What stands at the beginning of a buffer, see frameSize(). */
struct FrameSize {
  /** \brief Ok: the size is known. Truncated: more bytes are required to know it.
   * NoFrame, UnsupportedVersion, Corrupt, LimitExceeded: no frame begins here that a
   * decoder takes. */
  CompressionStatus status;

  std::size_t known = 0;  ///< bytes of the whole frame, of which fewer may have arrived
  std::size_t needed = 0; ///< bytes that the frame has at least; as known, if that is
  std::size_t drop = 0;   ///< bytes without a frame, after which one may begin
};

/** \brief Tells how many bytes the frame at the beginning of a buffer has, for bytes
 * that arrive in pieces, as from a socket.
 *
 * A frame of version 1 is known by its first 100 bytes or so, and the time does not
 * depend on its size. The published layout does not tell its size: there the frame is
 * decoded, and the size is known when it is complete.
 *
 * \code
 * const auto size = pcl_ext::io::frameSize(buffer.data(), buffer.size());
 * if (size.drop > 0)
 *   ; // remove size.drop bytes
 * else if (size.needed > buffer.size())
 *   ; // receive more, until there are size.needed bytes
 * else if (size.status.ok())
 *   decoder.decode(buffer.data(), size.known, frame); // and remove size.known bytes
 * \endcode
 * \param[in] bytes the first byte
 * \param[in] count number of bytes at hand; may be 0
 * \param[in] limits of the decoder that gets the frame
 */
PCL_EXT_CODEC_EXPORT FrameSize
frameSize(const std::uint8_t* bytes,
          std::size_t count,
          const DecoderLimits& limits = DecoderLimits());

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
