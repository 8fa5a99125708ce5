// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/output_path.h"

#include "console/exit_status.h"
#include "console/terminal.h"
#include "recording/bag_reader.h"

#include <filesystem>

namespace pcl_ext {
namespace tools {

namespace fs = std::filesystem;

OutputKind
kindOfOutput(const std::string& path)
{
  if (path.empty())
    throw UsageError("--output is empty");
  const std::string extension = fs::path(path).extension().string();
  if (path == "-" || extension == ".pcxi")
    return OutputKind::Frames;
  if (extension == ".mcap")
    return OutputKind::Mcap;
  if (extension.empty())
    return OutputKind::Folder;
  throw UsageError("'" + path +
                   "' is no kind of output: name x.pcxi (one stream), x.mcap, or a "
                   "folder");
}

void
refuseDevice(const std::string& path)
{
  std::error_code ignored;
  if (path.rfind("/dev/std", 0) == 0 ||
      (fs::exists(path, ignored) && fs::is_other(path, ignored)))
    throw UsageError("'" + path +
                     "' is no file or folder: name one, or - for the standard output, "
                     "where the command has it");
}

void
checkOutput(const std::string& path)
{
  refuseDevice(path);
  const OutputKind kind = kindOfOutput(path);
  if (path == "-" && isTerminal(StandardStream::Output))
    throw UsageError("the standard output is a terminal, and frames are no text: "
                     "redirect it, as in -o - > x.pcxi");
  std::error_code ignored;
  if (fs::is_directory(path, ignored))
    throw UsageError("the folder '" + path +
                     "' exists: name another output, or remove it");
  if (kind == OutputKind::Folder && fs::exists(path, ignored))
    throw UsageError(
        "'" + path +
        "' is a file; a name without an extension is a folder: name x.pcxi, "
        "x.mcap, or another folder");
}

void
refuseTakenFile(const std::vector<std::string>& inputs,
                const std::string& output,
                bool may_replace)
{
  if (output == "-")
    return;
  const fs::path folder = fs::path(output).parent_path();
  for (const std::string& input : inputs) {
    std::error_code ignored;
    if (fs::equivalent(input, output, ignored))
      throw UsageError("the output '" + output + "' is an input: name another one");
    if (fs::path(output).extension() == ".mcap" && fs::is_directory(input, ignored) &&
        recording::BagReader::isBag(input) &&
        fs::equivalent(input, folder.empty() ? "." : folder, ignored))
      throw UsageError("the output '" + output + "' would be a part of the input '" +
                       input + "': name one outside of that folder");
  }
  std::error_code ignored;
  if (!may_replace && fs::exists(fs::symlink_status(output, ignored)) &&
      !fs::is_directory(output, ignored))
    throw UsageError("'" + output +
                     "' exists: name another output, or replace it with --overwrite");
}

} // namespace tools
} // namespace pcl_ext
