// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_sequence.h"
#include "clouds/file_text.h"
#include "commands/bag_encoding.h"
#include "commands/commands.h"
#include "commands/encode_bags.h"
#include "console/exit_status.h"
#include "console/printable_text.h"
#include "inputs/bag_list.h"
#include "options/bin_options.h"
#include "options/options.h"
#include "outputs/manifest.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace pcl_ext::tools {

namespace {

int
encodeOne(const EncodeOptions& options)
{
  Console console("encode", options.is_quiet);
  if (options.reports_progress)
    console.reportProgress();
  if (options.output.path == "-")
    console.keepOutputFree();
  Crew crew(options.jobs);
  const CrewThreads threads(crew);
  BagEncoding encoding(options, console, crew, options.jobs);
  const int status = encoding.run();
  if (options.is_json)
    std::cout << asText({{"bags",
                          {toJson(options.input.inputs,
                                  options.output.path,
                                  statusName(status),
                                  encoding.summary(),
                                  console.errors())}},
                         {"left_out", options.left_out}});
  return status;
}

/** \brief What decides on the bytes of recordings, as on a command line. */
std::string
optionsText(const CLI::App& app)
{
  const std::vector<std::string> without_effect = {"IN",
                                                   "--output",
                                                   "--overwrite",
                                                   "--jobs",
                                                   "--json",
                                                   "--progress",
                                                   "--quiet",
                                                   "--help"};
  std::string text;
  for (const CLI::Option* const option : app.get_options()) {
    const std::string& name = option->get_name();
    if (std::find(without_effect.begin(), without_effect.end(), name) !=
        without_effect.end())
      continue;
    for (const std::string& value : option->results())
      text += (text.empty() ? "" : " ") + name + (value == "true" ? "" : "=" + value);
  }
  return text;
}

/** \brief Tells what of folders of bags is not encoded. */
void
leaveOutOthers(EncodeOptions& options)
{
  Console console("encode", options.is_quiet);
  for (const FolderOfBags& folder : foldersWithOthers(options.input.inputs)) {
    console.remark(
        "'" + folder.path + "': left out: " +
        clouds::describeLeftOut(folder.other_folders, folder.other_files) +
        "; folders in it are not searched, and bags are named .mcap, .db3 or .bag" +
        (folder.unfinished.empty()
             ? ""
             : "; '" + folder.unfinished +
                   "' seems to be a bag without metadata.yaml: name this folder to "
                   "encode it"));
    for (const auto* const names : {&folder.other_folders, &folder.other_files})
      for (const std::string& name : *names)
        options.left_out.push_back(
            printable((std::filesystem::path(folder.path) / name).string()));
  }
}

int
encode(EncodeOptions& options, const CLI::App& app)
{
  options.encoding.check();
  if (options.is_json && options.output.path == "-")
    throw UsageError("--json has no effect with -o -, as the standard output takes "
                     "frames: name x.pcxi");
  // Fields that are kept come back as they were.
  const auto& kept = options.encoding.codec().fields;
  options.input.packs_colours =
      std::all_of(kept.begin(), kept.end(), [](const io::FieldSetting& field) {
        const std::string name = clouds::lowerCase(field.name);
        return name != io::all_fields && name != "r" && name != "red" &&
               name != "diffuse_red";
      });
  options.input.long_integers = options.encoding.longIntegers();
  if (options.jobs == 0)
    options.jobs = std::max(1u, std::thread::hardware_concurrency());
  // A folder of recordings gets one more.
  std::error_code ignored;
  const bool has_manifest = std::filesystem::exists(
      std::filesystem::path(options.output.path) / Manifest::file_name, ignored);
  const std::vector<std::string> bags =
      severalBags(options.input.inputs,
                  has_manifest,
                  kindOfOutput(options.output.path) != OutputKind::Folder);
  leaveOutOthers(options);
  return bags.empty() ? encodeOne(options)
                      : encodeBags(options, bags, optionsText(app));
}

} // namespace

Run
addEncode(CLI::App& app)
{
  const auto options = std::make_shared<EncodeOptions>();
  addInput(app,
           options->input.inputs,
           "PCD, PLY, KITTI .bin, nuScenes .pcd.bin, folders, 'globs'; bags: "
           "MCAP, rosbag2 (also .db3), ROS 1; -: a pipe; a stream per folder");
  addOutput(app,
            options->output,
            "x.pcxi or - (one stream), x.mcap, rosbag2 folder, folder of bags");
  addNumber(app,
            "--rate",
            options->input.rate,
            1e-6,
            1e6,
            "HZ",
            "clouds per second, of files; times in names are left out");
  addBinFields(app, options->input.bin_fields);
  addParsed(app,
            "--frames",
            "A:B",
            "only frames A to B - 1 of each stream, from 0; A alone: that one",
            [options](const std::string& text) {
              options->input.frames = parseFrames(text);
            });
  addNames(app,
           "--topics",
           options->input.topics,
           "only these clouds of a bag; others stay as they are");
  options->encoding.codec().effort = effort_of_files;
  options->encoding.addCodecOptions(app);
  options->encoding.addCloudOptions(app);
  options->encoding.addBudget(app);
  addNumber(app,
            "-j,--jobs",
            options->jobs,
            0u,
            256u,
            "N",
            "threads that encode; 0: one a core; same bytes for any");
  app.add_flag("--json", options->is_json, "print the summary for programs");
  app.add_flag("--progress",
               options->reports_progress,
               "print how far it is for programs, on the standard error");
  addQuiet(app, options->is_quiet);
  return [options, &app] {
    options->input.has_rate = isGiven(app, "--rate");
    return encode(*options, app);
  };
}

} // namespace pcl_ext::tools
