// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/output_paths.h"

#include "recording/files.h"

#include <filesystem>

namespace pcl_ext::PCL_EXT_ABI::recording {

OutputPaths::OutputPaths(const std::string& path)
{
  if (path == standard_stream) {
    file = path;
    return;
  }
  const std::filesystem::path given(path);
  const std::filesystem::path name = given.has_filename() ? given : given.parent_path();
  if (given.has_filename() && given.has_extension()) {
    final = path;
    file = unfinished = path + unfinished_suffix;
    return;
  }
  is_folder = true;
  final = name.string();
  unfinished = final + unfinished_suffix;
  file_name = name.filename().string() + "_0.mcap";
  file = (std::filesystem::path(unfinished) / file_name).string();
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
