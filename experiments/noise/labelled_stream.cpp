#include "labelled_stream.h"

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/depth_model.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace pcl_ext {
namespace noise {

namespace {

io::IntensityCompressionSettings
voxelSettings(double resolution)
{
  io::IntensityCompressionSettings settings;
  settings.resolution = resolution;
  settings.bounding_box.emplace();
  for (int axis = 0; axis < 3; ++axis) {
    settings.bounding_box->min[static_cast<std::size_t>(axis)] =
        cell::RobotCell::cropMin()[axis];
    settings.bounding_box->max[static_cast<std::size_t>(axis)] =
        cell::RobotCell::cropMax()[axis];
  }
  return settings;
}

std::array<double, 3>
elements(const Eigen::Vector3d& vector)
{
  return {vector.x(), vector.y(), vector.z()};
}

} // namespace

std::string
nameOf(Law law)
{
  switch (law) {
  case Law::Quadratic:
    return "quadratic";
  case Law::Linear:
    return "linear";
  case Law::Count:
    break;
  }
  return "count";
}

template <typename LawT>
LabelledStream::Voxels<LawT>::Voxels(double resolution, const Eigen::Isometry3d& pose)
: model_(resolution)
, pose_(pose)
, preprocessor_(model_)
, voxelizer_(voxelSettings(resolution), LawT::unit)
{
  preprocessor_.setSensorPose(pose);
  preprocessor_.setCropBox(cell::RobotCell::cropMin().cast<float>(),
                           cell::RobotCell::cropMax().cast<float>());
}

template <typename LawT>
void
LabelledStream::Voxels<LawT>::make(const pcl::PointCloud<pcl::PointXYZ>& cloud,
                                   io::VoxelFrame& frame)
{
  if (const auto status = preprocessor_.process(cloud, points_); !status.ok())
    throw std::runtime_error(status.message());
  io::PointView view;
  view.count = points_.size();
  if (!points_.empty()) {
    constexpr std::size_t stride = sizeof(pcl::PointXYZI) / sizeof(float);
    view.coordinates = &points_.front().x;
    view.coordinate_stride = stride;
    view.intensities = &points_.front().intensity;
    view.intensity_stride = stride;
  }
  voxelizer_.voxelize(view, false, frame);
  frame.depth_model.reset();
  if constexpr (LawT::uses_depth)
    frame.depth_model =
        io::depthModelOf({LawT::depth_exponent, model_.cutOffDepth(), 255.0},
                         elements(pose_.translation()),
                         elements(pose_.linear().col(2)),
                         frame.grid,
                         frame.intensity_scale);
}

LabelledStream::LabelledStream(std::uint32_t seed,
                               unsigned int sensor,
                               double resolution)
: sensor_(sensor)
, cell_(seed)
, count_(resolution, cell_.sensorPose(sensor))
, quadratic_(resolution, cell_.sensorPose(sensor))
, linear_(resolution, cell_.sensorPose(sensor))
{}

void
LabelledStream::keysOf(cell::Mover mover, std::vector<std::uint64_t>& keys)
{
  const float nan = std::numeric_limits<float>::quiet_NaN();
  surfaces_ = captured_.cloud;
  for (std::size_t pixel = 0; pixel < surfaces_.size(); ++pixel)
    if (captured_.truth[pixel] != cell::PointTruth::Surface || movers_[pixel] != mover)
      surfaces_[pixel].x = nan;
  count_.make(surfaces_, surface_voxels_);
  keys = surface_voxels_.keys;
}

void
LabelledStream::read(std::uint32_t number, LabelledFrame& frame)
{
  cell_.capture(sensor_, number, captured_);
  cell_.movers(movers_);
  count_.make(captured_.cloud, frame.voxels[static_cast<std::size_t>(Law::Count)]);
  quadratic_.make(captured_.cloud,
                  frame.voxels[static_cast<std::size_t>(Law::Quadratic)]);
  linear_.make(captured_.cloud, frame.voxels[static_cast<std::size_t>(Law::Linear)]);

  const io::VoxelFrame& voxels = frame.of(Law::Count);
  frame.truth.assign(voxels.size(), VoxelTruth::Noise);
  std::vector<std::uint64_t> keys;
  // The later ones win.
  for (const auto& [mover, truth] :
       {std::pair(cell::Mover::Machine, VoxelTruth::Machine),
        std::pair(cell::Mover::Person, VoxelTruth::Person),
        std::pair(cell::Mover::None, VoxelTruth::Still)}) {
    keysOf(mover, keys);
    for (const std::uint64_t key : keys) {
      const auto found = std::lower_bound(voxels.keys.begin(), voxels.keys.end(), key);
      if (found == voxels.keys.end() || *found != key)
        throw std::logic_error("a surface's voxel is not among the frame's");
      frame.truth[static_cast<std::size_t>(found - voxels.keys.begin())] = truth;
    }
  }

  const Eigen::Isometry3d world_to_sensor = cell_.sensorPose(sensor_).inverse();
  frame.depth.resize(voxels.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const io::VoxelPosition position = io::voxelPosition(voxels.keys[i]);
    const Eigen::Vector3d centre(voxels.grid.centre(0, position.x),
                                 voxels.grid.centre(1, position.y),
                                 voxels.grid.centre(2, position.z));
    frame.depth[i] = static_cast<float>((world_to_sensor * centre).z());
  }
}

} // namespace noise
} // namespace pcl_ext
