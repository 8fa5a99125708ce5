#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "latency.h"
#include "rate_window.h"
#include "sensor_node_settings.h"

#include <array>
#include <utility>
#include <variant>

namespace pcl_ext {
namespace nodes {

namespace {

using Quadratic = IntensityModel<RuntimeSensor, QuadraticLaw>;
using Linear = IntensityModel<RuntimeSensor, LinearLaw>;

/** \brief The preprocessors of the laws to choose from. */
using Preprocessor = std::variant<SensorPreprocessor<CountIntensity>,
                                  SensorPreprocessor<Quadratic>,
                                  SensorPreprocessor<Linear>,
                                  SensorPreprocessor<NativeIntensity>>;

Preprocessor
makePreprocessor(const SensorNodeSettings& settings)
{
  const double resolution = settings.compression.resolution;
  switch (settings.law) {
  case IntensityLaw::Quadratic:
    return SensorPreprocessor<Quadratic>(Quadratic(resolution, *settings.sensor));
  case IntensityLaw::Linear:
    return SensorPreprocessor<Linear>(Linear(resolution, *settings.sensor));
  case IntensityLaw::Native:
    return SensorPreprocessor<NativeIntensity>(NativeIntensity(resolution));
  case IntensityLaw::Count:
    break;
  }
  return SensorPreprocessor<CountIntensity>(CountIntensity(resolution));
}

IntensityUnit
unitOf(IntensityLaw law)
{
  switch (law) {
  case IntensityLaw::Quadratic:
  case IntensityLaw::Linear:
    return IntensityUnit::Share;
  case IntensityLaw::Native:
    return IntensityUnit::Native;
  case IntensityLaw::Count:
    break;
  }
  return IntensityUnit::Points;
}

std::optional<io::DepthLaw>
depthLawOf(const SensorNodeSettings& settings)
{
  if (!needsSensor(settings.law) ||
      settings.compression.format != io::StreamFormat::Version1)
    return std::nullopt;
  const double resolution = settings.compression.resolution;
  // Decoded shares are 255 for a full voxel face.
  if (settings.law == IntensityLaw::Quadratic)
    return io::DepthLaw{QuadraticLaw::depth_exponent,
                        Quadratic(resolution, *settings.sensor).cutOffDepth(),
                        255.0};
  return io::DepthLaw{LinearLaw::depth_exponent,
                      Linear(resolution, *settings.sensor).cutOffDepth(),
                      255.0};
}

/** \brief What only exists where the settings can be used. */
struct Pipeline {
  explicit Pipeline(const SensorNodeSettings& settings)
  : preprocessor(makePreprocessor(settings))
  , voxelizer(codecSettings(settings), unitOf(settings.law))
  , encoder(settings.compression.format,
            settings.compression.i_frame_rate,
            settings.compression.effort)
  , depth_law(depthLawOf(settings))
  {
    if (settings.outlier_removal)
      outlier_removal.emplace(removalSettings(settings));
    std::visit(
        [&](auto& chosen) {
          chosen.setIntensityField(settings.intensity_field);
          if (settings.crop_box)
            chosen.setCropBox(
                Eigen::Vector3d(settings.crop_box->min.data()).cast<float>(),
                Eigen::Vector3d(settings.crop_box->max.data()).cast<float>());
        },
        preprocessor);
  }

  Preprocessor preprocessor;
  io::Voxelizer voxelizer;
  io::FrameEncoder encoder;
  std::optional<io::DepthLaw> depth_law;
  std::optional<VoxelOutlierRemoval> outlier_removal;

  // Members so that their memory is reused.
  pcl::PointCloud<pcl::PointXYZI> points;
  io::VoxelFrame frame;
  std::optional<io::FrameStamp> stamp;
};

} // namespace

class SensorNode::Implementation {
public:
  explicit Implementation(const SensorNodeSettings& settings)
  : settings_(settings), settings_status_(checkSettings(settings))
  {
    if (settings_status_.ok())
      pipeline_.emplace(settings_);
  }

  const SensorNodeStatus&
  settingsStatus() const
  {
    return settings_status_;
  }

  SensorNodeStatus
  encode(const pcl::PCLPointCloud2& cloud,
         const std::optional<WorldPose>& sensor_to_world,
         std::vector<std::uint8_t>& bytes)
  {
    bytes.clear();
    if (!settings_status_.ok())
      return settings_status_;
    const auto start = std::chrono::steady_clock::now();
    if (SensorNodeStatus status = takeTransform(sensor_to_world); !status.ok())
      return status;
    if (SensorNodeStatus status = preprocess(cloud); !status.ok()) {
      ++statistics_.clouds_refused;
      return status;
    }
    const io::VoxelizationStatistics voxelization = voxelize();
    if (pipeline_->outlier_removal)
      statistics_.outliers_removed =
          pipeline_->outlier_removal->filter(pipeline_->frame);
    if (SensorNodeStatus status = code(cloud.header, bytes); !status.ok()) {
      ++statistics_.clouds_refused;
      return status;
    }
    statistics_.frame.voxelization = voxelization;
    const std::chrono::duration<double> cycle =
        std::chrono::steady_clock::now() - start;
    count(cloud, bytes.size(), cycle.count());
    if (sensor_to_world)
      return {};
    ++statistics_.frames_with_last_transform;
    return {SensorNodeCode::UsedLastTransform,
            "no transform came with the cloud; used the last known one"};
  }

  void
  requestIFrame()
  {
    if (pipeline_)
      pipeline_->encoder.requestIFrame();
  }

  SensorNodeStatistics
  statistics() const
  {
    SensorNodeStatistics statistics = statistics_;
    if (settings_.clock)
      statistics.rates = window_.rates(settings_.clock());
    return statistics;
  }

private:
  SensorNodeStatus
  takeTransform(const std::optional<WorldPose>& sensor_to_world)
  {
    if (sensor_to_world) {
      const Eigen::Isometry3d pose(*sensor_to_world);
      if (!isRigid(pose.cast<float>())) {
        ++statistics_.clouds_refused;
        return {SensorNodeCode::InvalidTransform,
                "the transform of the sensor is not a rotation and a translation"};
      }
      last_transform_ = *sensor_to_world;
    }
    if (!last_transform_) {
      ++statistics_.clouds_without_transform;
      return {SensorNodeCode::NoTransform,
              "no transform from the sensor to '" + settings_.global_frame +
                  "' is known yet; the cloud is left out"};
    }
    return {};
  }

  SensorNodeStatus
  preprocess(const pcl::PCLPointCloud2& cloud)
  {
    return std::visit(
        [&](auto& preprocessor) -> SensorNodeStatus {
          preprocessor.setSensorPose(Eigen::Isometry3d(*last_transform_));
          const PreprocessingStatus status =
              preprocessor.process(cloud, pipeline_->points);
          if (!status.ok())
            return {SensorNodeCode::InvalidCloud, status.message()};
          statistics_.preprocessing = preprocessor.getStatistics();
          return {};
        },
        pipeline_->preprocessor);
  }

  io::VoxelizationStatistics
  voxelize()
  {
    const auto& points = pipeline_->points;
    io::PointView view;
    view.count = points.size();
    if (!points.empty()) {
      constexpr std::size_t stride = sizeof(pcl::PointXYZI) / sizeof(float);
      view.coordinates = &points.front().x;
      view.coordinate_stride = stride;
      if (settings_.law != IntensityLaw::Count) {
        view.intensities = &points.front().intensity;
        view.intensity_stride = stride;
      }
    }
    const io::VoxelizationStatistics statistics = pipeline_->voxelizer.voxelize(
        view, pipeline_->encoder.isIFrameDue(), pipeline_->frame);
    pipeline_->frame.depth_model.reset();
    if (pipeline_->depth_law) {
      const auto elements = [](const Eigen::Vector3d& vector) {
        return std::array<double, 3>{vector.x(), vector.y(), vector.z()};
      };
      pipeline_->frame.depth_model =
          io::depthModelOf(*pipeline_->depth_law,
                           elements(last_transform_->translation()),
                           elements(last_transform_->linear().col(2)),
                           pipeline_->frame.grid,
                           pipeline_->frame.intensity_scale);
    }
    return statistics;
  }

  SensorNodeStatus
  code(const pcl::PCLHeader& header, std::vector<std::uint8_t>& bytes)
  {
    if (settings_.compression.carry_header)
      pipeline_->stamp = io::FrameStamp{header.stamp, settings_.global_frame};
    const io::CompressionStatus status =
        pipeline_->encoder.encode(pipeline_->frame, pipeline_->stamp, bytes);
    if (!status.ok()) {
      bytes.clear();
      return {SensorNodeCode::EncodingFailed, status.message()};
    }
    return {};
  }

  void
  count(const pcl::PCLPointCloud2& cloud, std::size_t bytes, double cycle_seconds)
  {
    const io::CodedFrameStatistics& coding = pipeline_->encoder.statistics();
    ++statistics_.frames;
    statistics_.i_frames += coding.is_i_frame ? 1 : 0;
    statistics_.cloud_bytes += cloud.data.size();
    statistics_.frame_bytes += bytes;
    statistics_.frame.coding = coding;
    const Time now = settings_.clock();
    window_.add({now,
                 bytes,
                 cycle_seconds,
                 latencySeconds(timeOfStamp(cloud.header.stamp), now)});
  }

  SensorNodeSettings settings_;
  SensorNodeStatus settings_status_;
  std::optional<Pipeline> pipeline_; // where the settings can be used
  std::optional<WorldPose> last_transform_;
  SensorNodeStatistics statistics_;
  RateWindow window_;
};

SensorNode::SensorNode(const SensorNodeSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

SensorNode::~SensorNode() = default;
SensorNode::SensorNode(SensorNode&&) noexcept = default;
SensorNode&
SensorNode::operator=(SensorNode&&) noexcept = default;

const SensorNodeStatus&
SensorNode::settingsStatus() const
{
  return implementation_->settingsStatus();
}

SensorNodeStatus
SensorNode::encode(const pcl::PCLPointCloud2& cloud,
                   const std::optional<WorldPose>& sensor_to_world,
                   std::vector<std::uint8_t>& bytes)
{
  return implementation_->encode(cloud, sensor_to_world, bytes);
}

void
SensorNode::requestIFrame()
{
  implementation_->requestIFrame();
}

SensorNodeStatistics
SensorNode::statistics() const
{
  return implementation_->statistics();
}

} // namespace nodes
} // namespace pcl_ext
