#pragma once

#include <pcl_ext/compression/impl/pcl_conventions.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/compression/voxel_frame.h>

#include <exception>
#include <new>

namespace pcl_ext {
namespace io {

namespace detail {

/** \brief True if every point counts exactly 1, which need not be computed. */
template <typename IntensityModelT>
constexpr bool counts_points = false;

template <typename SensorT>
constexpr bool counts_points<IntensityModel<SensorT, CountLaw>> = true;

/** \brief The depth law of a class: that of its model, if that depends on the depth. */
template <typename IntensityModelT>
std::optional<DepthLaw>
depthLawOf(const IntensityCompressionSettings& settings, const IntensityModelT& model)
{
  const std::optional<DepthLaw> law = io::depthLawOf(model);
  return law ? law : settings.depth_law;
}

/** \brief The settings of the encoder of a class. */
template <typename IntensityModelT>
IntensityCompressionSettings
encoderSettings(const IntensityCompressionSettings& settings,
                const IntensityModelT& model)
{
  IntensityCompressionSettings of_encoder = settings;
  of_encoder.depth_law = depthLawOf(settings, model);
  return of_encoder;
}

/** \brief Pose of the sensor in the frame of a cloud, sensor -> cloud. */
template <typename PointT>
Eigen::Isometry3f
sensorPose(const IntensityCompressionSettings& settings,
           const pcl::PointCloud<PointT>& cloud)
{
  if (settings.sensor_pose)
    return Eigen::Isometry3f(*settings.sensor_pose);
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translation() = cloud.sensor_origin_.template head<3>();
  // Files may hold any quaternion; one of length 0 is ignored.
  if (cloud.sensor_orientation_.norm() > 1e-6f)
    pose.linear() = cloud.sensor_orientation_.normalized().toRotationMatrix();
  return pose;
}

/** \brief Intensities of the points of a cloud. */
template <typename PointT, typename IntensityModelT>
void
computeIntensities(const pcl::PointCloud<PointT>& cloud,
                   const Eigen::Isometry3f& pose,
                   const IntensityModelT& model,
                   std::vector<float>& intensities)
{
  const Eigen::Vector3f sensor = pose.translation();
  const Eigen::Vector3f optical_axis = pose.linear().col(2);
  intensities.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    float depth = 0.0f;
    // The difference first: far from the origin it is exact and the products are not.
    if constexpr (IntensityModelT::uses_depth)
      depth = optical_axis.dot(Eigen::Vector3f(cloud[i].x, cloud[i].y, cloud[i].z) -
                               sensor);
    intensities[i] = model(depth, nativeIntensity(cloud[i], 0.0f));
  }
}

/** \brief One point at the centre of each voxel of a frame, in its order. */
template <typename PointT>
void
fillCloud(const VoxelFrame& frame, pcl::PointCloud<PointT>& cloud)
{
  cloud.resize(frame.size());
  // Static: a local one would be built on the stack for each point, piece by piece, and
  // reading it back at once stalls the processor.
  static const PointT blank = PointT();
  PointT* next = cloud.points.data();
  forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    PointT& point = *next++;
    point = blank;
    point.x = x;
    point.y = y;
    point.z = z;
    setNativeIntensity(point, intensity);
  });
  cloud.width = static_cast<std::uint32_t>(cloud.size());
  cloud.height = 1;
  cloud.is_dense = true;
}

} // namespace detail

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    OctreePointCloudIntensityCompression(const IntensityCompressionSettings& settings,
                                         const IntensityModelT& intensity_model)
: Base(detail::octreeResolution(settings))
, settings_(settings)
, intensity_model_(intensity_model)
, encoder_(detail::encoderSettings(settings, intensity_model), IntensityModelT::unit)
, decoder_(settings.decoder_limits)
{}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    setResolution(double resolution)
{
  IntensityCompressionSettings settings = settings_;
  settings.resolution = resolution;
  const bool is_valid = checkSettings(settings).ok();
  const IntensityModelT model =
      is_valid ? modelAtResolution(intensity_model_, resolution) : intensity_model_;
  // What may throw comes before anything is changed.
  encoder_.setResolution(resolution, detail::depthLawOf(settings, model));
  settings_ = settings;
  intensity_model_ = model;
  this->deleteTree();
  Base::setResolution(detail::octreeResolution(settings_));
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodePointCloud(const PointCloudConstPtr& cloud, std::ostream& compressed_cloud)
{
  CompressionStatus status;
  try {
    status = encodeFrame(cloud, compressed_cloud);
  }
  catch (const std::bad_alloc&) {
    status = outOfMemoryStatus<CompressionStatus>();
  }
  catch (...) { // the output's buffer is the caller's code
    encoder_.requestIFrame();
    throw;
  }
  if (status.code() == CompressionCode::OutputFailed ||
      status.code() == CompressionCode::OutOfMemory)
    encoder_.requestIFrame();
  if (status.code() == CompressionCode::OutOfMemory)
    this->deleteTree();
  return status;
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodeFrame(const PointCloudConstPtr& cloud, std::ostream& compressed_cloud)
{
  if (!encoder_.settingsStatus().ok())
    return encoder_.settingsStatus();
  if (!cloud)
    return {CompressionCode::InvalidInput, "there is no cloud to encode"};
  if (CompressionStatus status = detail::checkOutput(compressed_cloud); !status.ok())
    return status;
  this->setInputCloud(cloud); // as PCL's class does
  PointView view = pointViewOf(*cloud);
  const Eigen::Isometry3f pose = detail::sensorPose(settings_, *cloud);
  if (!detail::counts_points<IntensityModelT> && !cloud->empty()) {
    detail::computeIntensities(*cloud, pose, intensity_model_, intensities_);
    view.intensities = intensities_.data();
    view.intensity_stride = 1;
  }
  if (CompressionStatus status =
          encoder_.voxelize(view, WorldPose(pose.cast<double>()), frame_);
      !status.ok())
    return status;
  if (settings_.carry_header) {
    if (!stamp_)
      stamp_.emplace();
    stamp_->stamp = cloud->header.stamp;
    stamp_->frame_id = cloud->header.frame_id;
  }
  if (CompressionStatus status = encoder_.encode(frame_, stamp_, bytes_); !status.ok())
    return status;
  statistics_ = encoder_.statistics();
  if (CompressionStatus status = detail::writeFrame(bytes_, compressed_cloud);
      !status.ok())
    return status;
  finishFrame("ENCODING");
  return {};
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    decodePointCloud(std::istream& compressed_cloud, PointCloudPtr& cloud)
{
  CompressionStatus status;
  try {
    if (!cloud)
      cloud.reset(new PointCloud);
    output_ = cloud;
    status = encoder_.settingsStatus();
    if (status.ok())
      status = detail::readFrame(compressed_cloud, decoder_, frame_);
    if (status.ok()) {
      statistics_ = {VoxelizationStatistics(), decoder_.statistics()};
      detail::fillCloud(frame_, *cloud);
      if (decoder_.stamp()) {
        cloud->header.stamp = decoder_.stamp()->stamp;
        cloud->header.frame_id = decoder_.stamp()->frame_id;
      }
      finishFrame("DECODING");
    }
  }
  catch (const std::bad_alloc&) {
    this->deleteTree();
    status = outOfMemoryStatus<CompressionStatus>();
  }
  catch (const std::exception&) {
    status = {CompressionCode::InputFailed, "decoding failed"};
  }
  if (!status.ok() && cloud) {
    cloud->clear();
    cloud->is_dense = true;
  }
  return status;
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    retainOctree()
{
  const VoxelGrid& grid = frame_.grid;
  const detail::OctreeBox box = detail::octreeBox(grid);
  this->deleteTree();
  // Set rather than defined: PCL's box arithmetic may round a cube of 2^n voxels up.
  this->resolution_ = grid.resolution;
  this->min_x_ = box.min[0];
  this->min_y_ = box.min[1];
  this->min_z_ = box.min[2];
  this->max_x_ = box.max[0];
  this->max_y_ = box.max[1];
  this->max_z_ = box.max[2];
  this->bounding_box_defined_ = true;
  this->setTreeDepth(grid.depth);
  for (std::size_t i = 0; i < frame_.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame_.keys[i]);
    LeafT* leaf = this->createLeaf(position.x, position.y, position.z);
    leaf->addPointIntensity(frame_.intensity_scale.value(frame_.intensities[i]));
  }
}

} // namespace io
} // namespace pcl_ext
