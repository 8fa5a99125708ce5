/** \file
 * \brief Files of float32 numbers without a header, as lidar data sets have them.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <string>

namespace pcl_ext {
namespace clouds {

/** \brief The name of a file without its folder and its extension, .pcd.bin as a whole. */
std::string
stemOf(const std::string& path);

/** \brief Reads a file of little-endian float32 numbers: x, y, z, reflectance of each point
 * as KITTI's lidar has them or, if its name ends in .pcd.bin, x, y, z, intensity, ring as
 * nuScenes has them.
 * \param[out] cloud one row of points; the header is unchanged
 * \throws std::runtime_error with what is wrong: the size, numbers that are no coordinates
 * in metres, or those of points that have another number of numbers
 */
void
readBin(const std::string& path, pcl::PCLPointCloud2& cloud);

} // namespace clouds
} // namespace pcl_ext
