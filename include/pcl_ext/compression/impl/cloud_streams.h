// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The part of OctreePointCloudIntensityCompression that does not depend on its
 * template arguments.
 */
#pragma once

#include <pcl_ext/compression/cloud_source.h>
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/rate_control_status.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <pcl/PCLHeader.h>

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::detail {

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

  CloudStreams(CloudStreams&&) noexcept;
  CloudStreams&
  operator=(CloudStreams&&) noexcept;
  ~CloudStreams();

  const IntensityCompressionSettings&
  settings() const;

  /** \brief Statistics of the frame that was encoded or decoded last. */
  const FrameStatistics&
  statistics() const;

  /** \brief The frame that was encoded or decoded last; one that has its points may be
   * without voxels. */
  const VoxelFrame&
  frame() const;

  /** \brief The same with voxels, which are made now if there are none. */
  const VoxelFrame&
  voxelFrame() const;

  void
  setResolution(double resolution, const std::optional<DepthLaw>& model_law);

  void
  requestIFrame();

  /** \brief InvalidSettings, or InvalidInput without a cloud. */
  CompressionStatus
  checkEncoding(bool has_cloud) const;

  /** \brief OutputFailed for an output that cannot be written. */
  static CompressionStatus
  checkOutput(const std::ostream& output);

  /** \brief Voxel edge of the next frame, metres. */
  double
  resolution() const;

  /** \brief See CloudEncoder. */
  void
  setMaxRate(double bits_per_second);

  RateControlStatus
  rateControlStatus() const;

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
  bytes();

  /** \brief Decodes the next frame. Sets the input's end and fail bits at its end, and
   * its bad bit where it cannot be read, as a read does.
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

  struct Members; // a type of its own, as the class is included by many programs
  std::unique_ptr<Members> members_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::detail
