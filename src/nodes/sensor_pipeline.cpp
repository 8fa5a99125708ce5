// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/sensor_pipeline.h"

#include <pcl_ext/impl/point_intensity.h>
#include <pcl_ext/intensity/intensity_law.h>

#include "filters/preprocessed_batches.h"
#include "nodes/left_out.h"
#include "nodes/sensor_node_settings.h"

#include <optional>
#include <type_traits>
#include <variant>

namespace pcl_ext::PCL_EXT_ABI::nodes {

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
                               settings.compression.keepsPoints());
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

/** \brief The law of the points' intensities at the resolution of the settings, if it
 * depends on the depth. */
std::optional<io::DepthLaw>
depthLaw(const SensorNodeSettings& settings)
{
  return visitIntensityModel(settings.law,
                             settings.compression.resolution,
                             settings.sensor,
                             [](const auto& model) { return io::depthLawOf(model); });
}

} // namespace

SensorFilters::SensorFilters(const SensorNodeSettings& settings)
: points(makePoints(settings))
{
  if (settings.crop_box && (settings.compression.temporal_filter != 0 ||
                            settings.compression.max_rate > 0.0))
    uncropped = makeUncroppedPoints(settings);
  if (!settings.outlier_removal)
    return;
  if (VoxelOutlierRemoval::isMadeFor(settings.compression.resolution))
    outlier_removal.emplace(removalSettings(settings));
  if (const auto* const unit =
          std::get_if<AutomaticUnit>(&settings.outlier_removal->unit))
    point_outlier_removal.emplace(PointOutlierRemovalSettings{
        settings.outlier_removal->min_log_odds, unit->use_history});
}

SensorSource::SensorSource(const SensorNodeSettings& settings)
: removal_(settings.outlier_removal), settings_(settings)
{}

void
SensorSource::setCloud(const pcl::PCLPointCloud2& cloud,
                       const WorldPose& sensor_to_world)
{
  cloud_ = &cloud;
  sensor_to_world_ = &sensor_to_world;
}

std::optional<io::DepthLaw>
SensorSource::takeStep(const io::EncoderSettings& step,
                       const std::optional<float>& min_log_odds)
{
  // A step without is for voxels that are too large to be judged; points still are.
  std::optional<VoxelOutlierRemovalSettings> removal = removal_;
  if (min_log_odds) {
    if (!removal)
      removal.emplace();
    removal->min_log_odds = *min_log_odds;
  }
  if (step.resolution != settings_.compression.resolution ||
      !(removal == settings_.outlier_removal))
    filters_.reset();
  settings_.compression = step;
  settings_.outlier_removal = removal;
  return depthLaw(settings_);
}

io::CompressionStatus
SensorSource::open(io::OpenedCloud& opened)
{
  if (!filters_)
    filters_.emplace(settings_);
  voxels_removed_ = 0;
  is_cloud_invalid_ = true;
  const OutlierRemovalStatus judged = judgePoints();
  judges_points_ = judged.ok();
  points_removed_ = judged.removed;
  const pcl::PCLPointCloud2& cloud = judged.removed > 0 ? filters_->cloud : *cloud_;
  const Eigen::Isometry3d pose(*sensor_to_world_);
  if (const PreprocessingStatus status = filters_->points->open(pose, cloud);
      !status.ok())
    return {io::CompressionCode::InvalidInput, status.message()};
  if (const std::string fault = faultOfNamedFields(cloud, settings_.compression.fields);
      !fault.empty())
    return {io::CompressionCode::InvalidInput, fault};
  is_cloud_invalid_ = false;
  opened.batches = &filters_->points->batches();
  if (filters_->uncropped) {
    (void)filters_->uncropped->open(pose, cloud);
    opened.uncropped = &filters_->uncropped->batches();
    opened.crop_box = *settings_.crop_box;
  }
  return {};
}

/** \brief Finds outliers among the points of a lidar, and makes a cloud without them. */
OutlierRemovalStatus
SensorSource::judgePoints()
{
  if (!filters_->point_outlier_removal)
    return {OutlierRemovalCode::NoImage, ""};
  OutlierRemovalStatus status =
      filters_->outliers.find(*cloud_, *filters_->point_outlier_removal);
  if (status.removed > 0) {
    filters_->cloud = *cloud_;
    filters_->outliers.hide(filters_->cloud);
  }
  return status;
}

void
SensorSource::removeNoise(io::VoxelFrame& frame)
{
  if (!removesNoise())
    return;
  VoxelOutlierRemoval& removal = *filters_->outlier_removal;
  const Eigen::Vector3d sensor(sensor_to_world_->translation());
  const auto* const rays = std::get_if<RaysUnit>(&settings_.outlier_removal->unit);
  if (rays != nullptr && !rays->sensor_position)
    removal.setSensorPosition({sensor.x(), sensor.y(), sensor.z()});
  // checkSettings() has refused what the filter would, but for the edge.
  voxels_removed_ = removal.filter(frame).removed;
}

void
SensorSource::describe(SensorNodeStatistics& statistics) const
{
  statistics.preprocessing = filters_->points->statistics();
  statistics.preprocessing.points_not_finite -= points_removed_;
  statistics.outliers_removed = voxels_removed_;
  if (filters_->outlier_removal)
    statistics.density_unit = filters_->outlier_removal->unit();
  statistics.judged_points = judges_points_;
  statistics.points_removed = points_removed_;
}

io::CloudEncoder
makeEncoder(const SensorNodeSettings& settings)
{
  const IntensityUnit unit = visitIntensityModel(
      settings.law,
      settings.compression.resolution,
      settings.sensor,
      [](const auto& model) { return std::decay_t<decltype(model)>::unit; });
  // None where the rate control turns none on, as scans have no voxels to remove.
  std::optional<io::CloudEncoder::NoiseRemoval> noise_removal;
  if (settings.outlier_removal)
    noise_removal.emplace().min_log_odds = settings.outlier_removal->min_log_odds;
  else if (settings.compression.max_rate > 0.0 ||
           settings.compression.max_encode_ms > 0.0)
    noise_removal.emplace();
  return io::CloudEncoder(
      codecSettings(settings), unit, depthLaw(settings), noise_removal);
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
