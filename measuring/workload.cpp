#include "measuring/workload.h"

#include <pcl_ext/filters/sensor_preprocessor.h>

#include "simulator/crop_box.h"

#include <pcl/common/io.h>
#include <pcl/conversions.h>

#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief Top of the 8-bit scale that the published layout has, and all get here. */
constexpr float scale_top = 255.0f;

template <typename LawT>
Preprocessing
makePreprocessingWith(double resolution,
                      const Eigen::Isometry3d& sensor_pose,
                      const std::optional<io::BoundingBox>& crop_box)
{
  using Model = IntensityModel<KinectV2, LawT>;
  SensorPreprocessor<Model> preprocessor{Model(resolution)};
  preprocessor.setSensorPose(sensor_pose);
  if (crop_box)
    preprocessor.setCropBox(
        Eigen::Map<const Eigen::Vector3d>(crop_box->min.data()).cast<float>(),
        Eigen::Map<const Eigen::Vector3d>(crop_box->max.data()).cast<float>());
  if (LawT::unit == IntensityUnit::Share)
    preprocessor.setIntensityScale(scale_top);
  return [preprocessor](const PositionCloud& cloud, IntensityCloud& output) mutable {
    if (const auto status = preprocessor.process(cloud, output); !status.ok())
      throw std::runtime_error("preprocessing failed: " + status.message());
  };
}

} // namespace

const std::vector<Variant>&
libraryVariants()
{
  static const std::vector<Variant> variants = {
      {"fast", io::Effort::Fast, io::StreamFormat::Version1},
      {"balanced", io::Effort::Balanced, io::StreamFormat::Version1},
      {"small", io::Effort::Small, io::StreamFormat::Version1},
      {"published", io::Effort::Balanced, io::StreamFormat::Published}};
  return variants;
}

Variant
variantNamed(const std::string& name)
{
  std::string names;
  for (const Variant& variant : libraryVariants()) {
    if (variant.name == name)
      return variant;
    names += std::string(" ") + variant.name;
  }
  throw std::invalid_argument("there is no effort '" + name + "'; there are:" + names);
}

std::string
coderName(const Variant& variant)
{
  return std::string("pcl_ext, ") + variant.name;
}

io::IntensityCompressionSettings
compressionSettings(const Workload& workload, const Variant& variant)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = workload.resolution;
  settings.i_frame_rate = workload.i_frame_rate;
  settings.effort = variant.effort;
  settings.format = variant.format;
  settings.aggregation = io::Aggregation::Sum;
  if (variant.format == io::StreamFormat::Version1) {
    settings.intensity_bits = 8;
    settings.intensity_range = scale_top;
    if (workload.law == Law::Quadratic)
      settings.depth_law = io::DepthLaw{
          2u,
          IntensityModel<KinectV2, QuadraticLaw>(workload.resolution).cutOffDepth(),
          static_cast<double>(scale_top)};
  }
  return settings;
}

io::PointView
viewOf(const IntensityCloud& points)
{
  constexpr std::size_t floats_per_point = sizeof(pcl::PointXYZI) / sizeof(float);
  io::PointView view;
  view.count = points.size();
  view.coordinates = &points.front().x;
  view.coordinate_stride = floats_per_point;
  view.intensities = &points.front().intensity;
  view.intensity_stride = floats_per_point;
  return view;
}

io::FrameEncoder
makeFrameEncoder(const io::IntensityCompressionSettings& settings)
{
  return io::FrameEncoder(settings.format, settings.i_frame_rate, settings.effort);
}

Preprocessing
makePreprocessing(const Workload& workload,
                  const Eigen::Isometry3d& sensor_pose,
                  const std::optional<io::BoundingBox>& crop_box)
{
  return workload.law == Law::Quadratic
             ? makePreprocessingWith<QuadraticLaw>(
                   workload.resolution, sensor_pose, crop_box)
             : makePreprocessingWith<CountLaw>(
                   workload.resolution, sensor_pose, crop_box);
}

InputStream
openCellStream(unsigned int sensor, std::size_t frames)
{
  return {openCell(sensor, frames, /* seed */ 1), cell::cropBox()};
}

InputStream
openLidarStream(std::size_t revolutions)
{
  return {openCellLidar(revolutions, /* seed */ 1), cell::cropBox()};
}

std::vector<InputStream>
openRecordedStreams(const std::vector<std::string>& folders)
{
  std::vector<InputStream> streams;
  for (auto& clouds : openSequences(folders, /* max_frames */ 0))
    streams.push_back({std::move(clouds), std::nullopt});
  return streams;
}

std::vector<InputFrame>
readFrames(const InputStream& stream, const Workload& workload, Keep keep)
{
  const Preprocessing preprocess =
      makePreprocessing(workload, stream.clouds->sensorPose(), stream.crop_box);
  pcl::PCLPointCloud2 message;
  IntensityCloud points;
  std::vector<InputFrame> frames(stream.clouds->size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    stream.clouds->read(i, message);
    pcl::fromPCLPointCloud2(message, *frames[i].raw);
    preprocess(*frames[i].raw, points);
    if (points.empty())
      throw std::runtime_error(stream.clouds->name() + ": frame " + std::to_string(i) +
                               " has no point within the crop box");
    // A copy has no memory for the points that were cropped.
    *frames[i].points = points;
    pcl::copyPointCloud(points, *frames[i].positions);
    if (keep == Keep::Preprocessed)
      frames[i].raw.reset();
  }
  return frames;
}

} // namespace measuring
} // namespace pcl_ext
