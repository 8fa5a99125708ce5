// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/impl/cloud_sources.h>
#include <pcl_ext/compression/impl/pcl_conventions.h>
#include <pcl_ext/compression/impl/point_fields.h>
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <new>
#include <type_traits>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace detail {

/** \brief The points of a frame, see forEachPoint(); those that are missing are not a
 * number. */
template <typename PointT>
void
fillCloud(const VoxelFrame& frame, pcl::PointCloud<PointT>& cloud)
{
  // Static: g++ would build local ones member by member for each point, and copying them
  // immediately afterwards stalls the processor. White, as PCL has points without a
  // colour.
  static const PointT blank = [] {
    PointT point;
    setColour(point, {255, 255, 255});
    return point;
  }();
  static const PointT missing = [] {
    PointT point = blank;
    point.x = point.y = point.z = std::numeric_limits<float>::quiet_NaN();
    return point;
  }();
  cloud.resize(frame.cloudSize());
  cloud.width = static_cast<std::uint32_t>(frame.cloudWidth());
  cloud.height = frame.cloudHeight();
  cloud.is_dense = frame.isDense();
  if (!cloud.is_dense)
    std::fill(cloud.points.begin(), cloud.points.end(), missing);
  PointT* const points = cloud.points.data();
  forEachPoint(frame,
               [&frame, points](std::size_t i,
                                auto x,
                                auto y,
                                auto z,
                                float intensity,
                                const VoxelColour& colour) {
                 PointT& point = points[frame.cloudIndex(i)];
                 point = blank;
                 point.x = static_cast<float>(x);
                 point.y = static_cast<float>(y);
                 point.z = static_cast<float>(z);
                 setNativeIntensity(point, intensity);
                 setColour(point, colour);
               });
  if (!frame.fields.empty()) // the list of the type's fields takes memory
    pointFieldsOf<PointT>().set(frame, cloud.points.data(), sizeof(PointT));
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
, intensity_model_(intensity_model)
, streams_(settings, depthLawOf(intensity_model), IntensityModelT::unit)
{}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    ~OctreePointCloudIntensityCompression() = default;

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    setResolution(double resolution)
{
  IntensityCompressionSettings changed = settings();
  changed.resolution = resolution;
  const IntensityModelT model = checkSettings(changed).ok()
                                    ? modelAtResolution(intensity_model_, resolution)
                                    : intensity_model_;
  // May throw, so it comes before the other changes.
  streams_.setResolution(resolution, depthLawOf(model));
  intensity_model_ = model;
  this->deleteTree();
  Base::setResolution(detail::octreeResolution(changed));
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    OctreePointCloudIntensityCompression(OctreePointCloudIntensityCompression&& source)
: Base(source.resolution_)
, intensity_model_(std::move(source.intensity_model_))
, streams_(std::move(source.streams_))
, output_(std::move(source.output_))
, intensities_(std::move(source.intensities_))
{
  takeOctree(source);
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>&
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
operator=(OctreePointCloudIntensityCompression&& source)
{
  intensity_model_ = std::move(source.intensity_model_);
  streams_ = std::move(source.streams_);
  output_ = std::move(source.output_);
  intensities_ = std::move(source.intensities_);
  this->deleteTree();
  Base::setResolution(source.resolution_);
  takeOctree(source);
  return *this;
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
void
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    takeOctree(OctreePointCloudIntensityCompression& source)
{
  this->setInputCloud(source.getInputCloud(), source.getIndices());
  if (source.getLeafCount() > 0)
    retainOctree();
  source.deleteTree();
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
  std::vector<std::uint8_t>& bytes = streams_.bytes();
  return encodeTo(&compressed_cloud, bytes, [&] { return encodeFrame(cloud, bytes); });
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodePointCloud(const PointCloudConstPtr& cloud,
                     std::vector<std::uint8_t>& compressed_cloud)
{
  std::vector<std::uint8_t>& bytes = compressed_cloud;
  return encodeTo(nullptr, bytes, [&] { return encodeFrame(cloud, bytes); });
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
template <typename TreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodeOctree(TreeT& tree, std::ostream& compressed_cloud)
{
  std::vector<std::uint8_t>& bytes = streams_.bytes();
  return encodeTo(&compressed_cloud, bytes, [&] { return encodeLeaves(tree, bytes); });
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
template <typename TreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodeOctree(TreeT& tree, std::vector<std::uint8_t>& compressed_cloud)
{
  std::vector<std::uint8_t>& bytes = compressed_cloud;
  return encodeTo(nullptr, bytes, [&] { return encodeLeaves(tree, bytes); });
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
template <typename EncodeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodeTo(std::ostream* output, std::vector<std::uint8_t>& bytes, EncodeT encode)
{
  CompressionStatus status;
  try {
    if (output != nullptr)
      status = streams_.checkOutput(*output);
    if (status.ok())
      status = encode();
    if (status.ok() && output != nullptr)
      if (CompressionStatus written = streams_.write(bytes, *output); !written.ok())
        status = std::move(written);
    if (status.ok())
      finishFrame("ENCODING");
  }
  catch (const std::bad_alloc&) {
    status = outOfMemoryStatus<CompressionStatus>();
  }
  catch (...) { // from the buffer of the caller's stream
    requestIFrame();
    throw;
  }
  if (status.code() == CompressionCode::OutputFailed ||
      status.code() == CompressionCode::OutOfMemory)
    requestIFrame();
  if (status.code() == CompressionCode::OutOfMemory)
    this->deleteTree();
  if (!status.ok())
    bytes.clear();
  return status;
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodeFrame(const PointCloudConstPtr& cloud, std::vector<std::uint8_t>& bytes)
{
  if (CompressionStatus status = streams_.checkEncoding(cloud != nullptr); !status.ok())
    return status;
  if (IntensityModelT::uses_depth && !settings().sensor_pose)
    if (CompressionStatus status =
            detail::checkSensorPose(cloud->sensor_origin_, cloud->sensor_orientation_);
        !status.ok())
      return status;
  this->setInputCloud(cloud); // as PCL's class does
  const SensorPose pose =
      detail::sensorPose(settings(), cloud->sensor_origin_, cloud->sensor_orientation_);
  detail::PointSource<PointT, IntensityModelT> source(intensity_model_,
                                                      streams_,
                                                      *cloud,
                                                      detail::depthAxisOfSensor(pose),
                                                      intensities_);
  return streams_.encode(source, pose, cloud->header, bytes);
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
template <typename TreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    encodeLeaves(TreeT& tree, std::vector<std::uint8_t>& bytes)
{
  if (CompressionStatus status = streams_.checkEncoding(true); !status.ok())
    return status;
  if (tree.getResolution() != settings().resolution)
    return {CompressionCode::InvalidInput,
            "the octree has another resolution than the settings"};
  detail::LeafSource<TreeT, IntensityModelT> source(intensity_model_, streams_, tree);
  const SensorPose pose = settings().sensor_pose.value_or(SensorPose::Identity());
  return streams_.encode(source, pose, pcl::PCLHeader(), bytes);
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
  return decodeSafely(cloud, [&] { return streams_.decode(compressed_cloud); });
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    decodePointCloud(const std::uint8_t* bytes, std::size_t size, PointCloudPtr& cloud)
{
  return decodeSafely(cloud, [&] { return streams_.decode(bytes, size); });
}

template <typename PointT,
          typename IntensityModelT,
          typename LeafT,
          typename BranchT,
          typename OctreeT>
template <typename DecodeT>
CompressionStatus
OctreePointCloudIntensityCompression<PointT, IntensityModelT, LeafT, BranchT, OctreeT>::
    decodeSafely(PointCloudPtr& cloud, DecodeT decode)
{
  CompressionStatus status;
  try {
    if (!cloud)
      cloud.reset(new PointCloud);
    output_ = cloud;
    status = decode();
    if (status.ok()) {
      detail::fillCloud(streams_.frame(), *cloud);
      streams_.copyStampTo(cloud->header);
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
  const VoxelFrame& frame = streams_.voxelFrame();
  const VoxelGrid& grid = frame.grid;
  const detail::OctreeBox box = detail::octreeBox(grid);
  this->deleteTree();
  // Set directly: PCL's defineBoundingBox may round a cube of 2^n voxels up.
  this->resolution_ = grid.resolution;
  this->min_x_ = box.min[0];
  this->min_y_ = box.min[1];
  this->min_z_ = box.min[2];
  this->max_x_ = box.max[0];
  this->max_y_ = box.max[1];
  this->max_z_ = box.max[2];
  this->bounding_box_defined_ = true;
  this->setTreeDepth(grid.depth);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const VoxelPosition position = voxelPosition(frame.keys[i]);
    this->addVoxel(frame, i, *this->createLeaf(position.x, position.y, position.z));
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io
