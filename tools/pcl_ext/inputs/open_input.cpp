// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_files.h"
#include "console/exit_status.h"
#include "inputs/bag_list.h"
#include "inputs/cloud_input.h"
#include "inputs/standard_input.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

using clouds::FileKind;

void
refuseOptionsOfFiles(const std::string& bag, const InputOptions& options)
{
  if (!options.bin_fields.empty())
    throw UsageError("--bin-fields is for files; '" + bag +
                     "' is a bag, whose messages name their fields");
  if (options.has_rate)
    throw UsageError("--rate is for files; '" + bag +
                     "' is a bag, which has its own times");
}

} // namespace

std::unique_ptr<CloudInput>
openInput(const InputOptions& options)
{
  if (options.inputs.size() == 1)
    if (std::optional<recording::Descriptor> pipe = mcapPipeOf(options.inputs[0])) {
      refuseOptionsOfFiles(options.inputs[0], options);
      return openMcapPipe(std::move(*pipe), shownName(options.inputs[0]), options);
    }
  std::vector<clouds::SequenceInput> paths;
  for (const std::string& input : options.inputs)
    for (const std::string& path : pathsOf(input)) {
      const std::string only_bag = onlyBagIn(path);
      const std::string& given = only_bag.empty() ? path : only_bag;
      const bool is_copied = given != pathOfInput(given);
      paths.push_back(
          {pathOfInput(given), is_copied ? streamNameOfInput(given) : given});
    }
  const auto bag = std::find_if(
      paths.begin(), paths.end(), [](const auto& input) { return isBag(input.path); });
  if (bag != paths.end() && paths.size() > 1)
    throw UsageError(
        "'" + bag->path +
        "' is a bag, which is taken alone: run the command for each bag, or "
        "join recordings by pcl_ext merge first");
  if (bag != paths.end()) {
    refuseOptionsOfFiles(bag->path, options);
    return openBag(bag->path, options);
  }
  for (const auto& [path, name] : paths) {
    if (fs::is_directory(path))
      continue;
    const FileKind kind = clouds::kindOf(path);
    // Clouds that are damaged are reported when they are read, and the others go on.
    const bool has_fields = kind == FileKind::Unknown && !options.bin_fields.empty();
    if (!clouds::isCloud(kind) && !clouds::hasNameOfCloud(path) && !has_fields)
      throw std::runtime_error("'" + path +
                               "' is not a cloud: " + clouds::whyNotACloud(kind, path));
  }
  return openFiles(paths, options);
}

void
checkTopics(const std::vector<std::string>& chosen,
            const std::vector<std::string>& topics)
{
  for (const std::string& topic : chosen) {
    if (std::find(topics.begin(), topics.end(), topic) != topics.end())
      continue;
    std::string known;
    for (const std::string& other : topics)
      known += (known.empty() ? "" : ", ") + other;
    throw UsageError("--topics: there are no clouds of '" + topic + "'; there are " +
                     known);
  }
}

} // namespace pcl_ext::tools
