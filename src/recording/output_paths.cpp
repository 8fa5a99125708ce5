// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/output_paths.h"

#include "recording/files.h"

#include <filesystem>
#include <system_error>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

namespace fs = std::filesystem;

RecordingStatus
refused(const std::string& message)
{
  return {RecordingCode::OutputFailed, message};
}

} // namespace

RecordingStatus
kindOfOutput(const std::string& path, OutputKind& kind)
{
  if (path.empty())
    return {RecordingCode::InvalidArgument, "the name of an output is empty"};
  if (path.find('\0') != std::string::npos)
    return {RecordingCode::InvalidArgument, "the name of an output has a byte of 0"};
  const std::string extension = fs::path(path).extension().string();
  if (path == standard_stream || extension == ".pcxi")
    kind = OutputKind::Frames;
  else if (extension == ".mcap")
    kind = OutputKind::Mcap;
  else if (extension.empty())
    kind = OutputKind::Folder;
  else
    return {RecordingCode::InvalidArgument,
            "'" + path +
                "' is no kind of output: name x.pcxi (one stream), x.mcap, or a "
                "folder"};
  return {};
}

RecordingStatus
refuseDevice(const std::string& path)
{
  std::error_code ignored;
  if (path.rfind("/dev/std", 0) == 0 ||
      (fs::exists(path, ignored) && fs::is_other(path, ignored)))
    return refused("'" + path +
                   "' is no file or folder: name one, or - for the standard output");
  return {};
}

RecordingStatus
checkOutput(const std::string& path, OutputKind& kind)
{
  if (RecordingStatus status = refuseDevice(path); !status.ok())
    return status;
  if (RecordingStatus status = kindOfOutput(path, kind); !status.ok())
    return status;
  if (path == standard_stream)
    return {};
  std::error_code ignored;
  if (fs::is_directory(path, ignored))
    return refused("the folder '" + path +
                   "' exists: name another output, or remove it");
  if (kind == OutputKind::Folder && fs::exists(path, ignored))
    return refused("'" + path +
                   "' is a file; a name without an extension is a folder: name x.pcxi, "
                   "x.mcap, or another folder");
  return {};
}

RecordingStatus
refuseTakenFile(const std::string& path, const std::string& remedy)
{
  std::error_code ignored;
  if (path != standard_stream && fs::exists(fs::symlink_status(path, ignored)) &&
      !fs::is_directory(path, ignored))
    return refused("'" + path + "' exists: name another output, or replace it with " +
                   remedy);
  return {};
}

OutputPaths::OutputPaths(const std::string& path)
{
  if (path == standard_stream) {
    file = path;
    return;
  }
  const fs::path given(path);
  const fs::path name = given.has_filename() ? given : given.parent_path();
  if (given.has_filename() && given.has_extension()) {
    final = path;
    file = unfinished = path + unfinished_suffix;
    return;
  }
  is_folder = true;
  final = name.string();
  unfinished = final + unfinished_suffix;
  file_name = name.filename().string() + "_0.mcap";
  file = (fs::path(unfinished) / file_name).string();
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
