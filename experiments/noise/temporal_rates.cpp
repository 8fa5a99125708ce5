#include "temporal_rates.h"

#include <pcl_ext/compression/cloud_encoder.h>

#include "measuring/result_file.h"
#include "nearby_voxels.h"
#include "simulator/robot_cell.h"
#include "temporal_results.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace pcl_ext {
namespace noise {

namespace {

/** \brief Coordinates of points, world, metres. */
class Coordinates {
public:
  void
  clear()
  {
    values_.clear();
  }

  void
  add(const Eigen::Vector3d& point)
  {
    for (const double value : {point.x(), point.y(), point.z()})
      values_.push_back(static_cast<float>(value));
  }

  io::PointView
  view() const
  {
    io::PointView points;
    points.count = values_.size() / 3;
    points.coordinates = values_.data();
    points.coordinate_stride = 3 * sizeof(float);
    return points;
  }

  /** \brief Voxels of a grid that have points, each once, ascending. */
  std::vector<std::uint64_t>
  keys(const io::VoxelGrid& grid) const
  {
    std::vector<std::uint64_t> keys;
    for (std::size_t i = 0; i < values_.size(); i += 3) {
      std::array<std::uint32_t, 3> index{};
      bool is_inside = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at =
            std::floor((static_cast<double>(values_[i + axis]) - grid.origin[axis]) /
                       grid.resolution) -
            grid.first_index[axis];
        is_inside = is_inside && at >= 0.0 && at < static_cast<double>(grid.size());
        index[axis] = is_inside ? static_cast<std::uint32_t>(at) : 0;
      }
      if (is_inside)
        keys.push_back(io::mortonKey({index[0], index[1], index[2]}));
    }
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    return keys;
  }

private:
  std::vector<float> values_;
};

/** \brief A cloud with its truth. */
struct RateCloud {
  Coordinates points;
  Coordinates of_surfaces; ///< those that were measured at a surface
  Coordinates truth;       ///< of the rays, where they meet a surface
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

cell::ErrorModel
errorModel(const RateOptions& options)
{
  cell::ErrorModel model;
  model.depth_noise = options.depth_noise;
  return model;
}

/** \brief The clouds of a sensor. */
class RateClouds {
public:
  RateClouds(unsigned int sensor, const RateOptions& options)
  : sensor_(sensor == hand_camera ? 1 : sensor)
  , cell_(options.seed, errorModel(options))
  {
    if (sensor == hand_camera)
      cell_.moveSensor(sensor_, cell::handCamera);
  }

  double
  rate() const
  {
    return isLidar() ? cell::RobotCell::lidar_rate : cell::RobotCell::frame_rate;
  }

  void
  read(std::uint32_t number, RateCloud& cloud)
  {
    if (isLidar()) {
      cell_.captureLidar(number, lidar_frame_);
      cloud.pose = lidar_frame_.pose;
      add(lidar_frame_, cell_.lidarSurfaces(number), cloud, [this](std::size_t i) {
        return lidar_rays_.direction(i);
      });
      return;
    }
    cell_.capture(sensor_, number, frame_);
    cloud.pose = frame_.pose;
    add(frame_, cell_.surfaces(sensor_, number), cloud, [this](std::size_t i) {
      return Eigen::Vector3d(rays_.x(i % cell::RayGrid::columns),
                             rays_.y(i / cell::RayGrid::columns),
                             1.0);
    });
  }

private:
  bool
  isLidar() const
  {
    return sensor_ == cell::RobotCell::lidar;
  }

  template <typename FrameT, typename DirectionT>
  static void
  add(const FrameT& frame,
      const cell::SurfaceImage& surfaces,
      RateCloud& cloud,
      const DirectionT& direction)
  {
    cloud.points.clear();
    cloud.of_surfaces.clear();
    cloud.truth.clear();
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      const auto& point = frame.cloud[i];
      if (std::isfinite(point.x)) {
        const Eigen::Vector3d in_world =
            frame.pose * point.getVector3fMap().template cast<double>();
        cloud.points.add(in_world);
        if (frame.truth[i] == cell::PointTruth::Surface)
          cloud.of_surfaces.add(in_world);
      }
      if (surfaces.depth[i] > 0.0f)
        cloud.truth.add(frame.pose *
                        (direction(i) * static_cast<double>(surfaces.depth[i])));
    }
  }

  unsigned int sensor_;
  cell::RobotCell cell_;
  cell::CellFrame frame_;
  cell::LidarFrame lidar_frame_;
  cell::RayGrid rays_;
  cell::LidarRays lidar_rays_;
};

/** \brief The stream of an encoder, with what it shows. */
class RateStream {
public:
  RateStream(unsigned int temporal_filter, bool has_crop, double resolution)
  : encoder_(settings(temporal_filter, has_crop, resolution), IntensityUnit::Points)
  {}

  /** \brief Encodes a cloud.
   * \param[in] is_judged whether it counts but for its bytes */
  void
  add(const RateCloud& cloud, std::chrono::nanoseconds time, bool is_judged)
  {
    io::VoxelFrame shown;
    require(encoder_.voxelize(cloud.points.view(), WorldPose(cloud.pose), shown));
    const io::VoxelFrame measured = shown;
    require(encoder_.filterOverTime(shown, time));
    require(encoder_.encode(shown, std::nullopt, bytes_));
    bytes.add(static_cast<double>(bytes_.size()));
    if (!is_judged)
      return;
    is_moving.add(
        encoder_.statistics().sensor_motion == io::SensorMotion::Moving ? 1.0 : 0.0);
    voxels.add(static_cast<double>(shown.size()));
    const auto near = [&shown](const std::vector<std::uint64_t>& keys) {
      NearbyVoxels result;
      result.mark(shown.grid, keys, 0);
      return result;
    };
    off.add(percentFar(shown.keys, near(cloud.truth.keys(shown.grid))));
    not_measured.add(percentFar(shown.keys, near(measured.keys)));
    std::vector<std::uint64_t> of_surfaces;
    for (const std::uint64_t key : cloud.of_surfaces.keys(shown.grid))
      if (std::binary_search(measured.keys.begin(), measured.keys.end(), key))
        of_surfaces.push_back(key);
    surfaces.add(100.0 - percentFar(of_surfaces, near(shown.keys)));
  }

  measuring::Samples bytes;        ///< of each frame
  measuring::Samples voxels;       ///< shown ones
  measuring::Samples off;          ///< shown, but not near a surface, percent
  measuring::Samples not_measured; ///< shown, but nothing measured is near, percent
  measuring::Samples surfaces;     ///< measured ones that are near a shown one, percent
  measuring::Samples is_moving;    ///< 1 where the sensor was recognised as moving

private:
  static io::EncoderSettings
  settings(unsigned int temporal_filter, bool has_crop, double resolution)
  {
    io::EncoderSettings settings;
    settings.resolution = resolution;
    settings.i_frame_rate = 300;
    settings.effort = io::Effort::Balanced;
    settings.temporal_filter = temporal_filter;
    if (has_crop) {
      io::BoundingBox& box = settings.bounding_box.emplace();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<Eigen::Index>(axis);
        box.min[axis] = cell::RobotCell::cropMin()[i];
        box.max[axis] = cell::RobotCell::cropMax()[i];
      }
    }
    return settings;
  }

  static void
  require(const io::CompressionStatus& status)
  {
    if (!status.ok())
      throw std::runtime_error(status.message());
  }

  static double
  percentFar(const std::vector<std::uint64_t>& keys, const NearbyVoxels& near)
  {
    const auto far = std::count_if(keys.begin(), keys.end(), [&](std::uint64_t key) {
      return near.lastTime(key) != 0;
    });
    return keys.empty()
               ? 0.0
               : 100.0 * static_cast<double>(far) / static_cast<double>(keys.size());
  }

  io::CloudEncoder encoder_;
  std::vector<std::uint8_t> bytes_;
};

} // namespace

void
measureRates(unsigned int sensor,
             const RateOptions& options,
             measuring::ResultFile& results)
{
  RateClouds clouds(sensor, options);
  const double rate = clouds.rate() / options.step;
  const bool has_crop = sensor <= cell::RobotCell::sensor_count;
  std::vector<std::pair<std::string, RateStream>> streams;
  streams.emplace_back("none", RateStream(0, has_crop, options.resolution));
  streams.emplace_back("temporal", RateStream(8, has_crop, options.resolution));
  RateCloud cloud;
  for (std::uint32_t i = 0; i < options.frames; ++i) {
    clouds.read(i * options.step, cloud);
    const std::chrono::duration<double> time(1000.0 + i / rate);
    for (auto& [name, stream] : streams)
      stream.add(cloud,
                 std::chrono::duration_cast<std::chrono::nanoseconds>(time),
                 2 * i >= options.frames);
  }
  std::ostringstream experiment;
  experiment << "rates:" << rate << " Hz";
  const double unfiltered = streams.front().second.bytes.sum();
  for (const auto& [name, stream] : streams) {
    const measuring::Subject subject = {experiment.str(),
                                        sensor == hand_camera ? "hand"
                                                              : std::to_string(sensor),
                                        name,
                                        options.resolution};
    results.add(subject, "bytes", stream.bytes);
    results.add(subject,
                "of_unfiltered_percent",
                100.0 * stream.bytes.sum() / unfiltered,
                stream.bytes.count());
    results.add(subject, "voxels", stream.voxels);
    results.add(subject, "off_percent", stream.off);
    results.add(subject, "not_measured_percent", stream.not_measured);
    results.add(subject, "surface_percent", stream.surfaces);
    results.add(subject,
                "surface_worst_percent",
                stream.surfaces.smallest(),
                stream.surfaces.count());
    results.add(
        subject, "moving_frames", stream.is_moving.sum(), stream.voxels.count());
  }
}

} // namespace noise
} // namespace pcl_ext
