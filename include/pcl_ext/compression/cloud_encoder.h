// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/cloud_source.h>
#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/rate_control_status.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

/** \brief The time of a stamp of PCL, microseconds; any stamp is valid and clamped to the
 * largest time. */
inline std::chrono::nanoseconds
timeOfStamp(std::uint64_t microseconds)
{
  constexpr auto latest = std::chrono::duration_cast<std::chrono::microseconds>(
      (std::chrono::nanoseconds::max)());
  return std::chrono::microseconds(
      (std::min)(microseconds, static_cast<std::uint64_t>(latest.count())));
}

/** \brief What belongs to a cloud besides its points. */
struct CloudInfo {
  /** \brief Sensor -> grid, metres; for a depth law, rays and the temporal_filter. */
  WorldPose sensor_pose = WorldPose::Identity();

  /** \brief When the points were measured, by any clock, for the temporal_filter; none:
   * see TemporalVoxelFilter::filter(). */
  std::optional<std::chrono::nanoseconds> time = std::nullopt;

  /** \brief When the cloud came, by any clock, for max_rate. None: its time, or without
   * one that of the call. */
  std::optional<std::chrono::nanoseconds> arrival = std::nullopt;

  /** \brief Stamp and frame_id to be coded; none: the frame has none. Version1 only. */
  std::optional<FrameStamp> stamp = std::nullopt;

  /** \brief Layout of the cloud's message, which I-frames tell; null: they do not.
   * Another one than before makes an I-frame. Version1 only. */
  std::shared_ptr<const MessageLayout> layout = nullptr;
};

class CloudStages;

/** \brief Encodes the clouds of one stream: points -> voxels -> bytes.
 *
 * Voxel (i, j, k) covers [i d_v, (i+1) d_v) x ... from the origin of the grid, computed
 * in double precision from the coordinates. Points more than 2^20 voxels from the
 * origin, outside the fixed box, or not finite are counted and left out. The origin is
 * the world's, unless the settings have another one or clouds lie further out: then it
 * is a corner of a voxel of the world's origin amid the points. Without a fixed box the
 * grid is fitted to the points. It grows where later points require it, which takes an
 * I-frame, and is fitted again where an I-frame is due; so is the scale of native
 * intensities.
 *
 * Does not need PCL. An instance is for one stream and one thread; one that was moved
 * from may only be destroyed or assigned to. A cloud takes time and memory in
 * proportion to its number of points, for any coordinates and intensities.
 */
class PCL_EXT_CODEC_EXPORT CloudEncoder {
public:
  /** \brief An outlier removal of the stream's CloudSource, which max_rate may make
   * stronger. */
  struct NoiseRemoval {
    std::optional<float> min_log_odds; ///< at first; none: it is off
  };

  /** \brief An encoder at the start of a stream.
   * \param[in] settings checked here; see settingsStatus()
   * \param[in] unit unit of the point intensities; those of Share are 0 to 1
   * \param[in] depth_law law of the point intensities, if they follow one, see
   * depthLawOf()
   * \param[in] noise_removal if the source removes outliers as takeStep() says
   */
  CloudEncoder(const EncoderSettings& settings,
               IntensityUnit unit,
               const std::optional<DepthLaw>& depth_law = std::nullopt,
               const std::optional<NoiseRemoval>& noise_removal = std::nullopt);
  ~CloudEncoder();
  CloudEncoder(CloudEncoder&&) noexcept;
  CloudEncoder&
  operator=(CloudEncoder&&) noexcept;

  /** \brief Ok, or InvalidSettings with the field and its value; encode() and voxelize()
   * then return the same. */
  const CompressionStatus&
  settingsStatus() const;

  /** \brief The settings in force: those of the rate control's step. */
  const EncoderSettings&
  settings() const;

  /** \brief Changes the resolution; the next frame is an I-frame, and the rate control
   * begins again.
   * \param[in] resolution voxel edge, metres; checked with the other settings
   * \param[in] depth_law the law at this resolution, if there is one
   */
  void
  setResolution(double resolution, const std::optional<DepthLaw>& depth_law);

  /** \brief Makes the next frame an I-frame, for a new receiver or one that lost a
   * frame. */
  void
  requestIFrame();

  /** \brief Changes max_rate as the link does, bits a second above 0; only where there is
   * one. */
  void
  setMaxRate(double bits_per_second);

  /** \brief What the rate control chose for the last cloud, and why. */
  RateControlStatus
  rateControlStatus() const;

  /** \brief Encodes the next cloud.
   *
   * What the functions of the source throw is passed on, except std::bad_alloc, which is
   * OutOfMemory; the next frame is then an I-frame.
   * \param[in] source of the cloud
   * \param[in] info what belongs to it
   * \param[out] bytes the frame; empty unless the status is Ok
   * \return Ok; InvalidSettings; InvalidInput for a view without coordinates, or with a
   * stride that is none, for a cloud that the temporal_filter or the format refuses; what
   * the source returns; LeftOut; OutOfMemory, after which the next frame is an I-frame.
   * Ok has a message with numbers (Status::hasWarning) if points were left out, lie
   * behind the sensor, or have an intensity or colour that the scale or the format cannot
   * hold, and if decoders with the decoder_limits of the settings refuse the frame
   */
  CompressionStatus
  encode(CloudSource& source, const CloudInfo& info, std::vector<std::uint8_t>& bytes);

  /** \brief The same for a cloud in memory, whose depth law does not change with the
   * resolution.
   * \param[in] points in the coordinates of the grid
   * \param[in] points_behind_sensor for the statistics, see setIntensities()
   */
  CompressionStatus
  encode(const PointView& points,
         const CloudInfo& info,
         std::vector<std::uint8_t>& bytes,
         std::size_t points_behind_sensor = 0);

  /** \brief The voxels that encode() would code for a cloud, before any filter, without a
   * frame in the stream.
   * \param[in] points in the coordinates of the grid
   * \param[in] sensor_pose see CloudInfo
   * \param[out] frame the voxels; its memory is reused; empty unless the status is Ok
   */
  CompressionStatus
  voxelize(const PointView& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  /** \brief The voxels of the last frame that was encoded; with its points if it was
   * coded as these, which then are put into voxels by the first call; those outside the
   * grid are left out and counted (FramePoints::outside_grid). Throws std::bad_alloc
   * without memory for them. */
  const VoxelFrame&
  frame() const;

  /** \brief Columns and rows of the last cloud as it is decoded. */
  ImageSize
  decodedSize() const;

  /** \brief Figures of the last frame that was encoded. */
  const FrameStatistics&
  statistics() const;

private:
  std::unique_ptr<CloudStages> stages_;
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
