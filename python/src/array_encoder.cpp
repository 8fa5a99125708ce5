// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "array_encoder.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace pcl_ext {
namespace python {

ArrayEncoder::ArrayEncoder(const ArrayEncoderSettings& settings) : settings_(settings)
{
  if (settings_.law)
    start(*settings_.law);
}

void
ArrayEncoder::start(IntensityLaw law)
{
  visitIntensityModel(
      law, settings_.codec.resolution, settings_.sensor, [&](const auto& model) {
        const auto model_law = io::depthLawOf(model);
        encoder_.emplace(settings_.codec,
                         std::decay_t<decltype(model)>::unit,
                         model_law ? model_law : settings_.depth_law);
      });
  rate_control_.emplace(settings_.codec, law != IntensityLaw::None);
  if (max_rate_)
    rate_control_->setMaxRate(*max_rate_);
  settings_.law = law;
}

void
ArrayEncoder::checkIntensities(const CloudToEncode& cloud) const
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

/** \brief Begins a cloud, at its stamp or now, and takes the step of the rate control.
 * \return false: there is no room for it
 */
bool
ArrayEncoder::beginCloud(const CloudToEncode& cloud)
{
  begin_ = std::chrono::steady_clock::now();
  const bool has_time = cloud.stamp && cloud.stamp->stamp != 0;
  const io::RateControl::Nanoseconds time =
      has_time ? io::RateControl::timeOfStamp(cloud.stamp->stamp)
               : begin_.time_since_epoch();
  if (!rate_control_->beginCloud(time, encoder_->isIFrameDue()))
    return false;
  if (rate_control_->hasChanged())
    visitIntensityModel(*settings_.law,
                        rate_control_->settings().resolution,
                        settings_.sensor,
                        [&](const auto& model) {
                          const auto model_law = io::depthLawOf(model);
                          encoder_->setSettings(rate_control_->settings(),
                                                model_law ? model_law
                                                          : settings_.depth_law);
                        });
  return true;
}

io::CompressionStatus
ArrayEncoder::encode(const CloudToEncode& cloud, std::vector<std::uint8_t>& bytes)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!encoder_)
    start(automaticLaw(cloud.columns.intensity.has_value()));
  checkIntensities(cloud);
  if (!beginCloud(cloud)) {
    bytes.clear();
    return {io::CompressionCode::LeftOut, rate_control_->leftOutMessage()};
  }
  const bool is_native = *settings_.law == IntensityLaw::Native;
  io::PointView view = viewOf(cloud.columns, is_native, settings_.codec, memory_);
  const WorldPose pose =
      cloud.sensor_pose.value_or(settings_.sensor_pose.value_or(WorldPose::Identity()));
  std::size_t points_behind_sensor = 0;
  if (needsSensor(*settings_.law) && view.count > 0)
    visitIntensityModel(
        *settings_.law,
        encoder_->settings().resolution,
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
ArrayEncoder::encodeView(const io::PointView& view,
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
  std::optional<std::chrono::nanoseconds> time;
  if (cloud.stamp && cloud.stamp->stamp != 0)
    time = io::RateControl::timeOfStamp(cloud.stamp->stamp);
  if (status = encoder_->filterOverTime(frame_, time); !status.ok())
    return status;
  status = encoder_->encode(frame_, cloud.stamp, bytes);
  if (!status.ok() || rate_control_->endFrame(bytes.size(),
                                              encoder_->statistics().coding.is_i_frame,
                                              std::chrono::steady_clock::now() - begin_,
                                              frame_.grid,
                                              encoder_->statistics().sensor_motion))
    return status;
  encoder_->dropLastFrame();
  bytes.clear();
  return {io::CompressionCode::LeftOut, rate_control_->leftOutMessage()};
}

void
ArrayEncoder::setMaxRate(double bits_per_second)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  max_rate_ = bits_per_second;
  if (rate_control_)
    rate_control_->setMaxRate(bits_per_second);
}

io::RateControlStatus
ArrayEncoder::rateControl() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (rate_control_)
    return rate_control_->status();
  io::RateControl rate_control(settings_.codec);
  if (max_rate_)
    rate_control.setMaxRate(*max_rate_);
  return rate_control.status();
}

void
ArrayEncoder::requestIFrame()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (encoder_) // else the next frame is the first
    encoder_->requestIFrame();
}

io::FrameStatistics
ArrayEncoder::statistics() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return encoder_ ? encoder_->statistics() : io::FrameStatistics();
}

std::optional<IntensityLaw>
ArrayEncoder::law() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return settings_.law;
}

} // namespace python
} // namespace pcl_ext
