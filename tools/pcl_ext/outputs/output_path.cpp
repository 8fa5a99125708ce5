// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/output_path.h"

#include "console/exit_status.h"
#include "console/terminal.h"
#include "recording/bag_reader.h"

#include <filesystem>

namespace pcl_ext::tools {

namespace fs = std::filesystem;

namespace {

void
throwAsUsage(const recording::RecordingStatus& status, const char* end = "")
{
  if (!status.ok())
    throw UsageError(status.message() + end);
}

} // namespace

OutputKind
kindOfOutput(const std::string& path)
{
  if (path.empty())
    throw UsageError("--output is empty");
  OutputKind kind{};
  throwAsUsage(recording::kindOfOutput(path, kind));
  return kind;
}

void
refuseDevice(const std::string& path)
{
  throwAsUsage(recording::refuseDevice(path), ", where the command has it");
}

void
checkOutput(const std::string& path)
{
  refuseDevice(path);
  OutputKind kind = kindOfOutput(path);
  if (path == "-" && isTerminal(StandardStream::Output))
    throw UsageError("the standard output is a terminal, and frames are no text: "
                     "redirect it, as in -o - > x.pcxi");
  throwAsUsage(recording::checkOutput(path, kind));
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
  if (!may_replace)
    throwAsUsage(recording::refuseTakenFile(output, "--overwrite"));
}

} // namespace pcl_ext::tools
