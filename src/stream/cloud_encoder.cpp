#include <pcl_ext/compression/cloud_encoder.h>

#include "bytes/exceptions.h"
#include "stream/frame_warnings.h"
#include "voxels/grid_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

/** \brief The settings, or the defaults if they are invalid, to construct members that are
 * then not used. */
IntensityCompressionSettings
usableSettings(const IntensityCompressionSettings& settings)
{
  return checkSettings(settings).ok() ? settings : IntensityCompressionSettings();
}

std::array<double, 3>
elementsOf(const Eigen::Vector3d& vector)
{
  return {vector.x(), vector.y(), vector.z()};
}

} // namespace

CloudEncoder::CloudEncoder(const IntensityCompressionSettings& settings,
                           IntensityUnit unit)
: settings_(settings)
, settings_status_(checkSettings(settings))
, unit_(unit)
, voxelizer_(usableSettings(settings), unit)
, encoder_(settings.format, settings.i_frame_rate, settings.effort)
{}

void
CloudEncoder::setResolution(double resolution, const std::optional<DepthLaw>& depth_law)
{
  IntensityCompressionSettings settings = settings_;
  settings.resolution = resolution;
  settings.depth_law = depth_law;
  CompressionStatus status = checkSettings(settings);
  // May throw, so it comes before the changes.
  Voxelizer voxelizer(usableSettings(settings), unit_);
  settings_ = settings;
  settings_status_ = std::move(status);
  encoder_.requestIFrame();
  if (settings_status_.ok()) {
    voxelizer_ = std::move(voxelizer);
    doublings_ = 0;
  }
}

CompressionStatus
CloudEncoder::voxelize(const PointView& points,
                       const WorldPose& sensor_pose,
                       VoxelFrame& frame)
{
  if (!settings_status_.ok())
    return settings_status_;
  const auto voxelize = [&] {
    if (settings_.coarsen_wide_clouds && unit_ != IntensityUnit::Share)
      voxelizeWide(points, frame);
    else
      voxelization_ = voxelizer_.voxelize(points, encoder_.isIFrameDue(), frame);
    return CompressionStatus();
  };
  const auto out_of_memory = [this] {
    encoder_.requestIFrame();
    return outOfMemoryStatus<CompressionStatus>();
  };
  if (CompressionStatus status = callOrElse(voxelize, out_of_memory); !status.ok())
    return status;
  frame.depth_model.reset();
  if (settings_.depth_law && settings_.format == StreamFormat::Version1 &&
      frame.hasIntensities())
    frame.depth_model = depthModelOf(*settings_.depth_law,
                                     elementsOf(sensor_pose.translation()),
                                     elementsOf(sensor_pose.linear().col(2)),
                                     frame.grid,
                                     frame.intensity_scale);
  return {};
}

/** \brief Voxelizes at the lowest number of doublings with which all points are on the grid,
 * or most if some are far out. */
void
CloudEncoder::voxelizeWide(const PointView& points, VoxelFrame& frame)
{
  constexpr unsigned int most_doublings = 11; // PCL's octree has 32 levels, the grid 21
  constexpr unsigned int most_for_few = 2;
  const auto arePointsOutside = [&](std::size_t share) {
    return share * voxelization_.points_outside_grid > points.count;
  };
  const bool is_i_frame_due = encoder_.isIFrameDue();
  if (is_i_frame_due && doublings_ > 0)
    voxelizeCoarsened(points, 0, frame);
  else
    voxelization_ = voxelizer_.voxelize(points, is_i_frame_due, frame);
  while (arePointsOutside(16) && doublings_ < most_doublings)
    voxelizeCoarsened(points, doublings_ + 1, frame);
  if (voxelization_.points_outside_grid == 0 ||
      !(is_i_frame_due || encoder_.isIFrameDue()))
    return;
  const unsigned int for_most = doublings_;
  while (voxelization_.points_outside_grid > 0 &&
         doublings_ < std::min(for_most + most_for_few, most_doublings))
    voxelizeCoarsened(points, doublings_ + 1, frame);
  if (voxelization_.points_outside_grid > 0)
    voxelizeCoarsened(points, for_most, frame);
}

/** \brief Voxelizes a cloud and the following ones with another edge. */
void
CloudEncoder::voxelizeCoarsened(const PointView& points,
                                unsigned int doublings,
                                VoxelFrame& frame)
{
  IntensityCompressionSettings settings = settings_;
  settings.resolution =
      std::min(std::ldexp(settings_.resolution, static_cast<int>(doublings)),
               largest_resolution);
  voxelizer_ = Voxelizer(settings, unit_);
  doublings_ = doublings;
  encoder_.requestIFrame();
  voxelization_ = voxelizer_.voxelize(points, true, frame);
}

CompressionStatus
CloudEncoder::encode(const VoxelFrame& frame,
                     const std::optional<FrameStamp>& stamp,
                     std::vector<std::uint8_t>& bytes)
{
  bytes.clear();
  if (!settings_status_.ok())
    return settings_status_;
  CompressionStatus status = encoder_.encode(frame, stamp, bytes);
  if (!status.ok())
    return status;
  statistics_ = {voxelization_, encoder_.statistics()};
  // Without memory for it the frame goes out without the warning.
  return callOrElse(
      [this] {
        return CompressionStatus(CompressionCode::Ok,
                                 frameWarning(statistics_, settings_, unit_));
      },
      [] { return CompressionStatus(); });
}

} // namespace io
} // namespace pcl_ext
