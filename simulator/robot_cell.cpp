// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/robot_cell.h"

#include "simulator/scene.h"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace pcl_ext {
namespace cell {

namespace {

/** \brief A line of the paper's Table 1: metres and degrees. */
struct TablePose {
  double x, y, z, rot_z, rot_y, rot_x;
};

constexpr TablePose table_1[RobotCell::sensor_count] = {
    {7.798, 0.496, 4.175, 40.170, 0.639, -136.170},
    {1.729, 0.501, 4.135, -45.253, 2.063, -141.490},
    {9.522, 5.275, 4.353, 88.439, -0.072, -143.461},
    {0.553, 4.995, 4.353, -89.208, -0.495, -145.591},
    {8.879, 9.192, 4.194, 126.733, -1.311, -139.272},
    {0.559, 9.136, 4.145, -121.458, -0.487, -137.562}};

double
radians(double degrees)
{
  return degrees * 3.14159265358979323846 / 180.0;
}

void
checkSensor(unsigned int sensor, unsigned int last)
{
  if (sensor < 1 || sensor > last)
    throw std::out_of_range("RobotCell: there is no sensor " + std::to_string(sensor));
}

} // namespace

RobotCell::RobotCell(std::uint32_t seed, const ErrorModel& model)
: seed_(seed), model_(model)
{}

void
RobotCell::moveSensor(unsigned int sensor, SensorMotion motion)
{
  checkSensor(sensor, lidar);
  motions_[sensor - 1] = std::move(motion);
}

Eigen::Isometry3d
RobotCell::sensorPose(unsigned int sensor, std::uint32_t frame) const
{
  checkSensor(sensor, sensor_count);
  if (const SensorMotion& motion = motions_[sensor - 1])
    return motion(frame / frame_rate);
  const TablePose& line = table_1[sensor - 1];
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(line.x, line.y, line.z));
  pose.rotate(Eigen::AngleAxisd(radians(line.rot_z), Eigen::Vector3d::UnitZ()));
  pose.rotate(Eigen::AngleAxisd(radians(line.rot_y), Eigen::Vector3d::UnitY()));
  pose.rotate(Eigen::AngleAxisd(radians(line.rot_x), Eigen::Vector3d::UnitX()));
  return pose;
}

Eigen::Vector3d
RobotCell::cropMin()
{
  return {0.0, 0.0, 0.1};
}

Eigen::Vector3d
RobotCell::cropMax()
{
  return {10.0, 10.0, 4.0};
}

bool
RobotCell::needsDrawing(const Eigen::Isometry3d& pose,
                        std::size_t pixels,
                        StaticView& view)
{
  if (view.drawn && view.pose.matrix() == pose.matrix())
    return false;
  view.drawn = true;
  view.pose = pose;
  view.surfaces = SurfaceImage(pixels);
  return true;
}

const RobotCell::StaticView&
RobotCell::staticView(unsigned int sensor, std::uint32_t frame)
{
  const Eigen::Isometry3d pose = sensorPose(sensor, frame);
  StaticView& view = static_views_[sensor - 1];
  if (needsDrawing(pose, RayGrid::size, view)) {
    rays_.trace(staticEquipment(), pose.inverse(), view.surfaces, nullptr);
    view.errors.resize(RayGrid::size);
    for (std::size_t pixel = 0; pixel < RayGrid::size; ++pixel)
      view.errors[pixel] = model_.pixelError(rays_, view.surfaces, pixel);
  }
  return view;
}

const SurfaceImage&
RobotCell::surfaces(unsigned int sensor, std::uint32_t frame)
{
  const StaticView& view = staticView(sensor, frame);
  surfaces_ = view.surfaces;
  const Eigen::Isometry3d world_to_sensor = view.pose.inverse();
  changed_.clear();
  rays_.trace(
      movingMachines(frame / frame_rate), world_to_sensor, surfaces_, &changed_);
  // Drawn last, so that all pixels that it changes show the person.
  first_of_person_ = changed_.size();
  rays_.trace(walkingPerson(frame / frame_rate), world_to_sensor, surfaces_, &changed_);
  return surfaces_;
}

void
RobotCell::movers(std::vector<Mover>& movers) const
{
  movers.assign(RayGrid::size, Mover::None);
  for (std::size_t i = 0; i < changed_.size(); ++i)
    movers[changed_[i]] = i < first_of_person_ ? Mover::Machine : Mover::Person;
}

void
RobotCell::capture(unsigned int sensor, std::uint32_t frame, CellFrame& out)
{
  surfaces(sensor, frame);
  const StaticView& view = staticView(sensor, frame);
  errors_ = view.errors;
  out.pose = view.pose;
  for (const std::size_t pixel : changed_)
    errors_[pixel] = model_.pixelError(rays_, surfaces_, pixel);
  model_.measure(surfaces_,
                 errors_,
                 mixSeeds(seed_, sensor, frame),
                 mixSeeds(seed_, sensor + sensor_count),
                 measurement_);

  out.cloud.header.stamp = static_cast<std::uint64_t>(frame * 1e6 / frame_rate);
  out.cloud.header.frame_id = "kinect_" + std::to_string(sensor);
  out.cloud.resize(RayGrid::size);
  out.cloud.width = RayGrid::columns;
  out.cloud.height = RayGrid::rows;
  out.cloud.is_dense = false;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t row = 0; row < RayGrid::rows; ++row)
    for (std::size_t column = 0; column < RayGrid::columns; ++column) {
      const std::size_t pixel = row * RayGrid::columns + column;
      pcl::PointXYZ& point = out.cloud[pixel];
      if (measurement_.truth[pixel] == PointTruth::None) {
        point.x = point.y = point.z = nan;
        continue;
      }
      const double depth = measurement_.depth[pixel] / 1000.0;
      point.x = static_cast<float>(rays_.x(column) * depth);
      point.y = static_cast<float>(rays_.y(row) * depth);
      point.z = static_cast<float>(depth);
    }
  out.truth = measurement_.truth;
}

Eigen::Isometry3d
RobotCell::lidarPose(std::uint32_t revolution) const
{
  if (const SensorMotion& motion = motions_[lidar - 1])
    return motion(revolution / lidar_rate);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate(Eigen::Vector3d(9.6, 0.4, 2.5));
  pose.rotate(Eigen::AngleAxisd(radians(135.0), Eigen::Vector3d::UnitZ()));
  pose.rotate(Eigen::AngleAxisd(radians(10.0), Eigen::Vector3d::UnitY()));
  return pose;
}

const SurfaceImage&
RobotCell::lidarSurfaces(std::uint32_t revolution)
{
  const Eigen::Isometry3d pose = lidarPose(revolution);
  const Eigen::Isometry3d world_to_lidar = pose.inverse();
  StaticView& view = static_views_[lidar - 1];
  if (needsDrawing(pose, LidarRays::size, view))
    lidar_rays_.trace(staticEquipment(), world_to_lidar, view.surfaces);
  lidar_surfaces_ = view.surfaces;
  const double time = revolution / lidar_rate;
  for (const Solids& movers : {movingMachines(time), walkingPerson(time)})
    lidar_rays_.trace(movers, world_to_lidar, lidar_surfaces_);
  return lidar_surfaces_;
}

void
RobotCell::captureLidar(std::uint32_t revolution, LidarFrame& out)
{
  // Apart from the seeds of the sensors, which take 1 to 2 * sensor_count.
  constexpr std::uint32_t lidar_seed = 100;
  constexpr std::uint32_t weather_seed = 200;
  const SurfaceImage& surfaces = lidarSurfaces(revolution);
  out.pose = lidarPose(revolution);
  lidar_model_.measure(
      surfaces, mixSeeds(seed_, lidar_seed, revolution), lidar_measurement_);
  lidar_weather_.apply(surfaces,
                       out.pose,
                       lidar_model_,
                       mixSeeds(seed_, weather_seed, revolution),
                       lidar_measurement_);
  out.cloud.header.stamp = static_cast<std::uint64_t>(revolution * 1e6 / lidar_rate);
  out.cloud.header.frame_id = "velodyne_" + std::to_string(lidar);
  out.cloud.resize(LidarRays::size);
  out.cloud.width = LidarRays::columns;
  out.cloud.height = LidarRays::rings;
  out.cloud.is_dense = false;
  for (std::size_t pixel = 0; pixel < LidarRays::size; ++pixel) {
    pcl::PointXYZI& point = out.cloud[pixel];
    point.intensity = lidar_measurement_.intensity[pixel];
    if (lidar_measurement_.truth[pixel] == PointTruth::None)
      point.getVector3fMap().setConstant(std::numeric_limits<float>::quiet_NaN());
    else
      point.getVector3fMap() =
          (lidar_rays_.direction(pixel) * lidar_measurement_.range[pixel])
              .cast<float>();
  }
  out.truth = lidar_measurement_.truth;
}

} // namespace cell
} // namespace pcl_ext
