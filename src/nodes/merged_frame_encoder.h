// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/nodes/central_node.h>
#include <pcl_ext/nodes/stream_health.h>

#include "stream/frame_encoder.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Encodes what CentralNode::merge() returns as a stream as any other, which
 * another CentralNode may merge with those of other centres.
 *
 * Voxels and intensities come back as they were merged, whatever they are sums of, while
 * intensities are multiples of a step and at most 65535 of it. A centre of centres
 * thus has the voxels and intensities of one centre with all streams. For one thread
 * at a time.
 */
class PCL_EXT_EXPORT MergedFrameEncoder {
public:
  /** \param[in] stream effort, i_frame_rate, i_frame_every and
   * first_frame_number are used */
  explicit MergedFrameEncoder(const io::StreamSettings& stream);

  /** \brief Makes the next frame an I-frame. */
  void
  requestIFrame()
  {
    encoder_.requestIFrame();
  }

  /** \brief Encodes a merged frame.
   * \param[in] merged from CentralNode::merge()
   * \param[in] stamp in the frame: the time as of which it was merged; 0 if
   * negative
   * \param[in] frame_id coordinate frame of the voxels, up to 1024 bytes
   * \param[out] bytes the frame; empty unless the status is Ok
   * \return as FrameEncoder::encode
   */
  io::CompressionStatus
  encode(const io::VoxelFrame& merged,
         Time stamp,
         const std::string& frame_id,
         std::vector<std::uint8_t>& bytes);

  /** \brief Gives all voxels of a merged frame. */
  using Voxels = std::function<const io::VoxelFrame&()>;

  /** \brief Encodes a merged frame by how it differs from the one that was encoded last,
   * in less time where that is little; the bytes are the same.
   * \param[in] changes from CentralNode::mergeChanges()
   * \param[in] voxels called where the frame is coded by all of its voxels
   */
  io::CompressionStatus
  encode(const MergedChanges& changes,
         const Voxels& voxels,
         Time stamp,
         const std::string& frame_id,
         std::vector<std::uint8_t>& bytes);

  /** \brief Figures of the last frame. */
  const io::CodedFrameStatistics&
  statistics() const
  {
    return encoder_.statistics();
  }

private:
  const io::VoxelFrame&
  onHeldScale(const io::VoxelFrame& merged, bool is_i_frame_due);

  const io::VoxelChanges*
  onHeldScale(const io::VoxelChanges& changes);

  io::FrameEncoder encoder_;
  io::IntensityScale held_; // of the last frame
  std::size_t number_ = 0;  // of the merged frame that was encoded last; 0: unknown
  // With the scale that is held; keep their memory.
  io::VoxelFrame frame_;
  io::VoxelChanges changes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
