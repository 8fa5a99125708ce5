// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/impl/saturated_float.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/rigid_pose.h>
#include <pcl_ext/status.h>

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \addtogroup io
 * @{ */

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

/** \brief Where the depths of points are measured from, and along which axis. Plain
 * numbers, as Eigen's expressions take long to compile. */
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

/** \brief The axis of a sensor.
 * \param[in] sensor_pose sensor -> cloud, metres
 */
PCL_EXT_CODEC_EXPORT DepthAxis
depthAxisOf(const WorldPose& sensor_pose);

/** \brief Computes the intensities of a cloud's points by an intensity model; see the
 * paper, equations 1 to 3.
 * \param[in] model the intensity model
 * \param[in] axis of the sensor, in the coordinates of the cloud; used if the model uses
 * the depth
 * \param[in] native_intensity called with the index of a point
 * \param[out] intensities memory for those of all points; must outlive the view
 * \param[in,out] points the cloud; its intensities are set
 * \return number of points of negative depth, whose intensity is 0
 */
template <typename IntensityModelT, typename NativeIntensityT>
std::size_t
setIntensities(const IntensityModelT& model,
               const DepthAxis& axis,
               NativeIntensityT native_intensity,
               std::vector<float>& intensities,
               PointView& points)
{
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

/** \brief The points of a cloud that a CloudSource has opened. */
struct OpenedCloud {
  PointView view;                       ///< all points, in the coordinates of the grid
  std::size_t points_behind_sensor = 0; ///< of the view, see setIntensities()

  /** \brief The points in batches, in place of the view; null: those of the view. */
  PointBatches* batches = nullptr;

  /** \brief Where the points are cropped to a box, all of them, for the temporal_filter,
   * see TemporalVoxelFilter::seeBeyond(); null: they are not. */
  PointBatches* uncropped = nullptr;
  BoundingBox crop_box; ///< with uncropped
};

/** \brief The clouds of a stream, as CloudEncoder asks for them. */
class PCL_EXT_CODEC_EXPORT CloudSource {
public:
  virtual ~CloudSource();

  /** \brief Takes over another step of the rate control, before a cloud is opened.
   * \param[in] settings of the step: resolution, origin, effort, temporal_filter and
   * bits may be others than before
   * \param[in] min_log_odds of an outlier removal; none: no removal
   * \return the law of the intensities at the resolution, if they follow one
   */
  virtual std::optional<DepthLaw>
  takeStep(const EncoderSettings& settings,
           const std::optional<float>& min_log_odds) = 0;

  /** \brief Opens the cloud: its points, moved, cropped and with their intensities. Not
   * called for a cloud that is left out.
   * \param[out] cloud must stay as it is until it is encoded
   * \return Ok, or why the cloud cannot be encoded
   */
  virtual CompressionStatus
  open(OpenedCloud& cloud) = 0;

  /** \brief Whether removeNoise() may remove voxels of the cloud that is open, which then
   * has to be coded as voxels; not without an override. */
  virtual bool
  removesNoise() const;

  /** \brief Removes noise from the voxels; none without an override. */
  virtual void
  removeNoise(VoxelFrame& frame);
};

/** @} */

} // namespace pcl_ext::PCL_EXT_ABI::io
