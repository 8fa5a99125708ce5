// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/demo_stream.h"

#include "clouds/point_fields.h"
#include "inputs/point_cloud_conversions.h"
#include "measuring/samples.h"

#include <stdexcept>

namespace pcl_ext::tools {

namespace {

using measuring::timeOf;

/** \brief The cell's sensor with the pose that it has there. */
std::unique_ptr<clouds::CloudSequence>
openSensor(EncodingOptions& options,
           unsigned int sensor,
           std::size_t frames,
           std::uint32_t seed)
{
  std::unique_ptr<clouds::CloudSequence> sequence =
      clouds::openCell(sensor, frames, seed);
  options.setPose("/" + sequence->name(), WorldPose(sequence->sensorPose()));
  return sequence;
}

void
copyPoints(const pcl::PCLPointCloud2& cloud,
           const std::vector<int>& points,
           pcl::PCLPointCloud2& copy)
{
  copy.header = cloud.header;
  copy.fields = cloud.fields;
  copy.point_step = cloud.point_step;
  copy.is_bigendian = cloud.is_bigendian;
  copy.is_dense = cloud.is_dense;
  copy.width = static_cast<std::uint32_t>(points.size());
  copy.height = 1;
  copy.row_step = copy.width * copy.point_step;
  copy.data.clear();
  for (const int point : points) {
    const std::uint8_t* const begin =
        &cloud.data[clouds::offsetOf(cloud, static_cast<std::size_t>(point))];
    copy.data.insert(copy.data.end(), begin, begin + cloud.point_step);
  }
}

} // namespace

DemoStream::DemoStream(EncodingOptions& options,
                       unsigned int sensor,
                       std::size_t frames,
                       std::uint32_t seed,
                       const std::optional<float>& threshold)
: law_(options.law().value_or(automaticLaw(false)))
, sequence_(openSensor(options, sensor, frames, seed))
, encoder_(options, "/" + sequence_->name())
, denoising_(law_, options.codec().resolution, threshold)
, truth_(seed, sensor, options.codec().resolution)
{
  name_ = sequence_->name();
}

void
DemoStream::run(std::size_t frame)
{
  sequence_->read(frame, cloud_);
  const std::string source = name_ + ", frame " + std::to_string(frame);
  encode_ms_ += timeOf([&] { encoder_.encode(cloud_, source, bytes_); });
  io::CompressionStatus status;
  decode_ms_ +=
      timeOf([&] { status = decoder_.decode(bytes_.data(), bytes_.size(), voxels_); });
  if (!status.ok())
    throw std::runtime_error("decoding failed: " + status.message());
  toCloud(voxels_, decoded_);
  denoise(truth_.of(frame, voxels_));
}

void
DemoStream::denoise(const std::vector<noise::VoxelTruth>* truth)
{
  intensities_.clear();
  io::forEachVoxelCentre(voxels_, [this](float, float, float, float intensity) {
    intensities_.push_back(intensity);
  });
  const std::vector<int>& kept = denoising_.voxelsToKeep(voxels_, intensities_, truth);
  if (voxels_.has_point_counts)
    denoised_ = decoded_; // points are no voxels
  else
    copyPoints(decoded_, kept, denoised_);
}

DemoReport
DemoStream::report() const
{
  return {name_, encoder_.sums(), encode_ms_, decode_ms_, denoising_.report()};
}

} // namespace pcl_ext::tools
