#include "pcl_compression.h"

#include <pcl/compression/octree_pointcloud_compression.h>
#include <pcl/io/impl/entropy_range_coder.hpp>
#include <pcl/io/impl/octree_pointcloud_compression.hpp>

namespace pcl_ext {
namespace measuring {

class PclCompression::Implementation
: public pcl::io::OctreePointCloudCompression<pcl::PointXYZ> {
public:
  explicit Implementation(const PclCompressionSettings& settings)
  : pcl::io::OctreePointCloudCompression<pcl::PointXYZ>(
        pcl::io::MANUAL_CONFIGURATION,
        /* showStatistics */ false,
        settings.point_resolution,
        settings.octree_resolution,
        settings.keeps_voxels_only,
        // PCL counts the frames between two I-frames.
        settings.i_frame_rate > 0 ? settings.i_frame_rate - 1 : 0,
        /* doColorEncoding */ false)
  {}
};

PclCompression::PclCompression(const PclCompressionSettings& settings)
: implementation_(std::make_unique<Implementation>(settings))
{}

PclCompression::~PclCompression() = default;

void
PclCompression::encode(const PositionCloud::ConstPtr& cloud, std::ostream& bytes)
{
  implementation_->encodePointCloud(cloud, bytes);
}

void
PclCompression::decode(std::istream& bytes, PositionCloud::Ptr& cloud)
{
  implementation_->decodePointCloud(bytes, cloud);
}

std::array<double, 3>
PclCompression::lowerCorner() const
{
  std::array<double, 3> min;
  std::array<double, 3> max;
  implementation_->getBoundingBox(min[0], min[1], min[2], max[0], max[1], max[2]);
  return min;
}

double
PclCompression::resolution() const
{
  return implementation_->getResolution();
}

} // namespace measuring
} // namespace pcl_ext
