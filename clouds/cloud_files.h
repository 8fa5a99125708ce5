// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Files of one cloud each: PCD, PLY, and the .bin files of lidar data sets.
 */
#pragma once

#include "clouds/file_text.h"
#include "clouds/usual_fields.h"

#include <pcl/PCLPointCloud2.h>

#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief What a file is, by its first bytes; .bin files by their name. */
enum class FileKind {
  Pcd,
  Ply,
  Bin, ///< numbers without a header, see readBin()
  Mcap,
  Ros1Bag,
  Sqlite,        ///< as a rosbag2 folder may have
  Recording,     ///< frames of this library
  PclCompressed, ///< of pcl::io::OctreePointCloudCompression
  Empty,
  Foreign, ///< of another program, from which clouds or bags can be made
  Text,    ///< that does not begin as PCD and PLY files do
  Unknown
};

/** \brief True if the system tells that a file has no bytes. Some such files, as
 * /proc/kmsg, let their readers wait without end. */
bool
isEmptyFile(const std::string& path);

/** \brief Finds out what a file is.
 * \throws std::runtime_error if it cannot be opened
 */
FileKind
kindOf(const std::string& path);

/** \brief True for the kinds that have one cloud. */
constexpr bool
isCloud(FileKind kind)
{
  return kind == FileKind::Pcd || kind == FileKind::Ply || kind == FileKind::Bin;
}

/** \brief Why a file that is not a cloud is none, and what to do. */
std::string
whyNotACloud(FileKind kind, const std::string& path);

/** \brief True if the name of a file ends as those of clouds do: .pcd, .ply, .bin. */
bool
hasNameOfCloud(const std::string& path);

/** \brief Reads the cloud of a file.
 * \param[in] path of a PCD, PLY or .bin file
 * \param[out] cloud its points, with fields as UsualFields gives them;
 * header.stamp and header.frame_id are empty
 * \param[in] bin_fields of a point of a .bin file, or one of an unknown kind; none: as
 * its name tells, see readBin()
 * \param[in,out] of_stream that the file is of; null: it is none of a stream
 * \return what of the file is left out or taken otherwise than it is there, a line each
 * \throws std::runtime_error that says why the file cannot be read, without its name
 * \throws FieldRefusal see UsualFields
 */
std::vector<std::string>
readCloud(const std::string& path,
          pcl::PCLPointCloud2& cloud,
          const std::vector<FileField>& bin_fields = {},
          UsualFields* of_stream = nullptr);

} // namespace clouds
} // namespace pcl_ext
