// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief The format of this library's frames in CompressedPointCloud2. */
constexpr char format_name[] = "pcl_ext";

/** \brief True if the compressed bytes of a message are frames of this library. A
 * format may say more after a slash, such as pcl_ext/version1. */
inline bool
isFormatOfFrames(const std::string& format)
{
  const std::string name = format_name;
  return format == name || format.compare(0, name.size() + 1, name + '/') == 0;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
