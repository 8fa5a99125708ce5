// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "coders/pcl_compression.h"

#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/io/impl/entropy_range_coder.hpp>
#include <pcl/io/impl/octree_pointcloud_compression.hpp>

namespace pcl_ext {
namespace measuring {

template <typename PointT>
class PclCompression<PointT>::Implementation
: public pcl::io::OctreePointCloudCompression<PointT> {
public:
  using pcl::io::OctreePointCloudCompression<PointT>::OctreePointCloudCompression;
};

template <typename PointT>
PclCompression<PointT>::PclCompression(const PclCompressionSettings& settings)
: implementation_(std::make_unique<Implementation>(
      pcl::io::MANUAL_CONFIGURATION,
      /* showStatistics */ false,
      settings.point_resolution,
      settings.octree_resolution,
      settings.keeps_voxels_only,
      // PCL counts the frames between two I-frames.
      settings.i_frame_rate > 0 ? settings.i_frame_rate - 1 : 0,
      /* doColorEncoding */ false))
{}

template <typename PointT>
PclCompression<PointT>::PclCompression(pcl::io::compression_Profiles_e profile)
: implementation_(std::make_unique<Implementation>(profile))
{}

template <typename PointT>
PclCompression<PointT>::~PclCompression() = default;

template <typename PointT>
void
PclCompression<PointT>::encode(const typename Cloud::ConstPtr& cloud,
                               std::ostream& bytes)
{
  implementation_->encodePointCloud(cloud, bytes);
}

template <typename PointT>
void
PclCompression<PointT>::decode(std::istream& bytes, typename Cloud::Ptr& cloud)
{
  implementation_->decodePointCloud(bytes, cloud);
}

template <typename PointT>
std::array<double, 3>
PclCompression<PointT>::lowerCorner() const
{
  std::array<double, 3> min;
  std::array<double, 3> max;
  implementation_->getBoundingBox(min[0], min[1], min[2], max[0], max[1], max[2]);
  return min;
}

template <typename PointT>
double
PclCompression<PointT>::resolution() const
{
  return implementation_->getResolution();
}

template class PclCompression<pcl::PointXYZ>;
template class PclCompression<pcl::PointXYZRGB>;

} // namespace measuring
} // namespace pcl_ext
