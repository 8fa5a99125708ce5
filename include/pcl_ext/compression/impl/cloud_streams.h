// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The part of OctreePointCloudIntensityCompression that does not depend on its
 * template arguments.
 */
#pragma once

#include <pcl_ext/compression/cloud_encoder.h>
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <pcl/PCLHeader.h>

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace pcl_ext {
namespace io {
namespace detail {

/** \brief One stream of clouds in each direction, written to and read from
 * iostreams. */
class PCL_EXT_EXPORT CloudStreams {
public:
  /** \param[in] settings checked here; if they are invalid encode() fails, and decode()
   * if the limits are
   * \param[in] model_law depth law of the intensity model, if its intensities depend on
   * the depth; it replaces that of the settings
   * \param[in] unit unit of the point intensities
   */
  CloudStreams(const IntensityCompressionSettings& settings,
               const std::optional<DepthLaw>& model_law,
               IntensityUnit unit);

  const IntensityCompressionSettings&
  settings() const
  {
    return settings_;
  }

  /** \brief Statistics of the frame that was encoded or decoded last. */
  const FrameStatistics&
  statistics() const
  {
    return statistics_;
  }

  /** \brief The voxels that were encoded or decoded last. */
  const VoxelFrame&
  frame() const
  {
    return has_encoded_ ? encoder_.frame() : frame_;
  }

  void
  setResolution(double resolution, const std::optional<DepthLaw>& model_law);

  void
  requestIFrame()
  {
    encoder_.requestIFrame();
  }

  /** \brief InvalidSettings, or InvalidInput without a cloud. */
  CompressionStatus
  checkEncoding(bool has_cloud) const;

  /** \brief OutputFailed for an output that cannot be written. */
  static CompressionStatus
  checkOutput(const std::ostream& output);

  /** \brief Voxel edge of the next frame, metres. */
  double
  resolution() const
  {
    return encoder_.settings().resolution;
  }

  /** \brief See CloudEncoder. */
  void
  setMaxRate(double bits_per_second)
  {
    encoder_.setMaxRate(bits_per_second);
  }

  RateControlStatus
  rateControlStatus() const
  {
    return encoder_.rateControlStatus();
  }

  /** \brief Encodes the next cloud. The first warning of each kind is printed on PCL's
   * console.
   * \param[in] source of the cloud
   * \param[in] sensor_pose sensor -> cloud, metres
   * \param[in] header of the cloud; coded if the settings say so
   * \param[out] bytes the frame; empty unless the status is Ok
   * \return as CloudEncoder::encode
   */
  CompressionStatus
  encode(CloudSource& source,
         const SensorPose& sensor_pose,
         const pcl::PCLHeader& header,
         std::vector<std::uint8_t>& bytes);

  /** \brief Writes a frame.
   * \param[in] bytes the frame
   * \param[in,out] output may be set to throw
   */
  static CompressionStatus
  write(const std::vector<std::uint8_t>& bytes, std::ostream& output);

  /** \brief Memory for the bytes of a frame that is written to an output. */
  std::vector<std::uint8_t>&
  bytes()
  {
    return bytes_;
  }

  /** \brief Decodes the next frame. Sets the input's end and fail bits at its end, as a
   * read does.
   * \param[in,out] input may be set to throw
   */
  CompressionStatus
  decode(std::istream& input);

  /** \brief Decodes the first frame in memory. */
  CompressionStatus
  decode(const std::uint8_t* bytes, std::size_t size);

  /** \brief Sets stamp and frame_id to those of the last decoded frame, if it has
   * them. */
  void
  copyStampTo(pcl::PCLHeader& header) const;

  /** \brief Prints the statistics through PCL's console, if the settings say so. */
  void
  showStatistics(const char* title) const;

private:
  void
  printWarning(const CompressionStatus& status);

  CompressionStatus
  finishDecoding(CompressionStatus status);

  IntensityCompressionSettings settings_;
  CompressionStatus limits_status_;
  CompressionStatus settings_status_;
  CloudEncoder encoder_;
  FrameDecoder decoder_;
  FrameStatistics statistics_;
  bool has_encoded_ = false; // and not decoded last
  // Members so that their memory is reused.
  VoxelFrame frame_; // that was decoded
  CloudInfo info_;   // of the encoded cloud
  std::vector<std::uint8_t> bytes_;
  std::set<std::string> printed_warnings_; // without their numbers
};

} // namespace detail
} // namespace io
} // namespace pcl_ext
