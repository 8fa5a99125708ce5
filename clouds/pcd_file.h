// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief PCD files, version 0.7 as PCL's documents describe it.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief The pose that a PCD file has besides its points. */
struct Viewpoint {
  Eigen::Vector4f origin = Eigen::Vector4f::Zero();
  Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
};

/** \brief The lines of a PCD file's header that tell sensors apart. */
struct PcdHeader {
  std::string fields;
  std::string width;
  std::string height;
  std::string viewpoint;
};

/** \brief Reads the header of a PCD file.
 * \return nothing if the file is none, or lacks lines that a header must have
 */
std::optional<PcdHeader>
readPcdHeader(const std::string& path);

/** \brief Reads a PCD file. A cloud takes at most 176 bytes of memory for each byte of
 * its file.
 * \param[out] cloud its fields as in the file, also those named _, which fields of
 * numbers that PCL has not become; none that have a COUNT of 0; numbers in the order
 * of this machine; the header is unchanged
 * \return what of the file is left out, a line each
 * \throws std::runtime_error with what is wrong: the header is not whole, the file has
 * fewer or more points than it promises, or words that are no numbers
 */
std::vector<std::string>
readPcd(const std::string& path, pcl::PCLPointCloud2& cloud);

/** \brief How a PCD file has its points. */
enum class PcdStorage { Binary, Compressed, Ascii };

/** \brief The bytes of a PCD file. Text has as many digits as the numbers need.
 * \param[in] cloud numbers in the order of this machine; each name of a field is one word
 * \throws std::runtime_error if the format has no room for it
 */
std::vector<std::uint8_t>
writePcd(const pcl::PCLPointCloud2& cloud,
         const Viewpoint& viewpoint,
         PcdStorage storage);

} // namespace clouds
} // namespace pcl_ext
