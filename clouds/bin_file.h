// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Files of float32 numbers without a header, as lidar data sets have them.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <filesystem>
#include <string>

namespace pcl_ext {
namespace clouds {

/** \brief Whether the name of a file ends in .pcd.bin, as those of nuScenes do. */
inline bool
hasNuScenesName(const std::string& path)
{
  const std::filesystem::path name(path);
  return name.extension() == ".bin" && name.stem().extension() == ".pcd";
}

/** \brief The name of a file without its folder and its extension, .pcd.bin as a whole.
 */
inline std::string
stemOf(const std::string& path)
{
  const std::filesystem::path stem = std::filesystem::path(path).stem();
  return (hasNuScenesName(path) ? stem.stem() : stem).string();
}

/** \brief Reads a file of little-endian float32 numbers: x, y, z, reflectance of each
 * point as KITTI's lidar has them or, if its name ends in .pcd.bin, x, y, z, intensity,
 * ring as nuScenes has them.
 * \param[out] cloud one row of points; the header is unchanged
 * \throws std::runtime_error with what is wrong: the size, numbers that are no
 * coordinates in metres, or those of points that have another number of numbers
 */
void
readBin(const std::string& path, pcl::PCLPointCloud2& cloud);

} // namespace clouds
} // namespace pcl_ext
