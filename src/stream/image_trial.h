// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "stream/version1_encoder.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Encodes the first frames of a stream with images without these, too: what an
 * I-frame takes does not tell what P-frames take, as where a scene stands still the
 * history of voxels is worth more than rays. */
class ImageTrial {
public:
  /** \param[in] effort of the stream
   * \param[in] frame the I-frame
   */
  ImageTrial(Effort effort, const VoxelFrame& frame);

  /** \brief Adds a P-frame.
   * \param[in] bytes_with_image that it takes
   * \return true if the trial is over
   */
  bool
  add(const VoxelFrame& frame, std::size_t bytes_with_image);

  bool
  hasPFrames() const
  {
    return without_ > 0;
  }

  /** \brief Whether P-frames take fewer bytes with an image, or hardly more. */
  bool
  isImageBetter() const;

private:
  bool
  encode(const VoxelFrame& frame);

  Version1Encoder encoder_;
  VoxelFrame without_image_;
  std::vector<std::uint8_t> bytes_;
  unsigned int frames_ = 0;
  // Of the last frames:
  std::size_t with_image_ = 0;
  std::size_t without_ = 0;
};

} // namespace io
} // namespace pcl_ext
