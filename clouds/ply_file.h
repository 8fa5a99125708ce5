// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief PLY files: points of the element `vertex`.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Reads a PLY file, as text or with numbers in either order.
 * \param[out] cloud properties of the vertices, but no lists; normals have the names of
 * PCL's fields. It is organised if the file has the lines num_cols and num_rows, and
 * then NaN where its element range_grid has no vertex. Other elements are left out. The
 * header is unchanged
 * \return what of the vertices is left out, a line each
 * \throws std::runtime_error with what is wrong: the header does not agree with itself,
 * the file has fewer or more points than it promises, or words that are no numbers
 */
std::vector<std::string>
readPly(const std::string& path, pcl::PCLPointCloud2& cloud);

/** \brief The bytes of a binary PLY file. An organised cloud has its rows and columns in
 * the lines num_cols and num_rows and the element range_grid; points that are not
 * finite are left out of it then.
 * \param[in] cloud fields of one number; rgb and rgba are written as colours
 */
std::vector<std::uint8_t>
writePly(const pcl::PCLPointCloud2& cloud);

} // namespace clouds
} // namespace pcl_ext
