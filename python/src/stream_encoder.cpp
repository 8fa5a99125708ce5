#include "stream_encoder.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace pcl_ext {
namespace python {

namespace {

/** \brief Intensities of points by their depth, as computed for PCL's clouds.
 * \return number of points with a negative depth
 */
template <typename IntensityModelT>
std::size_t
computeIntensities(const io::PointView& points,
                   const io::SensorPose& pose,
                   const IntensityModelT& model,
                   std::vector<float>& intensities)
{
  const Eigen::Vector3f sensor = pose.translation();
  const Eigen::Vector3f optical_axis = pose.linear().col(2);
  intensities.resize(points.count);
  std::size_t behind_sensor = 0;
  const float* point = points.coordinates;
  for (float& intensity : intensities) {
    // The difference first: it is exact far from the origin, products are not.
    const float depth =
        optical_axis.dot(Eigen::Vector3f(point[0], point[1], point[2]) - sensor);
    behind_sensor += depth < 0.0f ? 1 : 0;
    intensity = model(depth);
    point += points.coordinate_stride;
  }
  return behind_sensor;
}

} // namespace

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
        io::IntensityCompressionSettings codec = settings_.codec;
        if (const auto depth_law = io::depthLawOf(model))
          codec.depth_law = depth_law;
        encoder_.emplace(codec, std::decay_t<decltype(model)>::unit);
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
    start(cloud.columns.intensity ? IntensityLaw::Native : IntensityLaw::Count);
  checkIntensities(cloud);
  const bool is_native = *settings_.law == IntensityLaw::Native;
  io::PointView view = viewOf(cloud.columns, is_native, memory_);
  io::SensorPose pose =
      settings_.codec.sensor_pose.value_or(io::SensorPose::Identity());
  if (cloud.sensor_pose)
    pose = *cloud.sensor_pose;
  if (needsSensor(*settings_.law) && view.count > 0) {
    view.count_behind_sensor = visitIntensityModel(
        *settings_.law,
        settings_.codec.resolution,
        settings_.sensor,
        [&](const auto& model) -> std::size_t {
          if constexpr (std::decay_t<decltype(model)>::uses_depth)
            return computeIntensities(view, pose, model, intensities_);
          else
            return 0;
        });
    view.intensities = intensities_.data();
    view.intensity_stride = 1;
  }
  try {
    return encodeView(view, pose, cloud, bytes);
  }
  catch (...) { // memory ran out, between voxels and bytes
    encoder_->requestIFrame();
    throw;
  }
}

io::CompressionStatus
StreamEncoder::encodeView(const io::PointView& view,
                          const io::SensorPose& pose,
                          const CloudToEncode& cloud,
                          std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  io::CompressionStatus status = encoder_->voxelize(view, pose.cast<double>(), frame_);
  if (!status.ok())
    return status;
  if (cloud.outliers != nullptr)
    cloud.outliers->filter(frame_);
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
