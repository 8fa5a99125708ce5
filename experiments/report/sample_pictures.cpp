/** \file
 * Writes the clouds, voxels and curves that the report's figures show, as CSV files. One
 * frame of each sensor: the pictures are the same however many frames are measured.
 */
#include <pcl_ext/intensity/intensity_model.h>

#include "labelled_voxels.h"
#include "measuring/command_line.h"
#include "simulator/crop_box.h"
#include "simulator/labelled_lidar.h"

#include <boost/program_options.hpp>

#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace options = boost::program_options;
using pcl_ext::KinectV2;
using pcl_ext::cell::CellFrame;
using pcl_ext::cell::LidarFrame;
using pcl_ext::cell::PointTruth;
using pcl_ext::cell::RobotCell;
using pcl_ext::io::BoundingBox;
using pcl_ext::io::VoxelGrid;
using pcl_ext::noise::LabelledFrame;
using pcl_ext::noise::LabelledStream;
using pcl_ext::report::LabelledVoxel;

constexpr double resolution = 0.04; // metres
constexpr std::uint32_t seed = 1;
/** \brief 5 s on, when the person walks and all arms are about. */
constexpr std::uint32_t shown_frame = 90;
constexpr std::uint32_t shown_revolution = 45;

/** \brief A CSV file that says if it could not be written. */
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
  const pcl_ext::IntensityModel<KinectV2, pcl_ext::CountLaw> count(resolution);
  const pcl_ext::IntensityModel<KinectV2, pcl_ext::QuadraticLaw> quadratic(resolution);
  const pcl_ext::IntensityModel<KinectV2, pcl_ext::LinearLaw> linear(resolution);
  CsvFile file(folder + "/laws.csv", "depth,count,quadratic,linear,cut_off_depth");
  for (int step = 0; step <= 180; ++step) {
    const float depth = 0.1f * static_cast<float>(step);
    file.addRow(
        depth, count(depth), quadratic(depth), linear(depth), quadratic.cutOffDepth());
  }
  file.close();
}

bool
contains(const BoundingBox& box, const Eigen::Vector3f& point)
{
  const Eigen::Array3d place = point.cast<double>();
  return (place >= Eigen::Map<const Eigen::Array3d>(box.min.data())).all() &&
         (place <= Eigen::Map<const Eigen::Array3d>(box.max.data())).all();
}

template <typename PointT>
void
addPoints(unsigned int sensor,
          const pcl::PointCloud<PointT>& cloud,
          const std::vector<PointTruth>& truth,
          const Eigen::Isometry3d& pose,
          const BoundingBox& box,
          CsvFile& file)
{
  const Eigen::Isometry3f to_world = pose.cast<float>();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (truth[i] == PointTruth::None)
      continue;
    const Eigen::Vector3f point = to_world * cloud[i].getVector3fMap();
    if (contains(box, point))
      file.addRow(sensor, point.x(), point.y(), point.z());
  }
}

void
addVoxels(unsigned int sensor,
          const std::vector<LabelledVoxel>& voxels,
          const BoundingBox& box,
          CsvFile& file)
{
  for (const LabelledVoxel& voxel : voxels) {
    if (!contains(box, Eigen::Vector3f(voxel.x, voxel.y, voxel.z)))
      continue;
    file.addRow(sensor,
                voxel.x,
                voxel.y,
                voxel.z,
                voxel.count,
                voxel.quadratic,
                voxel.linear,
                voxel.native,
                voxel.is_noise ? 1 : 0);
  }
}

const char* const point_header = "sensor,x,y,z";
const char* const voxel_header = "sensor,x,y,z,count,quadratic,linear,native,is_noise";

/** \brief Figures 10 and 11: all sensors' points and voxels. */
void
writeCell(const std::string& folder, RobotCell& cell)
{
  CsvFile points(folder + "/cell_points.csv", point_header);
  CsvFile voxels(folder + "/cell_voxels.csv", voxel_header);
  const BoundingBox box = pcl_ext::cell::cropBox();
  CellFrame frame;
  for (unsigned int sensor = 1; sensor <= RobotCell::sensor_count; ++sensor) {
    cell.capture(sensor, shown_frame, frame);
    addPoints(sensor, frame.cloud, frame.truth, cell.sensorPose(sensor), box, points);
    LabelledFrame labelled;
    LabelledStream(seed, sensor, resolution).read(shown_frame, labelled);
    addVoxels(sensor, pcl_ext::report::labelledVoxels(labelled), box, voxels);
  }
  LidarFrame revolution;
  cell.captureLidar(shown_revolution, revolution);
  addPoints(RobotCell::lidar,
            revolution.cloud,
            revolution.truth,
            cell.lidarPose(),
            box,
            points);
  LabelledFrame labelled;
  pcl_ext::noise::LabelledLidar(seed, resolution).read(shown_revolution, labelled);
  addVoxels(RobotCell::lidar, pcl_ext::report::labelledVoxels(labelled), box, voxels);
  points.close();
  voxels.close();
}

/** \brief The cell of the octree that holds a place.
 * \param[in] level above the voxels' own
 */
BoundingBox
octreeCell(const VoxelGrid& grid,
           const std::array<double, 3>& place,
           unsigned int level)
{
  const double edge = grid.resolution * (1u << level);
  BoundingBox cell;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = grid.lowerCorner(axis);
    cell.min[axis] = low + edge * std::floor((place[axis] - low) / edge);
    cell.max[axis] = cell.min[axis] + edge;
  }
  return cell;
}

/** \brief Figure 7: a piece of the conveyor with a carton's corner on it, as sensor 1 sees
 * it, in the cells of the stream's own octree. */
void
writeOctree(const std::string& folder, RobotCell& cell)
{
  LabelledFrame labelled;
  LabelledStream(seed, 1, resolution).read(shown_frame, labelled);
  const VoxelGrid& grid = labelled.of(pcl_ext::noise::Law::Count).grid;
  constexpr std::array<double, 3> corner = {5.76, 3.28, 1.04};
  constexpr unsigned int shown_levels = 3;
  const BoundingBox box = octreeCell(grid, corner, shown_levels);
  CellFrame frame;
  cell.capture(1, shown_frame, frame);
  CsvFile points(folder + "/octree_points.csv", point_header);
  addPoints(1, frame.cloud, frame.truth, cell.sensorPose(1), box, points);
  points.close();
  CsvFile voxels(folder + "/octree_voxels.csv", voxel_header);
  const std::vector<LabelledVoxel> all = pcl_ext::report::labelledVoxels(labelled);
  addVoxels(1, all, box, voxels);
  voxels.close();
  CsvFile cells(folder + "/octree_cells.csv", "level,x,y,z,edge");
  for (unsigned int level = 0; level <= shown_levels; ++level) {
    std::set<std::array<double, 3>> low_corners;
    for (const LabelledVoxel& voxel : all)
      if (contains(box, Eigen::Vector3f(voxel.x, voxel.y, voxel.z)))
        low_corners.insert(octreeCell(grid, {voxel.x, voxel.y, voxel.z}, level).min);
    for (const std::array<double, 3>& low : low_corners)
      cells.addRow(level, low[0], low[1], low[2], grid.resolution * (1u << level));
  }
  cells.close();
}

bool
parse(int argc, const char* const* argv, std::string& folder)
{
  options::options_description description("Writes what the report's figures show.\n"
                                           "Usage: sample_pictures folder\n\nOptions");
  auto option = description.add_options();
  option("help,h", "print this and stop");
  option("folder", options::value(&folder)->required(), "that the CSV files go to");
  options::variables_map values;
  return pcl_ext::measuring::parseCommandLine(
      argc, argv, description, "folder", values);
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    std::string folder;
    if (!parse(argc, argv, folder))
      return 0;
    RobotCell cell(seed);
    writeLaws(folder);
    writeCell(folder, cell);
    writeOctree(folder, cell);
    return 0;
  }
  catch (const std::exception& error) {
    std::cerr << "sample_pictures: " << error.what() << '\n';
    return 1;
  }
}
