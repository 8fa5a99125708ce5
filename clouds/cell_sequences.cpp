// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_sequence.h"
#include "clouds/point_fields.h"

#include <cstring>

namespace pcl_ext {
namespace clouds {

namespace {

/** \brief A cloud of the cell as a sensor's driver sends it. */
template <typename PointT>
void
toMessage(const pcl::PointCloud<PointT>& points, pcl::PCLPointCloud2& cloud)
{
  constexpr bool has_intensity = pcl::traits::has_intensity<PointT>::value;
  std::vector<FileField> fields;
  for (const char* name : {"x", "y", "z", "intensity"})
    fields.push_back({name, FieldKind::Real, sizeof(float), 1});
  fields.resize(has_intensity ? 4 : 3);
  startCloud(fields, points.width, points.height, cloud);
  if (has_intensity)
    cloud.fields.back().offset = 4 * sizeof(float); // after the fourth float of a point
  cloud.point_step = sizeof(PointT);
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.header = points.header;
  cloud.is_dense = points.is_dense ? 1 : 0;
  cloud.data.resize(points.size() * sizeof(PointT));
  std::memcpy(cloud.data.data(), points.points.data(), cloud.data.size());
}

class CellSequence : public CloudSequence {
public:
  CellSequence(unsigned int sensor, std::size_t frames, std::uint32_t seed)
  : CloudSequence("cell_sensor_" + std::to_string(sensor))
  , sensor_(sensor)
  , frames_(frames)
  , cell_(seed)
  {
    cell_.sensorPose(sensor); // throws if there is no such sensor
  }

  std::size_t
  size() const override
  {
    return frames_;
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return cell_.sensorPose(sensor_);
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    cell_.capture(sensor_, static_cast<std::uint32_t>(index), frame_);
    toMessage(frame_.cloud, cloud);
  }

private:
  unsigned int sensor_;
  std::size_t frames_;
  cell::RobotCell cell_;
  cell::CellFrame frame_;
};

class LidarSequence : public CloudSequence {
public:
  LidarSequence(std::size_t revolutions, std::uint32_t seed)
  : CloudSequence("cell_sensor_" + std::to_string(cell::RobotCell::lidar))
  , revolutions_(revolutions)
  , cell_(seed)
  {}

  std::size_t
  size() const override
  {
    return revolutions_;
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return cell_.lidarPose();
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    cell_.captureLidar(static_cast<std::uint32_t>(index), frame_);
    toMessage(frame_.cloud, cloud);
  }

private:
  std::size_t revolutions_;
  cell::RobotCell cell_;
  cell::LidarFrame frame_;
};

} // namespace

std::unique_ptr<CloudSequence>
openCell(unsigned int sensor, std::size_t frames, std::uint32_t seed)
{
  return std::make_unique<CellSequence>(sensor, frames, seed);
}

std::unique_ptr<CloudSequence>
openCellLidar(std::size_t revolutions, std::uint32_t seed)
{
  return std::make_unique<LidarSequence>(revolutions, seed);
}

} // namespace clouds
} // namespace pcl_ext
