// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/changes/change_coder.h"
#include "codec/payload_coder.h"
#include "codec/supplement/supplement.h"
#include "stream/version1_header.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace io {

class ImageTrial;

/** \brief Encodes the frames of one stream of version 1, each as the I- or P-frame that
 * the caller wants. */
class Version1Encoder {
public:
  /** \param[in] effort of the stream
   * \param[in] has_p_frames false if every frame will be an I-frame
   */
  Version1Encoder(Effort effort, bool has_p_frames);
  ~Version1Encoder();

  /** \brief True if a frame cannot be a P-frame, or should be none. */
  bool
  needsIFrame(const VoxelFrame& frame, const std::optional<FrameStamp>& stamp);

  /** \brief True if a frame that need not be an I-frame should be one of changes.
   * \param[in] was_of_changes the last frame
   */
  bool
  hasFewChanges(const VoxelFrame& frame, bool was_of_changes);

  /** \brief Sets the effort, before an I-frame. */
  void
  setEffort(Effort effort)
  {
    effort_ = effort;
    forgetHistory();
  }

  /** \brief Encodes the next frame as one of changes, for which hasFewChanges() is
   * true; parameters are those of encode(). */
  void
  encodeChanges(const VoxelFrame& frame,
                const std::optional<FrameStamp>& stamp,
                std::vector<std::uint8_t>& bytes,
                CodedFrameStatistics& statistics);

  /** \brief Matches a frame that need not be an I-frame with the history.
   * \return what encode() takes for a P-frame; valid until then
   */
  const VoxelFrame&
  match(const VoxelFrame& frame);

  /** \brief Encodes the next frame.
   * \param[in] frame as FrameEncoder checks it
   * \param[in] matched result of match() for this frame; null: an I-frame
   * \param[in] stamp of the frame, if it has one
   * \param[out] bytes where the frame is appended
   * \param[in,out] statistics sizes and number of the frame are set
   */
  void
  encode(const VoxelFrame& frame,
         const VoxelFrame* matched,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes,
         CodedFrameStatistics& statistics);

  /** \brief Sets the number of the first frame. */
  void
  startAt(std::uint32_t number)
  {
    frame_number_ = number - 1;
  }

  /** \brief Drops the number of the last frame, for another one in its place. */
  void
  takeBack()
  {
    --frame_number_;
  }

  /** \brief True if a frame of changes may follow the last frame. */
  bool
  mayBeFollowedByChanges() const
  {
    return changes_ && changes_->hasLastFrame();
  }

  /** \brief Whether a frame may have an image.
   * \param[in] is_i_frame where images took more bytes some I-frames have none, either
   */
  bool
  takesImages(bool is_i_frame) const
  {
    return is_i_frame ? settled_i_frames_ == 0 || is_image_smaller_
                      : content_.has_image || is_i_frame_empty_;
  }

  /** \brief Whether the next frame had better be an I-frame, as rays no longer fit, or
   * voxels take fewer bytes than an image. */
  bool
  wantsIFrame() const
  {
    return wants_i_frame_;
  }

  /** \brief Whether the last frame, a P-frame, has so few bytes that decoders of default
   * limits refuse it: an I-frame takes its place, see frameLimits(). */
  bool
  lacksBytes() const
  {
    return lacks_bytes_;
  }

  /** \brief Ends a frame in the memory that is used for one.
   * \return voxels, bytes and records that the stream needed for it
   */
  std::size_t
  endFrame(const VoxelFrame& frame);

  void
  releaseMemory();

  /** \brief Forgets the history, after memory ran out: the next frame is an I-frame. */
  void
  forgetHistory();

private:
  bool
  hasOtherFields(const VoxelFrame& frame) const;

  bool
  hasOtherImage(const VoxelFrame& frame) const;

  bool
  comeAgain(const std::vector<std::uint64_t>& keys) const;

  const VoxelFrame&
  codedVoxels(const VoxelFrame& frame);

  void
  writeHeader(const VoxelFrame& frame,
              bool is_i_frame,
              const std::optional<FrameStamp>& stamp);

  void
  pad(const VoxelFrame& frame);

  void
  writeFrame(const VoxelFrame& frame,
             const PayloadSizes& sizes,
             std::vector<std::uint8_t>& bytes,
             CodedFrameStatistics& statistics);

  void
  keepForChanges(const VoxelFrame& frame);

  PayloadSizes
  encodeIFrame(const VoxelFrame& frame);

  PayloadSizes
  encodeWithContent(const VoxelFrame& frame, bool has_image);

  void
  settleImages(std::size_t size, std::size_t size_of_others);

  void
  followImage(const VoxelFrame& frame);

  void
  endTrial();

  PayloadSizes
  encodeContent(const VoxelFrame& frame, const VoxelFrame& coded);

  void
  setContent(const VoxelFrame& frame, bool has_image);

  void
  encodeSupplement(const VoxelFrame& frame,
                   const VoxelFrame& coarse_voxels,
                   PayloadSizes& sizes);

  PayloadSizes
  encodePayload(const VoxelFrame& frame);

  PayloadSizes
  encodePayloadAs(const VoxelFrame& frame);

  PayloadCoder&
  coder()
  {
    return coders_.of(effort_);
  }

  /** \brief Change of the stamp since the last frame, modulo 2^64. */
  std::int64_t
  stampChange(const FrameStamp& stamp) const
  {
    return static_cast<std::int64_t>(stamp.stamp - stamp_);
  }

  Effort effort_;
  bool has_p_frames_;

  // State after the previous frames.
  std::uint32_t frame_number_ = 0;
  std::uint32_t checksum_ = 0;
  std::uint64_t bytes_since_i_frame_ = 0; // payloads, that of the I-frame included
  bool lacks_bytes_ = false;              // see lacksBytes()
  VoxelGrid grid_;
  IntensityScale intensity_scale_;
  bool has_depth_model_ = false;          // the previous frame
  bool uses_depth_model_ = false;         // encodePayload() since the last I-frame
  std::optional<DepthModel> depth_model_; // that a decoder has
  supplement::Content content_;
  std::vector<FieldDescription> fields_;
  std::array<std::int32_t, 3> viewpoint_{};
  PointImage image_;                  // without points
  bool is_i_frame_empty_ = false;     // the last one
  bool is_image_smaller_ = false;     // by the last trial
  unsigned int settled_i_frames_ = 0; // that are not tried
  double i_frame_density_ = 0.0;      // bytes of a point
  double settled_density_ = 0.0;      // likewise, when it was settled; 0: not yet
  bool wants_i_frame_ = false;
  std::unique_ptr<ImageTrial> trial_;                       // while it lasts
  bool is_refinement_useful_ = true;                        // by the previous frames
  bool is_refinement_tried_ = false;                        // compared with none
  std::vector<std::uint64_t> last_keys_;                    // with a refinement
  std::unique_ptr<supplement::SupplementCoder> supplement_; // made when it is needed
  std::string frame_id_;
  std::uint64_t stamp_ = 0;
  PayloadCoders coders_;
  std::unique_ptr<changes::ChangeCoder> changes_; // made when it is needed

  // Of the current frame; members so that their memory is reused.
  Version1Header header_;
  VoxelFrame coarse_voxels_;
  VoxelFrame frame_without_model_;
  std::vector<std::uint8_t> payload_;
  CodingWorkspace work_;
};

} // namespace io
} // namespace pcl_ext
