// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/sensor_pipeline.h"

#include <pcl_ext/filters/preprocessed_batches.h>
#include <pcl_ext/intensity/intensity_law.h>
#include <pcl_ext/point_intensity.h>

#include "nodes/sensor_node_settings.h"

#include <type_traits>
#include <utility>

namespace pcl_ext {
namespace nodes {

namespace {

template <typename IntensityModelT>
class SensorPointsOf : public SensorPoints {
public:
  using Batches = PreprocessedBatches<IntensityModelT, PointXYZRGBI>;

  explicit SensorPointsOf(const typename Batches::Preprocessor& preprocessor)
  : batches_(preprocessor)
  {}

  void
  setReadsFields(bool reads_fields)
  {
    batches_.setReadsFields(reads_fields);
  }

  PreprocessingStatus
  open(const Eigen::Isometry3d& sensor_pose, const pcl::PCLPointCloud2& cloud) override
  {
    batches_.setSensorPose(sensor_pose);
    return batches_.open(cloud);
  }

  io::PointBatches&
  batches() override
  {
    return batches_;
  }

  PreprocessingStatistics
  statistics() const override
  {
    return batches_.statistics();
  }

private:
  Batches batches_;
};

std::unique_ptr<SensorPoints>
makePoints(const SensorNodeSettings& settings)
{
  return visitIntensityModel(
      settings.law,
      settings.compression.resolution,
      settings.sensor,
      [&](const auto& model) -> std::unique_ptr<SensorPoints> {
        using Points = SensorPointsOf<std::decay_t<decltype(model)>>;
        typename Points::Batches::Preprocessor preprocessor(model);
        preprocessor.setIntensityField(settings.intensity_field);
        preprocessor.setReadsColours(codesColours(settings));
        if (settings.crop_box)
          preprocessor.setCropBox(Eigen::Vector3d(settings.crop_box->min.data()),
                                  Eigen::Vector3d(settings.crop_box->max.data()));
        auto points = std::make_unique<Points>(preprocessor);
        // With the points the field ring, too, whose order they may have.
        points->setReadsFields(!settings.compression.fields.empty() ||
                               settings.compression.keep_point_counts);
        return points;
      });
}

std::unique_ptr<SensorPoints>
makeUncroppedPoints(const SensorNodeSettings& settings)
{
  SensorNodeSettings uncropped = settings;
  uncropped.crop_box.reset();
  uncropped.law = IntensityLaw::None;
  uncropped.compression.colour_bits = 0;
  return makePoints(uncropped);
}

io::CloudEncoder
makeEncoder(const SensorNodeSettings& settings)
{
  const IntensityUnit unit = visitIntensityModel(
      settings.law,
      settings.compression.resolution,
      settings.sensor,
      [](const auto& model) { return std::decay_t<decltype(model)>::unit; });
  return io::CloudEncoder(codecSettings(settings), unit, depthLaw(settings));
}

io::RateControl
makeRateControl(const SensorNodeSettings& settings)
{
  return io::RateControl(
      codecSettings(settings),
      settings.law != IntensityLaw::None,
      true,
      settings.outlier_removal
          ? std::optional<float>(settings.outlier_removal->min_log_odds)
          : std::nullopt);
}

} // namespace

std::optional<io::DepthLaw>
depthLaw(const SensorNodeSettings& settings)
{
  return visitIntensityModel(settings.law,
                             settings.compression.resolution,
                             settings.sensor,
                             [](const auto& model) { return io::depthLawOf(model); });
}

SensorFilters::SensorFilters(const SensorNodeSettings& settings)
: points(makePoints(settings))
{
  if (settings.crop_box && (settings.compression.temporal_filter != 0 ||
                            settings.compression.max_rate > 0.0))
    uncropped = makeUncroppedPoints(settings);
  if (!settings.outlier_removal)
    return;
  outlier_removal.emplace(removalSettings(settings));
  if (settings.outlier_removal->unit == DensityUnit::Automatic)
    point_outlier_removal.emplace(PointOutlierRemovalSettings{
        settings.outlier_removal->min_log_odds, settings.outlier_removal->use_history});
}

SensorPipeline::SensorPipeline(const SensorNodeSettings& settings)
: encoder(makeEncoder(settings))
, rate_control(makeRateControl(settings))
, filters(std::in_place, settings)
{}

} // namespace nodes
} // namespace pcl_ext
