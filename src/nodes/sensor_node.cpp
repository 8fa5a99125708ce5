#include <pcl_ext/compression/depth_model.h>
#include <pcl_ext/compression/frame_encoder.h>
#include <pcl_ext/compression/voxelizer.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/nodes/sensor_node.h>

#include "nodes/caught_status.h"
#include "nodes/latency.h"
#include "nodes/rate_window.h"
#include "nodes/sensor_node_settings.h"

#include <array>
#include <new>
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

/** \brief What turns clouds into voxels. Memory that runs out in it leaves it half done: it
 * is then made anew. */
struct FrameMaker {
  explicit FrameMaker(const SensorNodeSettings& settings)
  : preprocessor(makePreprocessor(settings))
  , voxelizer(codecSettings(settings), unitOf(settings.law))
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
  std::optional<VoxelOutlierRemoval> outlier_removal;

  // Members so that their memory is reused.
  pcl::PointCloud<pcl::PointXYZI> points;
  io::VoxelFrame frame;
};

/** \brief What only exists where the settings can be used. */
struct Pipeline {
  explicit Pipeline(const SensorNodeSettings& settings)
  : encoder(settings.compression.format,
            settings.compression.i_frame_rate,
            settings.compression.effort)
  , depth_law(depthLawOf(settings))
  {
    maker.emplace(settings);
  }

  std::optional<FrameMaker> maker; // none behind a cloud that it failed at
  io::FrameEncoder encoder;
  std::optional<io::DepthLaw> depth_law;
  std::optional<io::FrameStamp> stamp; // a member so that its memory is reused
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
    try {
      return encodeOrThrow(cloud, sensor_to_world, bytes);
    }
    catch (...) {
      SensorNodeStatus status =
          caughtStatus<SensorNodeStatus>(SensorNodeCode::EncodingFailed);
      bytes.clear();
      if (pipeline_) {
        ++statistics_.clouds_refused;
        pipeline_->maker.reset();
        // A frame that was encoded, but not counted, is not sent.
        pipeline_->encoder.requestIFrame();
      }
      return status;
    }
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
  encodeOrThrow(const pcl::PCLPointCloud2& cloud,
                const std::optional<WorldPose>& sensor_to_world,
                std::vector<std::uint8_t>& bytes)
  {
    if (!settings_status_.ok())
      return settings_status_;
    const auto start = std::chrono::steady_clock::now();
    if (SensorNodeStatus status = takeTransform(sensor_to_world); !status.ok())
      return status;
    if (!pipeline_->maker)
      pipeline_->maker.emplace(settings_);
    FrameMaker& maker = *pipeline_->maker;
    PreprocessingStatistics preprocessing;
    if (SensorNodeStatus status = preprocess(cloud, maker, preprocessing);
        !status.ok()) {
      ++statistics_.clouds_refused;
      return status;
    }
    const io::VoxelizationStatistics voxelization = voxelize(maker);
    const std::size_t outliers =
        maker.outlier_removal ? maker.outlier_removal->filter(maker.frame) : 0;
    if (SensorNodeStatus status = code(cloud.header, maker.frame, bytes);
        !status.ok()) {
      ++statistics_.clouds_refused;
      return status;
    }
    // Made before anything is counted, as its message needs memory.
    SensorNodeStatus status;
    if (!sensor_to_world)
      status = {SensorNodeCode::UsedLastTransform,
                "no transform came with the cloud; used the last known one"};
    const std::chrono::duration<double> cycle =
        std::chrono::steady_clock::now() - start;
    count(cloud, bytes.size(), cycle.count());
    statistics_.preprocessing = preprocessing;
    statistics_.outliers_removed = outliers;
    statistics_.frame.voxelization = voxelization;
    statistics_.frames_with_last_transform += sensor_to_world ? 0 : 1;
    return status;
  }

  SensorNodeStatus
  takeTransform(const std::optional<WorldPose>& sensor_to_world)
  {
    if (sensor_to_world) {
      const Eigen::Isometry3d pose(*sensor_to_world);
      if (!isRigid(pose.cast<float>())) {
        SensorNodeStatus status(
            SensorNodeCode::InvalidTransform,
            "the transform of the sensor is not a rotation and a translation");
        ++statistics_.clouds_refused;
        return status;
      }
      last_transform_ = *sensor_to_world;
    }
    if (!last_transform_) {
      SensorNodeStatus status(SensorNodeCode::NoTransform,
                              "no transform from the sensor to '" +
                                  settings_.global_frame +
                                  "' is known yet; the cloud is left out");
      ++statistics_.clouds_without_transform;
      return status;
    }
    return {};
  }

  SensorNodeStatus
  preprocess(const pcl::PCLPointCloud2& cloud,
             FrameMaker& maker,
             PreprocessingStatistics& statistics) const
  {
    return std::visit(
        [&](auto& preprocessor) -> SensorNodeStatus {
          preprocessor.setSensorPose(Eigen::Isometry3d(*last_transform_));
          const PreprocessingStatus status = preprocessor.process(cloud, maker.points);
          if (!status.ok())
            return {SensorNodeCode::InvalidCloud, status.message()};
          statistics = preprocessor.getStatistics();
          return {};
        },
        maker.preprocessor);
  }

  io::VoxelizationStatistics
  voxelize(FrameMaker& maker) const
  {
    const auto& points = maker.points;
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
    const io::VoxelizationStatistics statistics =
        maker.voxelizer.voxelize(view, pipeline_->encoder.isIFrameDue(), maker.frame);
    maker.frame.depth_model.reset();
    if (pipeline_->depth_law) {
      const auto elements = [](const Eigen::Vector3d& vector) {
        return std::array<double, 3>{vector.x(), vector.y(), vector.z()};
      };
      maker.frame.depth_model =
          io::depthModelOf(*pipeline_->depth_law,
                           elements(last_transform_->translation()),
                           elements(last_transform_->linear().col(2)),
                           maker.frame.grid,
                           maker.frame.intensity_scale);
    }
    return statistics;
  }

  SensorNodeStatus
  code(const pcl::PCLHeader& header,
       const io::VoxelFrame& frame,
       std::vector<std::uint8_t>& bytes)
  {
    if (settings_.compression.carry_header)
      pipeline_->stamp = io::FrameStamp{header.stamp, settings_.global_frame};
    const io::CompressionStatus status =
        pipeline_->encoder.encode(frame, pipeline_->stamp, bytes);
    if (!status.ok()) {
      bytes.clear();
      if (status.code() == io::CompressionCode::OutOfMemory)
        throw std::bad_alloc(); // as all others that ran out
      return {SensorNodeCode::EncodingFailed, status.message()};
    }
    return {};
  }

  void
  count(const pcl::PCLPointCloud2& cloud, std::size_t bytes, double cycle_seconds)
  {
    const io::CodedFrameStatistics& coding = pipeline_->encoder.statistics();
    const Time now = settings_.clock();
    window_.add({now,
                 bytes,
                 cycle_seconds,
                 latencySeconds(timeOfStamp(cloud.header.stamp), now)});
    // Nothing is thrown any more.
    ++statistics_.frames;
    statistics_.i_frames += coding.is_i_frame ? 1 : 0;
    statistics_.cloud_bytes += cloud.data.size();
    statistics_.frame_bytes += bytes;
    statistics_.frame.coding = coding;
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
