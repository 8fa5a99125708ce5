#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

namespace pcl_ext {
namespace io {

template class OctreePointCloudIntensityCompression<pcl::PointXYZ>;
template class OctreePointCloudIntensityCompression<pcl::PointXYZI>;
template class OctreePointCloudIntensityCompression<pcl::PointXYZRGB>;
template class OctreePointCloudIntensityCompression<pcl::PointXYZRGBA>;

} // namespace io
} // namespace pcl_ext
