// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "measuring/workload.h"

#include <pcl_ext/compression/cloud_encoder.h>

#include "simulator/crop_box.h"

#include <pcl/common/io.h>
#include <pcl/conversions.h>

#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief The sensors of the robot cell. */
const RuntimeSensor kinect = runtimeSensor(KinectV2());

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

std::vector<std::string>
variantNames()
{
  std::vector<std::string> names;
  for (const Variant& variant : libraryVariants())
    names.emplace_back(variant.name);
  return names;
}

const Variant&
variantNamed(const std::string& name)
{
  for (const Variant& variant : libraryVariants())
    if (variant.name == name)
      return variant;
  throw std::invalid_argument("there is no effort '" + name + "'");
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
  if (settings.format == io::StreamFormat::Version1) {
    settings.intensity_bits = 8;
    settings.intensity_range = full_face;
    settings.depth_law = visitIntensityModel(
        workload.law, workload.resolution, kinect, [](const auto& model) {
          return io::depthLawOf(model);
        });
  }
  return settings;
}

void
throwUnlessOk(const io::CompressionStatus& status)
{
  if (!status.ok())
    throw std::runtime_error(status.message());
}

Preprocessing<PositionCloud>
makePreprocessing(const Workload& workload, const InputStream& stream)
{
  return makePreprocessing<PositionCloud>(workload.law,
                                          workload.resolution,
                                          kinect,
                                          stream.clouds->sensorPose(),
                                          stream.crop_box);
}

nodes::SensorNodeSettings
sensorNodeSettings(const InputStream& stream,
                   const Workload& workload,
                   const Variant& variant)
{
  nodes::SensorNodeSettings settings;
  settings.law = IntensityLaw::Count;
  settings.compression.resolution = workload.resolution;
  settings.compression.i_frame_rate = workload.i_frame_rate;
  settings.compression.effort = variant.effort;
  settings.compression.format = variant.format;
  settings.compression.colour_bits = 0;
  settings.crop_box = stream.crop_box;
  settings.outlier_removal = workload.outlier_removal;
  settings.compression.temporal_filter = workload.temporal_filter;
  return settings;
}

InputStream
openCellStream(unsigned int cell_sensor, std::size_t frames)
{
  return {clouds::openCell(cell_sensor, frames, /* seed */ 1), cell::cropBox()};
}

InputStream
openLidarStream(std::size_t revolutions)
{
  return {clouds::openCellLidar(revolutions, /* seed */ 1), cell::cropBox()};
}

std::vector<InputStream>
openRecordedStreams(const std::vector<std::string>& folders)
{
  std::vector<InputStream> streams;
  for (auto& clouds : clouds::openSequences(folders, /* max_frames */ 0))
    streams.push_back({std::move(clouds), std::nullopt});
  return streams;
}

std::vector<InputFrame>
readFrames(const InputStream& stream, const Workload& workload, Keep keep)
{
  pcl::PCLPointCloud2 message;
  IntensityCloud points;
  std::vector<InputFrame> frames(stream.clouds->size());
  const Preprocessing<PositionCloud> preprocess = makePreprocessing(workload, stream);
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
