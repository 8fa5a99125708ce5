// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/scan/scan_frame.h"
#include "stream/frame_encoder.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Decides for a stream whether clouds that have a sensor's order are coded as
 * scans or as voxels: by what takes fewer bytes. In trials they are coded as both. */
class ScanChoice {
public:
  explicit ScanChoice(const EncoderSettings& settings) : settings_(settings) {}

  /** \brief Whether the next cloud may be coded as a scan. */
  bool
  mayBeScan(bool is_i_frame)
  {
    const bool may_be =
        is_scan_ || settings_.keep_order || (is_i_frame && untried_i_frames_ == 0);
    is_tried_ = may_be && is_i_frame;
    return may_be;
  }

  /** \brief Whether the cloud of an I-frame is to be coded as voxels without a trial, by
   * a part of its points. */
  bool
  prefersVoxels(const scan::ScanFrame& scan);

  /** \brief Takes into account what a frame takes as a scan.
   * \param[in] bytes as a scan
   * \param[in] is_i_frame so coded
   * \return whether it is to be voxelized too, for takesVoxels(), as voxels may take
   * fewer bytes
   */
  bool
  wantsVoxels(std::size_t bytes, bool is_i_frame);

  /** \brief Takes into account what the frame takes as voxels.
   * \param[in] voxels of the same cloud
   * \param[in] bytes as a scan
   * \param[in] is_i_frame so coded
   * \return whether the frame is to be coded as voxels instead
   */
  bool
  takesVoxels(const VoxelFrame& voxels, std::size_t bytes, bool is_i_frame);

  /** \brief Whether a cloud that is not tried has so many more points than the last one
   * that was, as of a camera that was covered, that it should be an I-frame and tried. */
  bool
  triesAgain(std::size_t points);

  /** \brief Follows a frame that was coded.
   * \param[in] points of its cloud
   * \return whether the next one should be an I-frame, as rays no longer fit or voxels
   * take fewer bytes
   */
  bool
  follow(const CodedFrameStatistics& coded, std::size_t points);

  /** \brief Takes scans, where there are some, until the next I-frame: voxels cannot hold
   * all points. */
  void
  takeScan()
  {
    take(true, 0);
  }

private:
  /** \brief Bytes of frames of one trial so far. */
  struct TriedBytes {
    std::size_t i_frame = 0;
    // P-frames in the second half of the trial: the first ones have little history.
    std::size_t p_frames = 0;
  };

  struct Trial {
    explicit Trial(const EncoderSettings& settings)
    : encoder(settings.format, settings.i_frame_rate, settings.effort)
    {}

    FrameEncoder encoder; // of the voxels
    unsigned int p_frames = 0;
    TriedBytes as_scan;
    TriedBytes as_voxels;
  };

  double
  periodBytes(std::size_t i_frame, std::size_t p_frames, unsigned int count) const;

  bool
  mayTakeVoxels(std::size_t as_scan) const;

  void
  take(bool scan, unsigned int untried_i_frames);

  bool
  addPFrame(std::size_t as_scan, std::size_t as_voxels);

  EncoderSettings settings_;
  bool is_scan_ = false;              // by the last trial
  unsigned int untried_i_frames_ = 0; // that follow
  bool is_sampled_ = false;           // a part of the points has told what to take
  bool is_tried_ = false; // the cloud is that of an I-frame that may be a scan
  // Of the last one that was.
  std::size_t tried_points_ = std::numeric_limits<std::size_t>::max();
  double i_frame_density_ = 0.0; // bytes of a point
  double tried_density_ = 0.0;   // likewise, of the last trial
  bool wants_voxels_ = false;
  std::unique_ptr<Trial> trial_; // while it lasts
  std::vector<std::uint8_t> bytes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
