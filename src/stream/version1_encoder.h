// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/payload_coder.h"
#include "stream/frame_kind.h"
#include "stream/refinement_choice.h"
#include "stream/stream_state.h"
#include "stream/version1_header.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Encodes the frames of one stream of version 1, each as the kind of frame that
 * the caller wants. */
class Version1Encoder {
public:
  /** \param[in] effort of the stream
   * \param[in] has_p_frames false if every frame will be an I-frame
   * \param[in] first_frame_number see StreamSettings
   */
  Version1Encoder(Effort effort,
                  bool has_p_frames,
                  std::uint32_t first_frame_number = 1);

  Effort
  effort() const
  {
    return effort_;
  }

  /** \brief Sets the effort, before an I-frame. */
  void
  setEffort(Effort effort)
  {
    effort_ = effort;
    forgetVoxels();
  }

  /** \brief Sets the reasons that a frame has to be an I-frame, once for each frame that
   * has no other reason. */
  void
  addReasons(const VoxelFrame& frame,
             const std::optional<FrameStamp>& stamp,
             IFrameReasons& reasons);

  /** \brief The same for points. */
  void
  addReasons(const scan::ScanFrame& scan,
             const std::optional<FrameStamp>& stamp,
             IFrameReasons& reasons) const;

  /** \brief True if a frame that need not be an I-frame should be one of changes. */
  bool
  hasFewChanges(const VoxelFrame& frame);

  /** \brief True if the next frame, which need not be an I-frame for other reasons, should
   * be one of changes, and is known by how it differs from the last one. False if all of
   * its voxels have to be known. */
  bool
  takeChanges(const VoxelChanges& changes, const std::optional<FrameStamp>& stamp);

  /** \brief Encodes a frame whose changes were taken.
   * \param[in] changes the same
   * \return false if they are not those of the last frame, which changes nothing
   */
  bool
  encodeTaken(const VoxelChanges& changes,
              const std::optional<FrameStamp>& stamp,
              std::vector<std::uint8_t>& bytes,
              CodedFrameStatistics& statistics);

  /** \brief Encodes the next frame.
   * \param[in] kind Changes only if hasFewChanges() was true for the frame
   * \param[in] frame as FrameEncoder checks it
   * \param[in] stamp of the frame, if it has one
   * \param[out] bytes where the frame is appended
   * \param[in,out] statistics sizes and number of the frame are set
   */
  void
  encode(FrameKind kind,
         const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes,
         CodedFrameStatistics& statistics);

  /** \brief Encodes the points of the next frame.
   * \param[in] scan as FrameEncoder checks it
   */
  void
  encode(bool is_i_frame,
         const scan::ScanFrame& scan,
         const std::optional<FrameStamp>& stamp,
         unsigned int threads,
         std::vector<std::uint8_t>& bytes,
         CodedFrameStatistics& statistics);

  /** \brief Whether the last frame had better be replaced by an I-frame: a P-frame that
   * has so few bytes that decoders of default limits refuse it, see frameLimits(). */
  bool
  needsReplacement() const
  {
    return needs_replacement_;
  }

  /** \brief Drops the number of the last frame, for another one in its place. */
  void
  takeBack()
  {
    --state_.frame_number;
  }

  /** \brief Ends a frame in the memory that is used for one.
   * \param[in] elements its voxels or pixels, and values of fields
   * \return with bytes and records that the stream needed for it
   */
  std::size_t
  endFrame(std::size_t elements);

  void
  releaseMemory();

  /** \brief Forgets the histories of the voxels, after memory ran out: the next frame is
   * an I-frame. */
  void
  forgetVoxels();

private:
  bool
  hasOtherContent(const VoxelFrame& frame) const;

  bool
  hasLongHistory(std::size_t voxels, std::size_t blocks);

  bool
  mayHaveFewChanges(std::size_t voxels,
                    std::size_t blocks_before,
                    const std::optional<DepthModel>& model) const;

  bool
  areFew(std::size_t changes, std::size_t voxels) const;

  void
  learn(std::uint32_t checksum, bool has_depth_model);

  bool
  hasFarStamp(const std::optional<FrameStamp>& stamp) const;

  void
  beginHeader(bool is_i_frame, const std::optional<FrameStamp>& stamp);

  void
  setContent(const VoxelFrame& frame);

  const VoxelFrame&
  codedVoxels(const VoxelFrame& frame);

  PayloadSizes
  encodeIFrame(const VoxelFrame& frame);

  PayloadSizes
  encodePFrame(const VoxelFrame& frame);

  bool
  encodeChanges(const VoxelFrame& frame);

  PayloadSizes
  encodeContent(const VoxelFrame& frame, const VoxelFrame& coded);

  void
  encodeSupplement(const VoxelFrame& frame,
                   const VoxelFrame& coarse_voxels,
                   PayloadSizes& sizes);

  PayloadSizes
  encodeIPayload(const VoxelFrame& frame);

  const VoxelFrame&
  withoutModel(const VoxelFrame& frame);

  PayloadSizes
  encodePayload(const VoxelFrame& frame);

  bool
  pad(const FrameCounts& counts);

  std::uint32_t
  writeFrame(const FrameCounts& counts,
             const PayloadSizes& sizes,
             std::vector<std::uint8_t>& bytes,
             CodedFrameStatistics& statistics);

  PayloadCoder&
  coder()
  {
    return state_.coders.of(effort_);
  }

  Effort effort_; // of the next frame
  bool has_p_frames_;
  StreamState state_;
  RefinementChoice refinement_choice_;
  // Of the last frame:
  bool had_depth_model_ = false; // whether it was coded or not
  bool was_of_changes_ = false;
  bool needs_replacement_ = false;

  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  VoxelFrame coarse_voxels_;
  VoxelFrame frame_without_model_;
  std::vector<std::uint8_t> payload_;
  changes::ChangeCoder::ChangedFrame taken_; // by takeChanges()
  CodingWorkspace work_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
