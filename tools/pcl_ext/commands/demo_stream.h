// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/recording/recording_status.h>

#include "clouds/cloud_sequence.h"
#include "options/encoding_options.h"
#include "streams/denoising.h"
#include "streams/stream_encoder.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Figures of a stream; sums over its frames. */
struct DemoReport {
  std::string name;
  EncodedSums encoded;
  double encode_ms = 0.0; ///< from the cloud on
  double decode_ms = 0.0;
  DenoisingReport denoising;
};

/** \brief What the demonstration does with each cloud of one sensor of the robot
 * cell. */
class DemoStream {
public:
  /** \param[in] options must outlive this
   * \param[in] sensor of the cell, 1 to 6
   * \param[in] frames of the stream
   * \param[in] threshold see Denoising
   */
  DemoStream(EncodingOptions& options,
             unsigned int sensor,
             std::size_t frames,
             std::uint32_t seed,
             const std::optional<float>& threshold);

  const std::string&
  name() const
  {
    return name_;
  }

  IntensityLaw
  law() const
  {
    return law_;
  }

  /** \brief Takes the next cloud through all stages: captures, encodes, decodes,
   * denoises.
   * \throws std::runtime_error if one fails, or what was decoded is not what was
   * encoded
   */
  void
  run(std::size_t frame);

  /** \brief Time of the last cloud. */
  recording::Time
  time() const
  {
    return std::chrono::microseconds(cloud_.header.stamp);
  }

  const std::vector<std::uint8_t>&
  bytes() const
  {
    return bytes_;
  }

  const pcl::PCLPointCloud2&
  decoded() const
  {
    return decoded_;
  }

  const pcl::PCLPointCloud2&
  denoised() const
  {
    return denoised_;
  }

  DemoReport
  report() const;

private:
  void
  denoise(const std::vector<noise::VoxelTruth>* truth);

  std::string name_;
  IntensityLaw law_;
  std::unique_ptr<clouds::CloudSequence> sequence_;
  StreamEncoder encoder_;
  io::FrameDecoder decoder_;
  Denoising denoising_;
  CellTruth truth_;
  double encode_ms_ = 0.0;
  double decode_ms_ = 0.0;
  // Of the last frame.
  pcl::PCLPointCloud2 cloud_;
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame voxels_;
  std::vector<float> intensities_;
  pcl::PCLPointCloud2 decoded_;
  pcl::PCLPointCloud2 denoised_;
};

} // namespace pcl_ext::tools
