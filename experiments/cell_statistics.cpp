/** \file
 * \brief Prints the workload that the simulated robot cell makes, and what the
 * published coder makes of it.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/intensity/intensity_model.h>

#include "simulator/crop_box.h"
#include "simulator/robot_cell.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <boost/program_options.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using pcl_ext::cell::CellFrame;
using pcl_ext::cell::PointTruth;
using pcl_ext::cell::RobotCell;

struct CroppedPoint {
  pcl::PointXYZI point; ///< world frame, metres; intensity is the depth in the sensor's
  PointTruth truth;
};

std::vector<CroppedPoint>
crop(const CellFrame& frame, const Eigen::Isometry3d& pose)
{
  const Eigen::Isometry3f to_world = pose.cast<float>();
  const Eigen::Array3f min = RobotCell::cropMin().cast<float>().array();
  const Eigen::Array3f max = RobotCell::cropMax().cast<float>().array();
  std::vector<CroppedPoint> cropped;
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    if (frame.truth[i] == PointTruth::None)
      continue;
    CroppedPoint kept;
    kept.point.getVector3fMap() = to_world * frame.cloud[i].getVector3fMap();
    const Eigen::Array3f position = kept.point.getVector3fMap().array();
    if ((position < min).any() || (position > max).any())
      continue;
    kept.point.intensity = frame.cloud[i].z;
    kept.truth = frame.truth[i];
    cropped.push_back(kept);
  }
  return cropped;
}

/** \brief Occupied voxels of the world's grid, and those without a surface point. */
struct VoxelCounts {
  std::size_t occupied = 0;
  std::size_t pure_noise = 0;
};

VoxelCounts
countVoxels(const std::vector<CroppedPoint>& points, double resolution)
{
  std::vector<std::uint64_t> keys;
  for (const CroppedPoint& kept : points) {
    std::uint64_t key = 0;
    for (const float coordinate : {kept.point.x, kept.point.y, kept.point.z})
      key = key << 20 | static_cast<std::uint64_t>(std::floor(coordinate / resolution));
    // Surface points sort first within their voxel.
    keys.push_back(key << 1 | (kept.truth == PointTruth::Surface ? 0u : 1u));
  }
  std::sort(keys.begin(), keys.end());
  VoxelCounts counts;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i > 0 && keys[i] >> 1 == keys[i - 1] >> 1)
      continue;
    ++counts.occupied;
    counts.pure_noise += keys[i] & 1u;
  }
  return counts;
}

/** \brief One stream in the published layout and its running totals. */
class Stream {
public:
  Stream(std::string name, double resolution, bool quadratic)
  : name_(std::move(name))
  , law_(resolution)
  , quadratic_(quadratic)
  , coder_(settings(resolution))
  {}

  void
  add(const std::vector<CroppedPoint>& points)
  {
    const pcl::PointCloud<pcl::PointXYZI>::Ptr cloud(
        new pcl::PointCloud<pcl::PointXYZI>);
    for (const CroppedPoint& kept : points) {
      pcl::PointXYZI point = kept.point;
      point.intensity = quadratic_ ? 255.0f * law_(kept.point.intensity) : 1.0f;
      cloud->push_back(point);
    }
    std::ostringstream bytes;
    if (const auto status = coder_.encodePointCloud(cloud, bytes); !status.ok())
      throw std::runtime_error(status.message());
    bytes_ += coder_.getStatistics().coding.bytes;
    voxels_ += coder_.getStatistics().coding.voxels;
  }

  void
  print() const
  {
    std::cout << std::left << std::setw(36) << name_ << std::right << std::fixed
              << std::setprecision(4)
              << static_cast<double>(bytes_) / static_cast<double>(voxels_)
              << " bytes per voxel\n";
  }

private:
  static pcl_ext::io::IntensityCompressionSettings
  settings(double resolution)
  {
    pcl_ext::io::IntensityCompressionSettings settings;
    settings.resolution = resolution;
    settings.format = pcl_ext::io::StreamFormat::Published;
    settings.bounding_box = pcl_ext::cell::cropBox();
    return settings;
  }

  std::string name_;
  pcl_ext::IntensityModel<pcl_ext::KinectV2, pcl_ext::QuadraticLaw> law_;
  bool quadratic_;
  pcl_ext::io::OctreePointCloudIntensityCompression<pcl::PointXYZI> coder_;
  std::size_t bytes_ = 0;
  std::size_t voxels_ = 0;
};

/** \brief Sums over frames; print() divides by their number. */
struct Totals {
  std::uint32_t frames = 0;
  std::array<std::size_t, 4> image_points{}; ///< by PointTruth
  std::array<std::size_t, 4> cropped_points{};
  VoxelCounts voxels_4cm;
  VoxelCounts voxels_2cm;
  double capture_seconds = 0.0;

  void
  add(const CellFrame& frame, const std::vector<CroppedPoint>& points)
  {
    ++frames;
    for (const PointTruth truth : frame.truth)
      ++image_points[static_cast<std::size_t>(truth)];
    for (const CroppedPoint& kept : points)
      ++cropped_points[static_cast<std::size_t>(kept.truth)];
    const VoxelCounts at_4cm = countVoxels(points, 0.04);
    const VoxelCounts at_2cm = countVoxels(points, 0.02);
    voxels_4cm.occupied += at_4cm.occupied;
    voxels_4cm.pure_noise += at_4cm.pure_noise;
    voxels_2cm.occupied += at_2cm.occupied;
    voxels_2cm.pure_noise += at_2cm.pure_noise;
  }

  void
  print() const
  {
    const auto line = [this](const char* name, std::size_t sum) {
      std::cout << std::left << std::setw(36) << name << std::right << std::fixed
                << std::setprecision(1) << static_cast<double>(sum) / frames << '\n';
    };
    const auto& crop_counts = cropped_points;
    line("points with a return", image_points[1] + image_points[2] + image_points[3]);
    line("cropped points", crop_counts[1] + crop_counts[2] + crop_counts[3]);
    line("  of these flying pixels", crop_counts[2]);
    line("  of these speckle", crop_counts[3]);
    line("voxels, 4 cm", voxels_4cm.occupied);
    line("  of these pure noise", voxels_4cm.pure_noise);
    line("voxels, 2 cm", voxels_2cm.occupied);
    line("  of these pure noise", voxels_2cm.pure_noise);
    std::cout << std::left << std::setw(36) << "captured frames per second"
              << std::right << frames / capture_seconds << '\n';
  }
};

void
measure(unsigned int sensor, std::uint32_t frame_count, std::uint32_t seed)
{
  RobotCell cell(seed);
  const Eigen::Isometry3d pose = cell.sensorPose(sensor);
  Stream count_4cm("published, 4 cm, count", 0.04, false);
  Stream count_2cm("published, 2 cm, count", 0.02, false);
  Stream quadratic_4cm("published, 4 cm, quadratic", 0.04, true);
  Totals totals;
  CellFrame frame;
  cell.capture(sensor, 0, frame); // draws what never moves, once
  for (std::uint32_t i = 0; i < frame_count; ++i) {
    const auto start = std::chrono::steady_clock::now();
    cell.capture(sensor, i, frame);
    totals.capture_seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::vector<CroppedPoint> points = crop(frame, pose);
    totals.add(frame, points);
    for (Stream* stream : {&count_4cm, &count_2cm, &quadratic_4cm})
      stream->add(points);
  }
  std::cout << "sensor " << sensor << ", " << frame_count << " frames, seed " << seed
            << "; averages per frame\n";
  totals.print();
  for (const Stream* stream : {&count_4cm, &count_2cm, &quadratic_4cm})
    stream->print();
}

} // namespace

int
main(int argc, char** argv)
{
  namespace options = boost::program_options;
  unsigned int sensor = 1;
  std::uint32_t frames = 300;
  std::uint32_t seed = 1;
  options::options_description description("Workload of the simulated robot cell");
  description.add_options()("help", "show this text")(
      "sensor", options::value(&sensor)->default_value(1), "sensor, 1 to 6")(
      "frames", options::value(&frames)->default_value(300), "frames to average over")(
      "seed", options::value(&seed)->default_value(1), "seed of the noise");
  try {
    options::variables_map values;
    options::store(options::parse_command_line(argc, argv, description), values);
    options::notify(values);
    if (values.count("help") > 0) {
      std::cout << description;
      return 0;
    }
    if (frames == 0)
      throw std::invalid_argument("--frames must be at least 1");
    measure(sensor, frames, seed);
  }
  catch (const std::exception& error) {
    std::cerr << "cell_statistics: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
