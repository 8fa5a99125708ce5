// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Files of numbers without a header, as lidar data sets have them.
 */
#pragma once

#include "clouds/file_text.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Whether the name of a file ends in .pcd.bin, as those of nuScenes do; in
 * capitals, too. */
inline bool
hasNuScenesName(const std::string& path)
{
  const std::filesystem::path name(lowerCase(path));
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

/** \brief Fields of a point by their names, with commas between them, each with :TYPE
 * if it is no float32: "x,y,z,intensity,ring:uint16". A field named _ is left out.
 * \throws std::runtime_error with what is wrong, also if x, y or z is missing
 */
std::vector<FileField>
parseBinFields(const std::string& text);

/** \brief The text of likely fields of points that have so many float32 numbers. */
std::string
binFieldsOf(std::size_t numbers);

/** \brief Reads a file of little-endian numbers, point after point.
 * \param[in] given fields of a point; none: x, y, z, reflectance as float32, as KITTI's
 * lidar has them or, if the name ends in .pcd.bin, x, y, z, intensity, ring, as those of
 * nuScenes
 * \param[out] cloud one row of points; the header is unchanged
 * \return what the user is to know: that given fields may be wrong, or that the file has
 * too few numbers to tell
 * \throws std::runtime_error with what is wrong: the size, numbers that are no
 * coordinates in metres, or those of points that have another number of numbers
 */
std::vector<std::string>
readBin(const std::string& path,
        const std::vector<FileField>& given,
        pcl::PCLPointCloud2& cloud);

} // namespace clouds
} // namespace pcl_ext
