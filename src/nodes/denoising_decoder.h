// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/voxel_changes.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Bytes of memory of the voxels and points of a frame. */
std::size_t
bytesOf(const io::VoxelFrame& frame);

/** \brief A frame that was decoded and denoised. */
struct DenoisedFrame {
  io::VoxelChanges* changes = nullptr; ///< null: all voxels are known
  std::size_t voxels = 0;              ///< that are left
  std::size_t all_voxels = 0;          ///< that there were
  OutlierRemovalStatus outliers;
  double resolution = 0.0;
  bool has_intensities = false;
  std::size_t points_outside_grid = 0;
};

/** \brief Decodes the frames of a stream and removes their noise: of each all voxels, or
 * what changes if that is less work.
 *
 * A frame takes begin(), decode(), one of the denoise functions if it was decoded, and
 * end() or discard(), in one thread, whose memory it uses. The settings are thread-safe;
 * all other members are for one thread at a time.
 */
class DenoisingDecoder {
public:
  DenoisingDecoder(float min_intensity, const io::DecoderLimits& limits);

  /** \brief As ReceivedStream::leaveVoxelsOut(). */
  void
  leaveVoxelsOut()
  {
    decoder_.setDecodesVoxels(false);
  }

  void
  setMinIntensity(float min_intensity)
  {
    min_intensity_ = min_intensity;
  }

  /** \brief Whether frames come without the layout of messages. */
  void
  setPacked(bool is_packed)
  {
    is_packed_ = is_packed;
  }

  /** \brief As ReceivedStream::setOutlierRemoval(). */
  void
  setOutlierRemoval(const std::optional<VoxelOutlierRemovalSettings>& settings);

  /** \brief Begins a frame, with the present settings, or throws.
   * \return true if its changes can be decoded without its other voxels
   */
  bool
  begin(const std::vector<std::uint8_t>& bytes);

  /** \brief Decodes the frame.
   * \param[in] by_changes only its changes, which begin() allows
   */
  io::CompressionStatus
  decode(const std::vector<std::uint8_t>& bytes, bool by_changes);

  /** \brief Denoises a frame, or throws.
   * \param[out] voxels those that are left
   */
  DenoisedFrame
  denoise(io::VoxelFrame& voxels);

  /** \brief Denoises the changes of a frame, or throws.
   * \param[in] voxels_before number of voxels that were left of the frame before
   */
  DenoisedFrame
  denoiseChanges(std::size_t voxels_before);

  /** \brief Ends a frame: releases memory that recent frames did not need. */
  void
  end();

  /** \brief Ends a frame that was decoded but not used. */
  void
  discard() noexcept;

  /** \brief Lists the voxels of the last frame that are not noise.
   * \return false if they are not known, or there is no memory for them */
  bool
  latestVoxels(io::VoxelFrame& voxels);

  /** \brief As latestVoxels(), in memory of the thread, which the next frame of any
   * stream uses; without voxels if they are not known. */
  const io::VoxelFrame&
  latestVoxels();

  /** \brief Of the last frame that was decoded. */
  const io::CodedFrameStatistics&
  statistics() const
  {
    return decoder_.statistics();
  }

  /** \brief Of the last frame that was decoded. */
  const std::optional<io::FrameStamp>&
  stamp() const
  {
    return decoder_.stamp();
  }

  /** \brief Bytes of the filter's history, for a number of voxels. */
  std::size_t
  filterBytes(std::size_t voxels) const
  {
    return outlier_removal_ ? VoxelOutlierRemoval::bytes_of_voxel * voxels : 0;
  }

  /** \brief Drops the filter's history. */
  void
  dropHistory() noexcept;

private:
  OutlierRemovalStatus
  removeOutliers(io::VoxelFrame& frame);

  void
  makeOutlierRemoval();

  io::FrameDecoder decoder_;
  std::atomic<float> min_intensity_;
  float frame_min_intensity_;   // of the frame that was begun
  float applied_min_intensity_; // to the last frame
  std::atomic<bool> is_packed_{false};
  bool is_plain_ = false;  // the voxels are the decoder's but for intensities
  std::size_t needed_ = 0; // bytes, of the frame that was begun
  std::optional<VoxelOutlierRemoval> outlier_removal_;

  std::mutex settings_mutex_; // guards the settings of the next filter
  std::optional<VoxelOutlierRemovalSettings> outlier_settings_;
  bool are_outlier_settings_new_ = false;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
