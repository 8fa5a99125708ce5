// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/image_trial.h"

#include <optional>

namespace pcl_ext {
namespace io {

namespace {

// Until then the history of voxels has most of what it needs.
constexpr unsigned int trial_frames = 8;

} // namespace

ImageTrial::ImageTrial(Effort effort, const VoxelFrame& frame) : encoder_(effort, true)
{
  encode(frame);
}

bool
ImageTrial::add(const VoxelFrame& frame, std::size_t bytes_with_image)
{
  // The first frames have little history.
  if (++frames_ == trial_frames / 2)
    with_image_ = without_ = 0;
  if (!encode(frame)) {
    with_image_ += bytes_with_image;
    without_ += bytes_.size();
  }
  return frames_ == trial_frames;
}

bool
ImageTrial::isImageBetter() const
{
  // Rows and columns are worth a few bytes.
  return 20 * with_image_ <= 21 * without_;
}

/** \brief Encodes a frame without its image.
 * \return whether it is an I-frame
 */
bool
ImageTrial::encode(const VoxelFrame& frame)
{
  without_image_ = frame;
  without_image_.image = PointImage();
  const bool is_i_frame =
      frames_ == 0 || encoder_.needsIFrame(without_image_, std::nullopt);
  bytes_.clear();
  CodedFrameStatistics statistics;
  encoder_.encode(without_image_,
                  is_i_frame ? nullptr : &encoder_.match(without_image_),
                  std::nullopt,
                  bytes_,
                  statistics);
  return is_i_frame;
}

} // namespace io
} // namespace pcl_ext
