#include "stream_encoder.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace pcl_ext {
namespace python {

StreamEncoder::StreamEncoder(const EncoderSettings& settings) : settings_(settings)
{
  if (settings_.law)
    start(*settings_.law);
}

void
StreamEncoder::start(IntensityLaw law)
{
  visitIntensityModel(
      law, settings_.codec.resolution, settings_.sensor, [&](const auto& model) {
        const auto model_law = io::depthLawOf(model);
        encoder_.emplace(settings_.codec,
                         std::decay_t<decltype(model)>::unit,
                         model_law ? model_law : settings_.depth_law);
      });
  settings_.law = law;
}

void
StreamEncoder::checkIntensities(const CloudToEncode& cloud) const
{
  const std::string name = nameOf(*settings_.law);
  if (*settings_.law != IntensityLaw::Native) {
    if (cloud.has_intensity_argument)
      throw std::invalid_argument("there is an intensity, which the law '" + name +
                                  "' does not use; leave it out, or construct the "
                                  "Encoder with law='native'");
    return;
  }
  if (!cloud.columns.intensity && cloud.columns.count > 0)
    throw std::invalid_argument("there is no intensity, which the law 'native' needs; "
                                "pass it, or construct the Encoder with law='count'");
}

io::CompressionStatus
StreamEncoder::encode(const CloudToEncode& cloud, std::vector<std::uint8_t>& bytes)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!encoder_)
    start(automaticLaw(cloud.columns.intensity.has_value()));
  checkIntensities(cloud);
  const bool is_native = *settings_.law == IntensityLaw::Native;
  io::PointView view = viewOf(cloud.columns, is_native, settings_.codec, memory_);
  const WorldPose pose =
      cloud.sensor_pose.value_or(settings_.sensor_pose.value_or(WorldPose::Identity()));
  std::size_t points_behind_sensor = 0;
  if (needsSensor(*settings_.law) && view.count > 0)
    visitIntensityModel(
        *settings_.law,
        settings_.codec.resolution,
        settings_.sensor,
        [&](const auto& model) {
          const auto no_native_intensity = [](std::size_t) { return 0.0f; };
          points_behind_sensor =
              io::setIntensities(model, pose, no_native_intensity, intensities_, view);
        });
  try {
    return encodeView(view, points_behind_sensor, pose, cloud, bytes);
  }
  catch (...) { // memory ran out, between voxels and bytes
    encoder_->requestIFrame();
    throw;
  }
}

io::CompressionStatus
StreamEncoder::encodeView(const io::PointView& view,
                          std::size_t points_behind_sensor,
                          const WorldPose& pose,
                          const CloudToEncode& cloud,
                          std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  io::CompressionStatus status =
      encoder_->voxelize(view, pose, frame_, points_behind_sensor);
  if (!status.ok())
    return status;
  if (cloud.outliers != nullptr)
    cloud.outliers->filter(frame_);
  if (status = encoder_->filterOverTime(frame_); !status.ok())
    return status;
  return encoder_->encode(frame_, cloud.stamp, bytes);
}

void
StreamEncoder::requestIFrame()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (encoder_) // else the next frame is the first
    encoder_->requestIFrame();
}

io::FrameStatistics
StreamEncoder::statistics() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return encoder_ ? encoder_->statistics() : io::FrameStatistics();
}

std::optional<IntensityLaw>
StreamEncoder::law() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return settings_.law;
}

} // namespace python
} // namespace pcl_ext
