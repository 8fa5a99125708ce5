// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The fields of a cloud, and those of a file of it.
 */
#pragma once

#include "clouds/file_text.h"

#include <pcl/PCLPointCloud2.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief True if PCL has a datatype for the numbers of a field. */
bool
hasDatatype(const FileField& field);

/** \brief Sets the fields of a cloud, one after the other, its size, and room for its
 * points.
 * \param[in] fields for which hasDatatype() is true, or ignored ones
 * \throws std::runtime_error if there are two of a coordinate
 */
void
startCloud(const std::vector<FileField>& fields,
           std::uint64_t width,
           std::uint64_t height,
           pcl::PCLPointCloud2& cloud);

/** \brief A field of a cloud as that of a file.
 * \throws std::runtime_error if its datatype is none of numbers
 */
FileField
fileFieldOf(const pcl::PCLPointField& field);

/** \brief The type of a field's numbers as users name it: "uint16". */
std::string
typeName(const FileField& field);

/** \brief Calls a function with a number of a cloud, which has the type of its field.
 * \param[in] number in the order of this machine
 * \param[in] visit gives the same type of result for all
 */
template <typename VisitorT>
auto
visitNumber(const FileField& field, const std::uint8_t* number, const VisitorT& visit)
{
  return visitZero(field, [&](auto value) {
    std::memcpy(&value, number, sizeof(value));
    return visit(value);
  });
}

/** \brief A number of a cloud as text.
 * \param[in] number in the order of this machine
 */
std::string
textOf(const FileField& field, const std::uint8_t* number);

/** \brief The offset of a point of a cloud, bytes. */
inline std::size_t
offsetOf(const pcl::PCLPointCloud2& cloud, std::size_t point)
{
  return point / cloud.width * cloud.row_step + point % cloud.width * cloud.point_step;
}

/** \brief Whether this machine has the least byte of a number last. */
bool
isBigEndianMachine();

/** \brief Turns numbers around between the order of this machine and little-endian, where
 * these differ. */
void
toLittleEndian(const std::vector<FileField>& fields, std::vector<std::uint8_t>& points);

/** \brief Between points and the columns of compressed PCD files: all numbers of a field
 * together.
 * \param[in] gather true: from points to columns
 */
void
transpose(const std::vector<FileField>& fields,
          std::uint64_t points,
          bool gather,
          const std::vector<std::uint8_t>& from,
          std::vector<std::uint8_t>& to);

/** \brief The points of a cloud, their fields one after the other. */
std::vector<std::uint8_t>
packedPoints(const pcl::PCLPointCloud2& cloud, const std::vector<FileField>& fields);

} // namespace clouds
} // namespace pcl_ext
