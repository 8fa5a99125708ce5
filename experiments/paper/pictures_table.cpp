// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Writes the clouds, voxels and curves that the report's pictures show, as CSV files.
 * One frame of each sensor: the pictures are the same however many frames are measured.
 */
#include <pcl_ext/intensity/intensity_model.h>

#include "experiments/tables.h"
#include "simulator/crop_box.h"
#include "simulator/labelled_lidar.h"
#include "simulator/labelled_stream.h"

#include <cmath>
#include <fstream>
#include <iomanip>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace experiments {

namespace {

using cell::CellFrame;
using cell::LidarFrame;
using cell::PointTruth;
using cell::RobotCell;
using io::BoundingBox;
using noise::LabelledFrame;
using noise::LabelledStream;
using noise::Law;

constexpr double resolution = 0.04; // metres
constexpr std::uint32_t seed = 1;
/** \brief At 4.5 s the person walks and all arms are in the cell. */
constexpr std::uint32_t shown_frame = 90;
constexpr std::uint32_t shown_revolution = 45;

/** \brief A CSV file; reports if it could not be written. */
class CsvFile {
public:
  CsvFile(const std::string& path, const std::string& header) : path_(path), file_(path)
  {
    file_ << std::fixed << std::setprecision(4) << header << '\n';
  }

  template <typename FirstT, typename... RestT>
  void
  addRow(const FirstT& first, const RestT&... rest)
  {
    file_ << first;
    ((file_ << ',' << rest), ...);
    file_ << '\n';
  }

  void
  close()
  {
    file_.close();
    if (!file_)
      throw std::runtime_error("cannot write '" + path_ + "'");
  }

private:
  std::string path_;
  std::ofstream file_;
};

/** \brief Figure 5: the intensity of a point over its depth. */
void
writeLaws(const std::string& folder)
{
  const IntensityModel<KinectV2, CountLaw> count(resolution);
  const IntensityModel<KinectV2, QuadraticLaw> quadratic(resolution);
  const IntensityModel<KinectV2, LinearLaw> linear(resolution);
  CsvFile file(folder + "/laws.csv", "depth,count,quadratic,linear,cut_off_depth");
  for (int step = 0; step <= 180; ++step) {
    const float depth = 0.1f * static_cast<float>(step);
    file.addRow(
        depth, count(depth), quadratic(depth), linear(depth), quadratic.cutOffDepth());
  }
  file.close();
}

bool
contains(const BoundingBox& box, const Eigen::Vector3d& place)
{
  return (place.array() >= Eigen::Map<const Eigen::Array3d>(box.min.data())).all() &&
         (place.array() <= Eigen::Map<const Eigen::Array3d>(box.max.data())).all();
}

const char* const point_header = "sensor,x,y,z";

/** \brief Adds the points of a frame that lie in a box. */
template <typename FrameT>
void
addPoints(unsigned int sensor,
          const FrameT& frame,
          const Eigen::Isometry3d& to_world,
          const BoundingBox& box,
          CsvFile& file)
{
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    if (frame.truth[i] == PointTruth::None)
      continue;
    const Eigen::Vector3d place =
        (to_world.cast<float>() * frame.cloud[i].getVector3fMap())
            .template cast<double>();
    if (contains(box, place))
      file.addRow(sensor, place.x(), place.y(), place.z());
  }
}

const char* const voxel_header = "sensor,x,y,z,count,quadratic,linear,is_noise";

/** \brief Adds the voxels of a frame whose centres lie in a box, with their decoded
 * intensities; those of laws that the sensor does not have are 0. */
void
addVoxels(unsigned int sensor,
          const LabelledFrame& frame,
          const BoundingBox& box,
          CsvFile& file)
{
  const io::VoxelFrame& voxels = frame.of(Law::Count);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const Eigen::Vector3d centre = noise::centreOf(voxels.grid, voxels.keys[i]);
    if (!contains(box, centre))
      continue;
    const auto intensity = [&](Law law) {
      const io::VoxelFrame& of_law = frame.of(law);
      return of_law.size() > 0 ? of_law.intensity_scale.value(of_law.intensities[i])
                               : 0.0f;
    };
    const bool is_noise = frame.truth[i] == noise::VoxelTruth::Noise;
    file.addRow(sensor,
                centre.x(),
                centre.y(),
                centre.z(),
                intensity(Law::Count),
                intensity(Law::Quadratic),
                intensity(Law::Linear),
                is_noise ? 1 : 0);
  }
}

/** \brief Figures 10 and 11: all sensors' points and voxels. */
void
writeCell(const std::string& folder, RobotCell& cell)
{
  CsvFile points(folder + "/cell_points.csv", point_header);
  CsvFile voxels(folder + "/cell_voxels.csv", voxel_header);
  const BoundingBox box = cell::cropBox();
  CellFrame frame;
  LabelledFrame labelled;
  for (unsigned int sensor = 1; sensor <= RobotCell::sensor_count; ++sensor) {
    cell.capture(sensor, shown_frame, frame);
    addPoints(sensor, frame, cell.sensorPose(sensor), box, points);
    LabelledStream(seed, sensor, resolution).read(shown_frame, labelled);
    addVoxels(sensor, labelled, box, voxels);
  }
  LidarFrame revolution;
  cell.captureLidar(shown_revolution, revolution);
  addPoints(RobotCell::lidar, revolution, cell.lidarPose(), box, points);
  LabelledFrame of_lidar;
  noise::LabelledLidar(seed, resolution).read(shown_revolution, of_lidar);
  addVoxels(RobotCell::lidar, of_lidar, box, voxels);
  points.close();
  voxels.close();
}

/** \brief Figure 7: a cell of eight leaves of the stream's octree, on a carton's edge
 * as sensor 1 sees it. */
void
writeOctree(const std::string& folder, RobotCell& cell)
{
  constexpr double edge = 2.0 * resolution;
  const Eigen::Vector3d place(5.64, 4.21, 1.23);
  BoundingBox box;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    box.min[i] = edge * std::floor(place[axis] / edge);
    box.max[i] = box.min[i] + edge;
  }
  CellFrame frame;
  cell.capture(1, shown_frame, frame);
  CsvFile points(folder + "/octree_points.csv", point_header);
  addPoints(1, frame, cell.sensorPose(1), box, points);
  points.close();
  LabelledFrame labelled;
  LabelledStream(seed, 1, resolution).read(shown_frame, labelled);
  CsvFile voxels(folder + "/octree_voxels.csv", voxel_header);
  addVoxels(1, labelled, box, voxels);
  voxels.close();
}

} // namespace

void
writePictures(const Options& options, std::ostream& /* output */)
{
  RobotCell cell(seed);
  writeLaws(options.folder);
  writeCell(options.folder, cell);
  writeOctree(options.folder, cell);
}

} // namespace experiments
} // namespace pcl_ext
