// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/nodes/impl/health_report.h>
#include <pcl_ext/nodes/impl/node_parameters.h>
#include <pcl_ext/nodes/stream_health.h>
#include <pcl_ext/status.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief The outcome of a frame that a CloudReceiver received. */
struct ReceiverStatus : io::CompressionStatus {
  using io::CompressionStatus::CompressionStatus;

  ReceiverStatus(const io::CompressionStatus& status, bool wants)
  : io::CompressionStatus(status), wants_i_frame(wants)
  {}

  /** \brief To be requested from the sender, see ReceivedFrame::wants_i_frame. */
  bool wants_i_frame = false;
};

/** \brief The receiving end of a transport of clouds, as a plugin of ROS 2's
 * point_cloud_transport needs it: frames of one stream in, voxels without noise out.
 * Independent of ROS; all members are thread-safe.
 *
 * A frame that needs one that was lost is not decoded: there is never a wrong cloud.
 * The next I-frame is decoded again. Any bytes are safe, see doc/robustness.md.
 */
class PCL_EXT_EXPORT CloudReceiver {
public:
  /** \param[in] limits of decoding */
  explicit CloudReceiver(const io::DecoderLimits& limits = io::DecoderLimits());
  ~CloudReceiver();
  CloudReceiver(const CloudReceiver&) = delete;
  CloudReceiver&
  operator=(const CloudReceiver&) = delete;

  /** \brief Sets what is noise, from the next frame on. Other settings of the outlier
   * removal than before clear its history. */
  void
  setNoise(const NoiseSettings& noise);

  /** \brief Decodes the stream's next frame. Does not throw.
   * \param[in] bytes one frame of any format
   * \param[in] stamp time of the cloud, for the latency
   * \param[out] voxels without noise, or the points only where the frame has these and
   * nothing is filtered, see forEachPoint(); empty unless the status is Ok
   */
  ReceiverStatus
  receive(std::vector<std::uint8_t> bytes,
          std::optional<Time> stamp,
          io::VoxelFrame& voxels);

  /** \brief Counts a frame that was not handed to receive(): its format is another
   * one. */
  void
  countLeftOut();

  /** \brief The time of an arrival is that of a steady clock. */
  ReceiverHealth
  health() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
