// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What OctreePointCloudIntensityCompression encodes, as sources of CloudEncoder.
 */
#pragma once

#include <pcl_ext/compression/cloud_source.h>
#include <pcl_ext/compression/impl/cloud_streams.h>
#include <pcl_ext/compression/impl/octree_leaves.h>
#include <pcl_ext/compression/impl/point_fields.h>
#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/intensity/intensity_model.h>

#include <pcl/point_cloud.h>

#include <cstddef>
#include <optional>
#include <type_traits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::detail {

/** \brief True if the intensity of every point is 1, which need not be computed. */
template <typename IntensityModelT>
constexpr bool counts_points = false;

template <typename SensorT>
constexpr bool counts_points<IntensityModel<SensorT, CountLaw>> = true;

template <typename IntensityModelT>
constexpr bool is_native = false;

template <typename SensorT>
constexpr bool is_native<IntensityModel<SensorT, NativeLaw>> = true;

template <typename PointT, typename = void>
constexpr bool has_float_intensity = false;

template <typename PointT>
constexpr bool has_float_intensity<
    PointT,
    std::enable_if_t<std::is_same<decltype(PointT::intensity), float>::value>> = true;

/** \brief Takes the points' own intensities where the model keeps them as they are.
 * Returns false if they have to be computed. */
template <typename IntensityModelT, typename PointT>
bool
useOwnIntensities([[maybe_unused]] const IntensityModelT& model,
                  [[maybe_unused]] const pcl::PointCloud<PointT>& cloud,
                  [[maybe_unused]] PointView& view)
{
  if constexpr (is_native<IntensityModelT> && has_float_intensity<PointT>)
    if (model.law().scale == 1.0f) {
      view = pointViewWithIntensities(cloud);
      return true;
    }
  return false;
}

/** \brief A source of clouds whose intensities have the unit of a model. */
template <typename IntensityModelT>
class ModelSource : public CloudSource {
public:
  /** \brief Both must outlive this. */
  ModelSource(const IntensityModelT& model, const CloudStreams& streams)
  : model_(model), streams_(streams)
  {}

  std::optional<DepthLaw>
  takeStep(const EncoderSettings& step,
           const std::optional<float>& /*min_log_odds*/) override
  {
    const auto law = depthLawOf(modelAtResolution(model_, step.resolution));
    return law ? law : streams_.settings().depth_law;
  }

protected:
  /** \brief The model for voxels of the step. */
  IntensityModelT
  modelOfStep() const
  {
    const double resolution = streams_.resolution();
    return resolution == streams_.settings().resolution
               ? model_
               : modelAtResolution(model_, resolution);
  }

  const CloudStreams&
  streams() const
  {
    return streams_;
  }

private:
  const IntensityModelT& model_;
  const CloudStreams& streams_;
};

/** \brief The points of a cloud. */
template <typename PointT, typename IntensityModelT>
class PointSource : public ModelSource<IntensityModelT> {
public:
  /** \param[in] cloud to encode
   * \param[in] axis of the sensor
   * \param[in,out] intensities memory
   */
  PointSource(const IntensityModelT& model,
              const CloudStreams& streams,
              const pcl::PointCloud<PointT>& cloud,
              const DepthAxis& axis,
              std::vector<float>& intensities)
  : ModelSource<IntensityModelT>(model, streams)
  , cloud_(cloud)
  , axis_(axis)
  , intensities_(intensities)
  {}

  CompressionStatus
  open(OpenedCloud& opened) override
  {
    PointView& view = opened.view;
    view = pointViewOf(cloud_);
    const IntensityModelT model = this->modelOfStep();
    if (IntensityModelT::unit != IntensityUnit::None &&
        !counts_points<IntensityModelT> && !cloud_.empty() &&
        !useOwnIntensities(model, cloud_, view))
      opened.points_behind_sensor = setIntensities(
          model,
          axis_,
          [this](std::size_t i) { return nativeIntensity(cloud_[i], 0.0f); },
          intensities_,
          view);
    if (cloud_.isOrganized() &&
        std::size_t{cloud_.width} * cloud_.height == cloud_.size())
      view.image = {cloud_.width, cloud_.height};
    // With the points the field ring, too, whose order they may have.
    const IntensityCompressionSettings& settings = this->streams().settings();
    if (!settings.fields.empty() || settings.keepsPoints())
      view.fields =
          pointFieldsOf<PointT>().viewsOf(cloud_.points.data(), sizeof(PointT));
    return {};
  }

private:
  const pcl::PointCloud<PointT>& cloud_;
  const DepthAxis axis_;
  std::vector<float>& intensities_;
};

/** \brief The leaves of an octree, as points at their centres. */
template <typename TreeT, typename IntensityModelT>
class LeafSource : public ModelSource<IntensityModelT> {
public:
  LeafSource(const IntensityModelT& model, const CloudStreams& streams, TreeT& tree)
  : ModelSource<IntensityModelT>(model, streams), tree_(tree)
  {}

  CompressionStatus
  open(OpenedCloud& opened) override
  {
    points_ = pointsOfLeaves(tree_);
    opened.view = viewOf(
        points_, hasColours<TreeT>(), IntensityModelT::unit != IntensityUnit::None);
    return {};
  }

private:
  TreeT& tree_;
  std::vector<LeafPoint> points_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::detail
