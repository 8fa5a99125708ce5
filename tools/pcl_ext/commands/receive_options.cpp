// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/receive_options.h"

#include "console/exit_status.h"
#include "link/subjects.h"
#include "options/decoding_options.h"
#include "options/link_options.h"
#include "options/text_values.h"
#include "outputs/output_path.h"

#include <algorithm>
#include <chrono>
#include <filesystem>

namespace pcl_ext::tools {

namespace {

link::Time
secondsOf(const std::string& option, const std::string& text, bool may_be_zero = false)
{
  return std::chrono::duration_cast<link::Time>(
      std::chrono::duration<double>(parseDuration(option, text, may_be_zero)));
}

void
addRecordingOptions(CLI::App& app, ReceiveOptions& options)
{
  CLI::Option* const output =
      app.add_option("-o,--output", options.output.path, "record in x.mcap, or x.pcxi")
          ->type_name("OUT");
  addParsed(app,
            "--rotate-every",
            "TIME",
            "go on in another file after, such as 10min",
            [&options](const std::string& text) {
              options.rotation.seconds = parseDuration("--rotate-every", text);
            })
      ->needs(output);
  addParsed(app,
            "--rotate-size",
            "SIZE",
            "go on in another file above, such as 2GB",
            [&options](const std::string& text) {
              options.rotation.bytes = parseBytes("--rotate-size", text);
            })
      ->needs(output);
}

void
addCentreOptions(CLI::App& app, ReceiveOptions& options)
{
  CentreOptions& centre = options.centre;
  CLI::Option* const merge =
      app.add_option("--merge",
                     centre.name,
                     "publish the merged streams as a stream of this name")
          ->type_name("NAME");
  app.add_option("--merged-site",
                 options.merged_site,
                 "site of the merged stream (that of --site with -merged)")
      ->type_name("NAME")
      ->needs(merge);
  app.add_option(
         "--resolution",
         centre.resolution,
         "voxel edge of --merge and --map, not finer than the streams' (that of "
         "the first one)")
      ->check([](const std::string& text) {
        return refuseOutside(text, io::smallest_resolution, io::largest_resolution);
      })
      ->type_name("METRES");
  const auto add_time = [&app](const char* name,
                               nodes::Time& time,
                               const char* text,
                               bool may_be_zero = false) {
    addParsed(app, name, "TIME", text, [=, &time](const std::string& value) {
      time = secondsOf(name, value, may_be_zero);
    });
  };
  add_time("--merge-period",
           centre.schedule.period,
           "from one merged frame to the next, in the clouds' time (100ms)");
  add_time("--merge-wait",
           centre.schedule.max_wait,
           "for streams that are behind others (200ms)",
           /* may_be_zero */ true);
  add_time("--merge-age",
           centre.schedule.max_age,
           "leave streams out whose last frame is older (2s)");
  addChoice(app, "--effort", io::efforts, centre.stream.effort, "of the merged stream");
  app.add_option("--map", centre.map.path, "feed an OctoMap, written each minute")
      ->type_name("FILE.ot");
  app.add_option(
         "--map-full-intensity",
         centre.map.full_intensity,
         "that counts as one hit in the map, lower ones as a part of it; 0: each "
         "voxel does (0 for law native, else 4)")
      ->check([](const std::string& text) { return refuseOutside(text, 0.0, 1e30); })
      ->type_name("I");
  centre.decoding.limits = nodes::CentralNodeSettings::defaultLimits();
  addDecodingOptions(app, centre.decoding);
}

void
checkName(const std::string& option, const std::string& stream)
{
  if (stream.size() > link::longest_stream_name)
    throw UsageError(option + ": the name of a stream has " +
                     std::to_string(stream.size()) + " bytes; it may have up to " +
                     std::to_string(link::longest_stream_name));
}

/** \brief Refuses a file that exists, or is the recording. */
void
checkMap(const ReceiveOptions& options)
{
  namespace fs = std::filesystem;
  const std::string& map = options.centre.map.path;
  if (map.empty())
    return;
  if (map == "-")
    throw UsageError("--map is '-'; it must be a file, which is written each minute");
  refuseTakenFile({}, map, options.output.may_replace);
  if (!options.output.path.empty() &&
      fs::weakly_canonical(fs::absolute(map)) ==
          fs::weakly_canonical(fs::absolute(options.output.path)))
    throw UsageError("-o and --map are both '" + map + "': name two files");
}

} // namespace

void
addReceiveOptions(CLI::App& app, ReceiveOptions& options)
{
  addLinkOptions(app, options.link.link);
  addNames(app, "--streams", options.link.streams, "only these (all)");
  app.add_option("--partition",
                 options.link.partition,
                 "only this part of the streams, as the server divides them")
      ->envname("PCL_EXT_PARTITION")
      ->type_name("N");
  addParsed(app,
            "--replay",
            "TIME",
            "what the server keeps, in place of what comes; all, or since a time ago",
            [&options](const std::string& text) {
              options.link.replay_from = std::max(
                  link::Time(0),
                  text == "all" ? link::Time(0)
                                : nodes::systemTime() - secondsOf("--replay", text));
            });
  addParsed(
      app, "--for", "TIME", "end after (Ctrl-C)", [&options](const std::string& text) {
        options.seconds = parseDuration("--for", text);
      });
  addRecordingOptions(app, options);
  app.add_flag("--overwrite",
               options.output.may_replace,
               "replace the files of -o and --map, if they are there");
  addSiteViewOptions(app, options.view);
  addMetricsOptions(app, options.metrics);
  addCentreOptions(app, options);
  addQuiet(app, options.is_quiet);
}

void
completeOptions(const CLI::App& app, ReceiveOptions& options)
{
  if (options.output.path.empty() && options.centre.map.path.empty())
    refuseOptions(app, {"--overwrite"}, "is for files: add -o or --map");
  if (options.centre.map.path.empty())
    refuseOptions(app, {"--map-full-intensity"}, "is for maps: add --map");
  if (options.centre.name.empty())
    refuseOptions(app,
                  {"--merge-period", "--merge-wait", "--merge-age", "--effort"},
                  "is for merged streams: add --merge");
  if (!options.centre.isOn())
    refuseOptions(app,
                  {"--resolution",
                   "--min-intensity",
                   "--remove-outliers",
                   "--max-voxels",
                   "--memory-limit"},
                  "is for decoded streams: add --merge or --map");
  if (options.output.path.empty() && !options.view.is_on && !options.centre.isOn() &&
      !options.metrics.port)
    throw UsageError("say what to do with the frames: -o, --view, --merge, --map or "
                     "--metrics-port");
  for (const std::string& stream : options.link.streams)
    checkName("--streams", stream);
  checkName("--merge", options.centre.name);
  options.centre.is_replay = options.link.replay_from.has_value();
  options.centre.map.waits = options.centre.is_replay;
  options.centre.map.may_replace = options.output.may_replace;
  checkMap(options);
  if (options.merged_site.empty())
    options.merged_site = options.link.link.site + "-merged";
  if (options.merged_site == options.link.link.site)
    throw UsageError("--merged-site is '" + options.merged_site +
                     "', as --site: a centre would receive what it has merged");
  link::LinkSettings of_merged;
  of_merged.site = options.merged_site;
  if (!options.centre.name.empty() && !link::checkSettings(of_merged).ok())
    throw UsageError("--merged-site is '" + options.merged_site +
                     "'; it must be up to 64 letters, digits, - and _");
}

} // namespace pcl_ext::tools
