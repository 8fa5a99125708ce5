// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/cloud_encoder.h>

#include "stream/cloud_stages.h"

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief A cloud in memory, of one depth law. */
class ViewSource : public CloudSource {
public:
  ViewSource(const PointView& points,
             std::size_t points_behind_sensor,
             const std::optional<DepthLaw>& depth_law)
  : points_(points), points_behind_sensor_(points_behind_sensor), depth_law_(depth_law)
  {}

  std::optional<DepthLaw>
  takeStep(const EncoderSettings& /*settings*/,
           const std::optional<float>& /*min_log_odds*/) override
  {
    return depth_law_;
  }

  CompressionStatus
  open(OpenedCloud& cloud) override
  {
    cloud.view = points_;
    cloud.points_behind_sensor = points_behind_sensor_;
    return {};
  }

private:
  const PointView& points_;
  std::size_t points_behind_sensor_;
  const std::optional<DepthLaw>& depth_law_;
};

} // namespace

CloudSource::~CloudSource() = default;

bool
CloudSource::removesNoise() const
{
  return false;
}

void
CloudSource::removeNoise(VoxelFrame& /*frame*/)
{}

CloudEncoder::CloudEncoder(const EncoderSettings& settings,
                           IntensityUnit unit,
                           const std::optional<DepthLaw>& depth_law,
                           const std::optional<NoiseRemoval>& noise_removal)
: stages_(std::make_unique<CloudStages>(settings, unit, depth_law, noise_removal))
{}

CloudEncoder::~CloudEncoder() = default;
CloudEncoder::CloudEncoder(CloudEncoder&&) noexcept = default;
CloudEncoder&
CloudEncoder::operator=(CloudEncoder&&) noexcept = default;

const CompressionStatus&
CloudEncoder::settingsStatus() const
{
  return stages_->settings_status_;
}

const EncoderSettings&
CloudEncoder::settings() const
{
  return stages_->settings_;
}

void
CloudEncoder::setResolution(double resolution, const std::optional<DepthLaw>& depth_law)
{
  stages_->setResolution(resolution, depth_law);
}

void
CloudEncoder::requestIFrame()
{
  stages_->encoder_.requestIFrame();
}

void
CloudEncoder::setMaxRate(double bits_per_second)
{
  if (stages_->rate_control_)
    stages_->rate_control_->setMaxRate(bits_per_second);
}

RateControlStatus
CloudEncoder::rateControlStatus() const
{
  return stages_->rate_control_ ? stages_->rate_control_->status()
                                : RateControlStatus();
}

CompressionStatus
CloudEncoder::encode(CloudSource& source,
                     const CloudInfo& info,
                     std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  CompressionStatus status =
      stages_->call([&] { return stages_->run(source, info, bytes); });
  if (!status.ok()) {
    bytes.clear();
    stages_->clearFrame(); // it may be that of the previous cloud
  }
  return status;
}

CompressionStatus
CloudEncoder::encode(const PointView& points,
                     const CloudInfo& info,
                     std::vector<std::uint8_t>& bytes,
                     std::size_t points_behind_sensor)
{
  ViewSource source(points, points_behind_sensor, stages_->depth_law_);
  return encode(source, info, bytes);
}

CompressionStatus
CloudEncoder::voxelize(const PointView& points,
                       const WorldPose& sensor_pose,
                       VoxelFrame& frame)
{
  CompressionStatus status =
      stages_->call([&] { return stages_->voxelize(points, sensor_pose, frame); });
  if (!status.ok())
    frame.clearVoxels();
  return status;
}

const VoxelFrame&
CloudEncoder::frame() const
{
  return stages_->frame();
}

ImageSize
CloudEncoder::decodedSize() const
{
  return stages_->decodedSize();
}

const FrameStatistics&
CloudEncoder::statistics() const
{
  return stages_->statistics_;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
