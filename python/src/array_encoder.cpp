// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "array_encoder.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace pcl_ext::python {

ArrayEncoder::ArrayEncoder(const ArrayEncoderSettings& settings) : settings_(settings)
{
  if (settings_.law)
    start(*settings_.law);
}

/** \brief A cloud in columns, with the intensities of the law. */
class ArrayEncoder::Source : public io::CloudSource {
public:
  /** \brief All must outlive this. */
  Source(ArrayEncoder& encoder,
         const CloudToEncode& cloud,
         const WorldPose& sensor_pose)
  : encoder_(encoder), cloud_(cloud), sensor_pose_(sensor_pose)
  {}

  std::optional<io::DepthLaw>
  takeStep(const io::EncoderSettings& step,
           const std::optional<float>& /*min_log_odds*/) override
  {
    return encoder_.depthLawAt(step.resolution);
  }

  io::CompressionStatus
  open(io::OpenedCloud& opened) override
  {
    const ArrayEncoderSettings& settings = encoder_.settings_;
    for (const io::FieldSetting& named : settings.codec.fields)
      for (const UnknownField& field : cloud_.columns.unknown_fields)
        if (field.name == named.name)
          return {io::CompressionCode::InvalidInput,
                  "field '" + field.name + "' cannot be kept: its type is " +
                      field.type + "; it must be " + fieldDemand()};
    const bool is_native = encoder_.law_ == IntensityLaw::Native;
    opened.view = viewOf(cloud_.columns, is_native, settings.codec, encoder_.memory_);
    if (!needsSensor(encoder_.law_) || opened.view.count == 0)
      return {};
    visitIntensityModel(encoder_.law_,
                        encoder_.encoder_->settings().resolution,
                        settings.sensor,
                        [&](const auto& model) {
                          opened.points_behind_sensor = io::setIntensities(
                              model,
                              io::depthAxisOf(sensor_pose_),
                              [](std::size_t) { return 0.0f; }, // none are native
                              encoder_.intensities_,
                              opened.view);
                        });
    return {};
  }

  bool
  removesNoise() const override
  {
    return cloud_.outliers != nullptr;
  }

  void
  removeNoise(io::VoxelFrame& frame) override
  {
    if (cloud_.outliers != nullptr)
      cloud_.outliers->filter(frame);
  }

private:
  ArrayEncoder& encoder_;
  const CloudToEncode& cloud_;
  const WorldPose& sensor_pose_;
};

void
ArrayEncoder::start(IntensityLaw law)
{
  law_ = law;
  const IntensityUnit unit = visitIntensityModel(
      law, settings_.codec.resolution, settings_.sensor, [](const auto& model) {
        return std::decay_t<decltype(model)>::unit;
      });
  encoder_.emplace(settings_.codec, unit, depthLawAt(settings_.codec.resolution));
  if (max_rate_)
    encoder_->setMaxRate(*max_rate_);
}

/** \brief Takes the automatic law of a cloud, which the first one with points decides
 * on; the frames of those before have numbers, too. */
void
ArrayEncoder::chooseLaw(const CloudColumns& columns)
{
  const IntensityLaw law = automaticLaw(columns.intensity.has_value());
  if (encoder_ && law != law_)
    settings_.codec.first_frame_number = encoder_->statistics().coding.frame_number + 1;
  if (!encoder_ || law != law_)
    start(law);
  if (columns.count > 0)
    settings_.law = law;
}

/** \brief The law of the intensities' depth at a resolution, if they follow one. */
std::optional<io::DepthLaw>
ArrayEncoder::depthLawAt(double resolution) const
{
  const auto model_law =
      visitIntensityModel(law_, resolution, settings_.sensor, [](const auto& model) {
        return io::depthLawOf(model);
      });
  return model_law ? model_law : settings_.depth_law;
}

void
ArrayEncoder::checkIntensities(const CloudToEncode& cloud) const
{
  const std::string name = nameOf(law_);
  if (law_ != IntensityLaw::Native) {
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
ArrayEncoder::encode(const CloudToEncode& cloud, std::vector<std::uint8_t>& bytes)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!settings_.law)
    chooseLaw(cloud.columns);
  checkIntensities(cloud);
  io::CloudInfo info;
  info.sensor_pose =
      cloud.sensor_pose.value_or(settings_.sensor_pose.value_or(WorldPose::Identity()));
  if (cloud.stamp && cloud.stamp->stamp != 0)
    info.time = io::timeOfStamp(cloud.stamp->stamp);
  info.stamp = cloud.stamp;
  Source source(*this, cloud, info.sensor_pose);
  return encoder_->encode(source, info, bytes);
}

void
ArrayEncoder::setMaxRate(double bits_per_second)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  max_rate_ = bits_per_second;
  if (encoder_)
    encoder_->setMaxRate(bits_per_second);
}

io::RateControlStatus
ArrayEncoder::rateControl() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (encoder_)
    return encoder_->rateControlStatus();
  io::CloudEncoder encoder(settings_.codec, IntensityUnit::Native);
  if (max_rate_)
    encoder.setMaxRate(*max_rate_);
  return encoder.rateControlStatus();
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

} // namespace pcl_ext::python
