// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include "codec/frame_limits.h"
#include "voxels/memory_rule.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace fast {
struct Workspace;
} // namespace fast

namespace changes {
struct FrameChanges;
} // namespace changes

/** \brief Whether the history has indices for the blocks of a P-frame, too. If not, an
 * encoder makes an I-frame instead, and a decoder refuses the frame.
 * \param[in] blocks of the history
 * \param[in] voxels of the frame
 */
constexpr bool
fitsHistory(std::size_t blocks, std::size_t voxels)
{
  return blocks + voxels <= most_blocks;
}

/** \brief The most tracked voxels, or blocks with them, that the history may have
 * before a P-frame. If there are more, an encoder makes an I-frame instead, and a
 * decoder refuses the frame.
 * \param[in] count voxels or blocks of the frame for an encoder, the limit for a
 * decoder
 */
constexpr std::size_t
maxTracked(std::size_t count)
{
  // Streams of fixed sensors have two to five for each voxel.
  const std::size_t of_small_frames = 8 * count + (std::size_t{1} << 16);
  const std::size_t of_large_frames = 2 * count + (std::size_t{1} << 20);
  return of_small_frames < of_large_frames ? of_small_frames : of_large_frames;
}

/** \brief Bytes of a payload by what they code; as occupancy where a coder does not
 * separate them. */
struct PayloadSizes {
  std::size_t occupancy = 0;
  std::size_t intensity = 0;
  std::size_t attributes = 0; ///< of the supplement
  /** \brief Decoding failed as there are more than CodedPayload::max_blocks. */
  bool has_too_many_blocks = false;
};

/** \brief A payload to decode. */
struct CodedPayload {
  const std::uint8_t* begin; ///< first byte
  const std::uint8_t* end;   ///< one past the last byte
  std::size_t voxel_count;   ///< of the frame
  bool is_i_frame;           ///< coded without the history
  /** \brief Most blocks that are not tracked. */
  std::size_t max_blocks = most_blocks;
};

/** \brief Memory for a frame while it is coded; may be used by several streams in turn.
 * See DecodingMemory. */
class PCL_EXT_CODEC_EXPORT CodingWorkspace {
public:
  CodingWorkspace();
  ~CodingWorkspace();

  /** \brief That of effort fast, created by the first call; the other efforts need
   * none. */
  fast::Workspace&
  fast();

  /** \brief That of frames of changes, likewise. */
  changes::FrameChanges&
  changes();

  /** \brief Ends a frame. Releases memory that recent frames did not need.
   * \param[in] needed by the frame, voxels plus bytes
   * \param[in] taken allocated for it, voxels plus bytes
   */
  void
  endFrame(std::size_t needed, std::size_t taken);

  /** \brief Releases all of it. */
  void
  releaseMemory() noexcept;

  /** \brief Whether there may be any. */
  bool
  isUsed() const
  {
    return fast_ != nullptr || changes_ != nullptr;
  }

private:
  std::unique_ptr<fast::Workspace> fast_;
  std::unique_ptr<changes::FrameChanges> changes_;
  MemoryRule memory_rule_;
};

/** \brief Encodes or decodes the voxels of the frames of one stream as payloads, and
 * keeps the history of the stream. An instance is for one direction. After an exception
 * it may only be destroyed. */
class PayloadCoder {
public:
  virtual ~PayloadCoder() = default;

  /** \brief Finds the voxels of the next frame that are tracked. To be
   * called before encode() of a P-frame, with the same voxels and memory.
   * \param[in,out] memory for the frame
   * \param[in] frame as isConsistent() demands; may be empty
   * \return number of its voxels that are tracked
   */
  virtual std::size_t
  match(CodingWorkspace& memory, const VoxelFrame& frame) = 0;

  /** \brief Appends the payload of the next frame of the stream, and updates the
   * history.
   * \param[in,out] memory for the frame
   * \param[in] frame as isConsistent() demands; may be empty
   * \param[in] is_i_frame code it without the history; a P-frame is coded without where
   * that takes fewer bytes
   * \param[in,out] payload where to append
   */
  virtual PayloadSizes
  encode(CodingWorkspace& memory,
         const VoxelFrame& frame,
         bool is_i_frame,
         std::vector<std::uint8_t>& payload) = 0;

  /** \brief Inverse of encode(). After success either learn() or discard() has to be
   * called; a failure does not change the history.
   * \param[in,out] memory for the frame, not to be used for others before learn() or
   * discard()
   * \param[in] payload its bytes
   * \param[in,out] frame its voxels are set; its other members are given
   * \param[out] sizes as returned by encode()
   * \return false if the bytes are not exactly one payload of that many voxels
   */
  virtual bool
  decode(CodingWorkspace& memory,
         const CodedPayload& payload,
         VoxelFrame& frame,
         PayloadSizes& sizes) = 0;

  /** \brief Updates models and history with the frame that was decoded last. */
  virtual void
  learn() noexcept = 0;

  /** \brief Restores models and history to their state before the frame that was
   * decoded last. */
  virtual void
  discard() noexcept = 0;

  /** \brief Releases memory that models and history do not need. */
  virtual void
  releaseMemory() = 0;

  /** \brief Number of tracked voxels. */
  virtual std::size_t
  trackedVoxels() const = 0;

  /** \brief Number of blocks with tracked voxels. */
  virtual std::size_t
  trackedBlocks() const = 0;

  /** \brief Bytes of the models. */
  virtual std::size_t
  modelBytes() const = 0;
};

/** \brief The coders of one stream by effort, each created on first use. */
class PayloadCoders {
public:
  /** \brief The coder of an effort. */
  PayloadCoder&
  of(Effort effort);

  /** \brief Number of tracked voxels of the coder of an effort; 0 if there is none. */
  std::size_t
  trackedVoxels(Effort effort) const;

  /** \brief Bytes of all coders but for their voxels, an estimate that is rather too
   * high. */
  std::size_t
  memoryBytes() const;

  /** \brief Destroys all coders but that of an effort. */
  void
  keepOnly(Effort effort) noexcept;

  /** \brief Destroys all coders and their histories. */
  void
  clear() noexcept;

private:
  std::array<std::unique_ptr<PayloadCoder>, 3> coders_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
