// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>

#include "codec/changes/change_coder.h"
#include "codec/payload_coder.h"
#include "codec/scan/scan_coder.h"
#include "codec/supplement/supplement.h"
#include "stream/version1_header.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief What both ends of a stream of version 1 know of its frames, to which the next
 * frame refers (doc/bitstream.md). After the same frames those of an encoder and of a
 * decoder are the same. */
struct StreamState {
  std::uint32_t frame_number = 0;
  std::uint32_t checksum = 0;
  std::uint64_t bytes_since_i_frame = 0; ///< payloads, with that of the I-frame
  Effort effort = Effort::Balanced;
  VoxelGrid grid;
  IntensityScale intensity_scale;
  std::optional<DepthModel> depth_model;
  supplement::Content content;
  std::vector<FieldDescription> fields;
  std::array<std::int32_t, 3> viewpoint{};
  scan::ScanLayout scan;
  std::shared_ptr<const MessageLayout> layout;
  std::string frame_id;
  std::uint64_t stamp = 0;

  // The histories of voxels and points.
  PayloadCoders coders;
  std::unique_ptr<changes::ChangeCoder> changes;           ///< made when it is needed
  std::unique_ptr<supplement::SupplementCoder> supplement; ///< likewise
  std::unique_ptr<scan::ScanCoder> scans;                  ///< likewise

  /** \brief Whether the next frame may be one of changes. */
  bool
  mayBeFollowedByChanges() const
  {
    return changes && changes->hasLastFrame();
  }

  /** \brief The coder of supplements. */
  supplement::SupplementCoder&
  supplementCoder()
  {
    if (!supplement)
      supplement = std::make_unique<supplement::SupplementCoder>();
    return *supplement;
  }

  /** \brief The coder of scans. */
  scan::ScanCoder&
  scanCoder()
  {
    if (!scans)
      scans = std::make_unique<scan::ScanCoder>();
    return *scans;
  }

  /** \brief Sets what the header of a P-frame does not have, as it is that of the frames
   * before. The bits of a colour are those of the I-frame. */
  void
  complete(Version1Header& header) const;

  /** \brief Stamp of a frame. */
  std::uint64_t
  stampOf(const Version1Header& header) const
  {
    return (header.is_i_frame ? 0 : stamp) +
           static_cast<std::uint64_t>(header.stamp.value_or(0));
  }

  /** \brief Change of a stamp since the last frame, modulo 2^64. */
  std::int64_t
  stampChange(std::uint64_t next) const
  {
    return static_cast<std::int64_t>(next - stamp);
  }

  /** \brief Copies a frame, if one of changes may follow it; before learn().
   * \param[in] header of the frame
   */
  void
  prepareChanges(const Version1Header& header, const VoxelFrame& frame);

  /** \brief Learns a frame, but for its voxels.
   * \param[in,out] header complete; texts and lists are swapped with the last ones
   * \param[in] frame_checksum of the frame
   */
  void
  learn(Version1Header& header, std::uint32_t frame_checksum) noexcept;

  /** \brief Forgets the histories: an I-frame has to follow. */
  void
  forgetVoxels() noexcept;

  /** \brief Releases memory that the histories do not need. */
  void
  releaseMemory();

private:
  bool keeps_frame_ = false; // prepareChanges() has copied it
};

} // namespace pcl_ext::PCL_EXT_ABI::io
