// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Fields as PCL has them, of files that have them otherwise.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Gives a cloud the fields that PCL's programs look for:
 *
 * - X, Y, Z, RGB and RGBA become x, y, z, rgb and rgba, where there are none of these
 *   names;
 * - coordinates that are whole numbers, or of several types, become floats, doubles
 *   where floats cannot have each value;
 * - a packed colour, `rgb` or `rgba`, that is INT32 becomes UINT32: the same 32 bits;
 * - separate channels (red, green, blue, r, g, b, diffuse_red ..., in any case, with
 *   alpha or a) become `rgb`, or `rgba`, at the place of the first. Whole numbers up to
 *   255 are taken as they are, and up to 65535 as 16 bits; others from 0 to 1 as shares.
 *   Other values are no colours. Where there is a packed colour, channels stay;
 * - integers of 64 bits become doubles, or two numbers of 32 bits.
 *
 * \param[in,out] cloud numbers in the order of this machine
 * \param[in] is_ply so that channels of 8 bits are the usual way of having colours
 * \return what the user is to know of it, a line each
 */
std::vector<std::string>
makeUsual(pcl::PCLPointCloud2& cloud, bool is_ply);

/** \brief Gives coordinates and packed colours their usual names as makeUsual() does.
 * \param[in,out] remarks is appended to
 */
void
nameUsually(pcl::PCLPointCloud2& cloud, std::vector<std::string>& remarks);

/** \brief Packs separate channels of a colour as makeUsual() does.
 * \param[in,out] cloud its rows without gaps
 * \param[in,out] remarks is appended to
 */
void
packColours(pcl::PCLPointCloud2& cloud, bool is_ply, std::vector<std::string>& remarks);

} // namespace clouds
} // namespace pcl_ext
