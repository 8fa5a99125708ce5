// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/payload_coder.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace pcl_ext {
namespace io {

class ImageTrial;

/** \brief Decides for an encoder whether frames have the order of their points,
 * VoxelFrame::image: where that takes fewer bytes. */
class ImageChoice {
public:
  /** \brief What encoding a frame gave. */
  struct Encoded {
    PayloadSizes sizes;
    std::size_t bytes = 0;    ///< of the payload
    std::uint64_t points = 0; ///< 0: unknown
  };

  /** \brief Encodes an I-frame, with its image or without. */
  using EncodeIFrame = std::function<Encoded(bool has_image)>;

  /** \param[in] has_p_frames false if every frame will be an I-frame */
  explicit ImageChoice(bool has_p_frames);
  ~ImageChoice();
  ImageChoice(ImageChoice&&) noexcept;
  ImageChoice&
  operator=(ImageChoice&&) noexcept;

  /** \brief Whether a frame may have an image.
   * \param[in] is_i_frame where images took more bytes some I-frames have none, either
   * \param[in] had_image the last frame
   */
  bool
  mayHaveImage(bool is_i_frame, bool had_image) const
  {
    return is_i_frame ? untried_i_frames_ == 0 || is_smaller_
                      : had_image || is_i_frame_empty_;
  }

  /** \brief Whether the last I-frame had no voxels, so that the first frame with points
   * may begin with an image. */
  bool
  isIFrameEmpty() const
  {
    return is_i_frame_empty_;
  }

  /** \brief Whether the next frame had better be an I-frame, as rays no longer fit, or
   * voxels take fewer bytes than an image. */
  bool
  wantsIFrame() const
  {
    return wants_i_frame_;
  }

  /** \brief Encodes an I-frame. Where its points have an order it is coded with that and
   * without it, and takes what has fewer bytes; after a trial some I-frames are not tried,
   * unless they take more bytes than before.
   * \param[in] effort of the stream
   * \param[in] had_image the last frame
   * \param[in] encode called up to three times; the last call is the frame
   */
  PayloadSizes
  encodeIFrame(const VoxelFrame& frame,
               Effort effort,
               bool had_image,
               const EncodeIFrame& encode);

  /** \brief Learns from a P-frame.
   * \param[in] has_image the frame has one, and voxels
   * \param[in] encoded what it took
   */
  void
  followPFrame(const VoxelFrame& frame, bool has_image, const Encoded& encoded);

  /** \brief Forgets what the histories of voxels take. */
  void
  forgetTrial();

private:
  Encoded
  tryImage(const VoxelFrame& frame, const EncodeIFrame& encode);

  void
  endTrial();

  bool has_p_frames_;
  bool is_i_frame_empty_ = false;     // the last one
  bool is_smaller_ = false;           // by the last trial
  unsigned int untried_i_frames_ = 0; // that follow
  double i_frame_density_ = 0.0;      // bytes of a point
  double tried_density_ = 0.0; // likewise, of the last trial; 0: of the next frame
  bool wants_i_frame_ = false;
  std::unique_ptr<ImageTrial> trial_; // while it lasts
};

} // namespace io
} // namespace pcl_ext
