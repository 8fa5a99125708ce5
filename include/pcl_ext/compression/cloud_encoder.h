// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/frame_statistics.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/saturated_float.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief The depth law of an intensity model, for the encoder; none if its
 * intensities are not a power of the depth. Decoded shares are 255 for a full voxel
 * face. */
template <typename IntensityModelT>
std::optional<DepthLaw>
depthLawOf([[maybe_unused]] const IntensityModelT& model)
{
  constexpr unsigned int exponent =
      pcl_ext::detail::DepthExponent<IntensityModelT>::value;
  if constexpr (exponent != 0)
    return DepthLaw{exponent, model.cutOffDepth(), 255.0};
  else
    return std::nullopt;
}

namespace detail {

/** \brief Where depths are measured from, and along which axis. Plain numbers, as
 * Eigen's expressions take long to compile. */
struct DepthAxis {
  std::array<double, 3> sensor;   ///< position, metres
  std::array<float, 3> direction; ///< the optical axis, of length 1

  /** \brief The depth of a point, metres. */
  template <typename CoordinateT>
  float
  depthOf(const CoordinateT* point) const
  {
    // The difference first: it is exact far from the origin, products are not.
    std::array<float, 3> terms{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      terms[axis] =
          direction[axis] * pcl_ext::detail::saturatedFloat(
                                static_cast<double>(point[axis]) - sensor[axis]);
    return terms[0] + (terms[1] + terms[2]);
  }
};

/** \brief The axis of a sensor, sensor -> cloud. */
PCL_EXT_CODEC_EXPORT DepthAxis
depthAxisOf(const WorldPose& sensor_pose);

} // namespace detail

/** \brief Computes the intensities of a cloud's points by an intensity model; see the
 * paper, equations 1 to 3.
 * \param[in] model the intensity model
 * \param[in] sensor_pose sensor -> cloud, metres; used if the model uses the depth
 * \param[in] native_intensity called with the index of a point
 * \param[out] intensities memory for those of all points; must outlive the view
 * \param[in,out] points the cloud; its intensities are set
 * \return number of points of negative depth, whose intensity is 0
 */
template <typename IntensityModelT, typename NativeIntensityT>
std::size_t
setIntensities(const IntensityModelT& model,
               const WorldPose& sensor_pose,
               NativeIntensityT native_intensity,
               std::vector<float>& intensities,
               PointView& points)
{
  const detail::DepthAxis axis = detail::depthAxisOf(sensor_pose);
  intensities.resize(points.count);
  std::size_t behind_sensor = 0;
  const auto set_all = [&](const auto* point) {
    for (std::size_t i = 0; i < points.count;
         ++i, point = detail::atOffset(point, points.coordinate_stride)) {
      float depth = 0.0f;
      if constexpr (IntensityModelT::uses_depth) {
        depth = axis.depthOf(point);
        behind_sensor += depth < 0.0f ? 1 : 0;
      }
      intensities[i] = model(depth, native_intensity(i));
    }
  };
  if (points.double_coordinates != nullptr)
    set_all(points.double_coordinates);
  else
    set_all(points.coordinates);
  points.intensities = intensities.data();
  points.intensity_stride = sizeof(float);
  return behind_sensor;
}

/** \brief Encodes the clouds of one stream: points as arrays -> voxels -> bytes.
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
  /** \brief An encoder at the start of a stream.
   * \param[in] settings checked here; see settingsStatus()
   * \param[in] unit unit of the point intensities; those of Share are 0 to 1
   * \param[in] depth_law law of the point intensities, if they follow one, see
   * depthLawOf()
   */
  CloudEncoder(const EncoderSettings& settings,
               IntensityUnit unit,
               const std::optional<DepthLaw>& depth_law = std::nullopt);
  ~CloudEncoder();
  CloudEncoder(CloudEncoder&&) noexcept;
  CloudEncoder&
  operator=(CloudEncoder&&) noexcept;

  /** \brief Ok, or InvalidSettings with the field and its value; voxelize() and
   * encode() then return the same. */
  const CompressionStatus&
  settingsStatus() const;

  /** \brief The settings in force. */
  const EncoderSettings&
  settings() const;

  /** \brief Changes what RateControl does: resolution, origin, use_coordinate_step,
   * effort, temporal_filter, temporal_filter_holds, intensity_curve and intensity_bits.
   * The next frame is an I-frame, unless only the temporal filter changes.
   * \param[in] settings checked here; of others than these nothing is taken
   * \param[in] depth_law the law at their resolution, if there is one
   */
  void
  setSettings(const EncoderSettings& settings,
              const std::optional<DepthLaw>& depth_law);

  /** \brief True if the next frame will be an I-frame for any cloud. */
  bool
  isIFrameDue() const;

  /** \brief Takes the last frame out of the stream, see FrameEncoder. */
  void
  dropLastFrame();

  /** \brief Makes the next frame an I-frame, for a new receiver or one that lost a
   * frame. */
  void
  requestIFrame();

  /** \brief The first step of encoding: points -> voxels, from which some may be
   * removed before the next one.
   * \param[in] points the cloud, in the coordinates of the grid
   * \param[in] sensor_pose sensor -> grid, metres; for a depth law and the
   * temporal_filter
   * \param[out] frame the voxels; its memory is reused; empty unless the status is Ok
   * \param[in] points_behind_sensor for the statistics, see setIntensities()
   * \return Ok; InvalidSettings; InvalidInput for a view without coordinates, or with a
   * stride that is none; OutOfMemory, after which the next frame is an I-frame
   */
  CompressionStatus
  voxelize(const PointView& points,
           const WorldPose& sensor_pose,
           VoxelFrame& frame,
           std::size_t points_behind_sensor = 0);

  /** \brief The same for a cloud in batches. What their functions throw is passed on,
   * except std::bad_alloc, which is OutOfMemory; the next frame is then an I-frame. */
  CompressionStatus
  voxelize(PointBatches& points, const WorldPose& sensor_pose, VoxelFrame& frame);

  /** \brief Shows the temporal_filter, if it is on, the points of the next cloud before
   * it is cropped; see TemporalVoxelFilter::seeBeyond(). Before voxelize(), which does so
   * itself for the bounding_box of the settings.
   * \param[in] points all of the cloud, in the coordinates of the grid
   * \param[in] box to which the cloud will be cropped
   * \param[in] sensor_pose as for voxelize()
   */
  void
  seeBeyond(PointBatches& points, const BoundingBox& box, const WorldPose& sensor_pose);

  /** \brief The second step: applies the temporal_filter of the settings, if it is on.
   * \param[in,out] frame of the last voxelized cloud, as isConsistent() demands; once
   * for each cloud, as the filter learns from it
   * \param[in] time of the cloud, by any clock; none: see TemporalVoxelFilter::filter()
   * \return Ok; InvalidInput for a frame with numbers of points; OutOfMemory, after
   * which the next frame is an I-frame
   */
  CompressionStatus
  filterOverTime(VoxelFrame& frame,
                 const std::optional<std::chrono::nanoseconds>& time = std::nullopt);

  /** \brief The last step: voxels -> bytes.
   * \param[in] frame the voxels
   * \param[in] stamp see FrameEncoder::encode
   * \param[out] bytes the frame; empty unless the status is Ok
   * \return InvalidSettings, or what FrameEncoder::encode returns. Ok has a message
   * with numbers (Status::hasWarning) if points were left out of the last voxelized
   * cloud, lie behind the sensor, or have an intensity or colour that the scale or the
   * format cannot hold, and if decoders with the decoder_limits of the settings refuse
   * the frame
   */
  CompressionStatus
  encode(const VoxelFrame& frame,
         const std::optional<FrameStamp>& stamp,
         std::vector<std::uint8_t>& bytes);

  /** \brief Figures of the last frame that was encoded. */
  const FrameStatistics&
  statistics() const;

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace io
} // namespace pcl_ext
