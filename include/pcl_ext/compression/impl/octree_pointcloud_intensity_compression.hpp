#pragma once

#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>
#include <pcl_ext/compression/voxel_centres.h>

#include <pcl/console/print.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <exception>
#include <istream>
#include <limits>
#include <new>
#include <ostream>
#include <type_traits>
#include <utility>

namespace pcl_ext {
namespace io {

namespace detail {

/** \brief The settings that PCL's constructor arguments stand for. */
inline IntensityCompressionSettings
settingsOfProfile(pcl::io::compression_Profiles_e profile,
                  bool show_statistics,
                  double octree_resolution,
                  unsigned int i_frame_rate)
{
  IntensityCompressionSettings settings;
  settings.show_statistics = show_statistics;
  settings.resolution = octree_resolution;
  settings.i_frame_rate = i_frame_rate;
  // Whatever is no profile counts as MANUAL_CONFIGURATION.
  const int index = static_cast<int>(profile);
  if (index >= 0 && index < static_cast<int>(pcl::io::COMPRESSION_PROFILE_COUNT)) {
    const auto& configuration = pcl::io::compressionProfiles_[index];
    settings.resolution = configuration.octreeResolution;
    settings.i_frame_rate = configuration.iFrameRate;
    if (profile >= pcl::io::LOW_RES_OFFLINE_COMPRESSION_WITHOUT_COLOR)
      settings.effort = Effort::Small;
  }
  return settings;
}

/** \brief A resolution that PCL's octree accepts, whatever the user's. */
inline double
octreeResolution(const IntensityCompressionSettings& settings)
{
  return checkSettings(settings).ok() ? settings.resolution
                                      : IntensityCompressionSettings().resolution;
}

/** \brief The settings, or the defaults if they are not usable; what is built from them
 * is then never used. */
inline IntensityCompressionSettings
usableSettings(const IntensityCompressionSettings& settings)
{
  return checkSettings(settings).ok() ? settings : IntensityCompressionSettings();
}

/** \brief True if every point is worth exactly 1, which need not be computed. */
template <typename IntensityModelT>
constexpr bool counts_points = false;

template <typename SensorT>
constexpr bool counts_points<IntensityModel<SensorT, CountLaw>> = true;

} // namespace detail

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    OctreePointCloudIntensityCompression(pcl::io::compression_Profiles_e profile,
                                         bool show_statistics,
                                         double /*point_resolution*/,
                                         double octree_resolution,
                                         bool /*do_voxel_grid_down_sampling*/,
                                         unsigned int i_frame_rate,
                                         bool /*do_color_encoding*/,
                                         unsigned char /*color_bit_resolution*/)
: OctreePointCloudIntensityCompression(detail::settingsOfProfile(
      profile, show_statistics, octree_resolution, i_frame_rate))
{}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    OctreePointCloudIntensityCompression(const IntensityCompressionSettings& settings)
: OctreePointCloudIntensityCompression(
      settings, IntensityModelT(detail::octreeResolution(settings)))
{}

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
, settings_status_(checkSettings(settings))
, intensity_model_(intensity_model)
, voxelizer_(detail::usableSettings(settings), IntensityModelT::unit)
, encoder_(settings.format, settings.i_frame_rate, settings.effort)
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
  CompressionStatus status = checkSettings(settings);
  // What memory may fail for comes before anything is changed.
  Voxelizer voxelizer(detail::usableSettings(settings), IntensityModelT::unit);
  settings_ = settings;
  settings_status_ = std::move(status);
  this->deleteTree();
  Base::setResolution(detail::octreeResolution(settings_));
  encoder_.requestIFrame();
  if (!settings_status_.ok())
    return;
  intensity_model_ = modelAtResolution(intensity_model_, resolution);
  voxelizer_ = std::move(voxelizer);
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
  try {
    return encodeFrame(cloud, compressed_cloud);
  }
  catch (const std::bad_alloc&) {
    encoder_.requestIFrame();
    this->deleteTree();
    return outOfMemoryStatus<CompressionStatus>();
  }
  catch (...) { // the output's buffer is other people's code
    encoder_.requestIFrame();
    throw;
  }
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
  if (!settings_status_.ok())
    return settings_status_;
  if (!cloud)
    return {CompressionCode::InvalidInput, "there is no cloud to encode"};
  if (!compressed_cloud.good()) {
    encoder_.requestIFrame();
    return {CompressionCode::OutputFailed,
            "the output stream had failed or ended before; clear() makes it writable"};
  }
  this->setInputCloud(cloud); // as PCL's class does
  if constexpr (!detail::counts_points<IntensityModelT>)
    computeIntensities(*cloud);
  PointView view;
  view.count = cloud->size();
  static_assert(sizeof(PointT) % sizeof(float) == 0,
                "points are read as floats from one x to the next");
  if (!cloud->empty()) {
    view.coordinates = &cloud->front().x;
    view.coordinate_stride = sizeof(PointT) / sizeof(float);
    if constexpr (!detail::counts_points<IntensityModelT>) {
      view.intensities = intensities_.data();
      view.intensity_stride = 1;
    }
  }
  const VoxelizationStatistics voxelization =
      voxelizer_.voxelize(view, encoder_.isIFrameDue(), frame_);
  frame_.depth_model = depthModel(*cloud);

  if (settings_.carry_header) {
    if (!stamp_)
      stamp_.emplace();
    stamp_->stamp = cloud->header.stamp;
    stamp_->frame_id = cloud->header.frame_id;
  }
  if (const CompressionStatus status = encoder_.encode(frame_, stamp_, bytes_);
      !status.ok())
    return status;
  statistics_ = {voxelization, encoder_.statistics()};
  bool is_written = false;
  try {
    compressed_cloud.write(reinterpret_cast<const char*>(bytes_.data()),
                           static_cast<std::streamsize>(bytes_.size()));
    compressed_cloud.flush();
    is_written = compressed_cloud.good();
  }
  catch (const std::exception&) {
    // A stream may be set to throw; the status says the same.
  }
  if (!is_written) {
    encoder_.requestIFrame();
    return {CompressionCode::OutputFailed,
            "the output stream did not take the frame's " +
                std::to_string(bytes_.size()) + " bytes"};
  }
  if (settings_.retain_octree)
    retainOctree();
  if (settings_.show_statistics)
    printStatistics("ENCODING");
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
    status = settings_status_.ok() ? decodeFrame(compressed_cloud, *cloud)
                                   : settings_status_;
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
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    decodeFrame(std::istream& compressed_cloud, PointCloud& cloud)
{
  if (compressed_cloud.rdbuf() == nullptr)
    return {CompressionCode::InputFailed, "the input stream has no buffer"};
  const CompressionStatus status = decoder_.decode(*compressed_cloud.rdbuf(), frame_);
  if (status.code() == CompressionCode::EndOfStream ||
      status.code() == CompressionCode::NoFrame) {
    try {
      compressed_cloud.setstate(std::ios_base::eofbit | std::ios_base::failbit);
    }
    catch (const std::exception&) {
      // A stream may be set to throw; the bits are set all the same.
    }
  }
  if (!status.ok())
    return status;
  statistics_ = {VoxelizationStatistics(), decoder_.statistics()};
  fillCloud(cloud);
  if (decoder_.stamp()) {
    cloud.header.stamp = decoder_.stamp()->stamp;
    cloud.header.frame_id = decoder_.stamp()->frame_id;
  }
  if (settings_.retain_octree)
    retainOctree();
  if (settings_.show_statistics)
    printStatistics("DECODING");
  return status;
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    computeIntensities(const PointCloud& cloud)
{
  const Eigen::Isometry3f pose = sensorPose(cloud);
  const Eigen::Vector3f sensor = pose.translation();
  const Eigen::Vector3f optical_axis = pose.linear().col(2);
  intensities_.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    float depth = 0.0f;
    // The difference first: far from the origin it is exact and the products are not.
    if constexpr (IntensityModelT::uses_depth)
      depth = optical_axis.dot(Eigen::Vector3f(cloud[i].x, cloud[i].y, cloud[i].z) -
                               sensor);
    intensities_[i] = intensity_model_(depth, nativeIntensity(cloud[i], 0.0f));
  }
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
Eigen::Isometry3f
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    sensorPose(const PointCloud& cloud) const
{
  if (settings_.sensor_pose)
    return Eigen::Isometry3f(*settings_.sensor_pose);
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.translation() = cloud.sensor_origin_.template head<3>();
  // Readers fill in whatever their files hold; a quaternion of no length says nothing.
  if (cloud.sensor_orientation_.norm() > 1e-6f)
    pose.linear() = cloud.sensor_orientation_.normalized().toRotationMatrix();
  return pose;
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
std::optional<DepthModel>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    depthModel(const PointCloud& cloud) const
{
  std::optional<DepthLaw> law = settings_.depth_law;
  if constexpr (pcl_ext::detail::DepthExponent<IntensityModelT>::value != 0)
    law = DepthLaw{pcl_ext::detail::DepthExponent<IntensityModelT>::value,
                   intensity_model_.cutOffDepth(),
                   255.0};
  if (!law || settings_.format != StreamFormat::Version1)
    return std::nullopt;
  const Eigen::Isometry3d pose = sensorPose(cloud).template cast<double>();
  const auto elements = [](const Eigen::Vector3d& vector) {
    return std::array<double, 3>{vector.x(), vector.y(), vector.z()};
  };
  return depthModelOf(*law,
                      elements(pose.translation()),
                      elements(pose.linear().col(2)),
                      frame_.grid,
                      frame_.intensity_scale);
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    fillCloud(PointCloud& cloud)
{
  cloud.resize(frame_.size());
  // Static, as the compiler would build one anew on the stack for each point, piece by
  // piece, and the processor waits for a copy of what it has just written in pieces.
  static const PointT blank = PointT();
  VoxelCentres centres;
  for (std::size_t begin = 0; begin < frame_.size(); begin += VoxelCentres::most) {
    const std::size_t count = voxelCentres(frame_, symbol_intensities_, begin, centres);
    PointT* const points = &cloud.points[begin];
    for (std::size_t i = 0; i < count; ++i) {
      PointT& point = points[i];
      point = blank;
      point.x = centres.x[i];
      point.y = centres.y[i];
      point.z = centres.z[i];
      setNativeIntensity(point, centres.intensity[i]);
    }
  }
  cloud.width = static_cast<std::uint32_t>(cloud.size());
  cloud.height = 1;
  cloud.is_dense = true;
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
  this->deleteTree();
  // Set rather than defined: PCL's box arithmetic may round a cube of 2^n voxels up.
  this->resolution_ = grid.resolution;
  const double side = static_cast<double>(grid.size()) * grid.resolution;
  std::array<double, 3> min;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // PCL divides a point's distance from the corner, the codec its coordinate. The
    // corner gives way by the rounding between the two, so that a point on a face is in
    // the same voxel for both.
    const double voxels = std::abs(static_cast<double>(grid.first_index[axis])) +
                          static_cast<double>(grid.size());
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * voxels;
    min[axis] = grid.lowerCorner(axis) - rounding * grid.resolution;
  }
  this->min_x_ = min[0];
  this->min_y_ = min[1];
  this->min_z_ = min[2];
  this->max_x_ = grid.lowerCorner(0) + side;
  this->max_y_ = grid.lowerCorner(1) + side;
  this->max_z_ = grid.lowerCorner(2) + side;
  this->bounding_box_defined_ = true;
  this->setTreeDepth(grid.depth);
  for (std::size_t i = 0; i < frame_.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame_.keys[i]);
    LeafT* leaf = this->createLeaf(position.x, position.y, position.z);
    leaf->addPointIntensity(frame_.intensity_scale.value(frame_.intensities[i]));
  }
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    printStatistics(const char* title) const
{
  const CodedFrameStatistics& coding = statistics_.coding;
  PCL_INFO("*** POINTCLOUD %s ***\n", title);
  PCL_INFO("Frame ID: %u\n", coding.frame_number);
  PCL_INFO("Frame type: %s\n", coding.is_i_frame ? "Intra frame" : "Prediction frame");
  if (statistics_.voxelization.points > 0) {
    const VoxelizationStatistics& voxelization = statistics_.voxelization;
    PCL_INFO("Number of points: %zu, of these not finite: %zu, outside the box: %zu, "
             "outside the grid: %zu\n",
             voxelization.points,
             voxelization.points_not_finite,
             voxelization.points_outside_box,
             voxelization.points_outside_grid);
    PCL_INFO("Compression ratio to 16 bytes a point: %.2f\n",
             statistics_.compressionRatio());
  }
  PCL_INFO("Number of voxels: %zu\n", coding.voxels);
  PCL_INFO("Size of compressed frame: %zu bytes (header %zu, occupancy %zu, intensity "
           "%zu)\n",
           coding.bytes,
           coding.header_bytes,
           coding.occupancy_bytes,
           coding.intensity_bytes);
  PCL_INFO("Bytes per voxel: %.3f\n\n", statistics_.bytesPerVoxel());
}

} // namespace io
} // namespace pcl_ext
