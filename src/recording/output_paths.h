// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Where an MCAP file or a rosbag2 folder is until it is complete, and
 * afterwards. */
struct OutputPaths {
  /** \param[in] path as McapWriter::open() takes it */
  explicit OutputPaths(const std::string& path);

  bool is_folder = false;
  std::string final;      // empty: the standard output
  std::string unfinished; // file or folder
  std::string file;       // that is written
  std::string file_name;  // in the folder
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
