// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/view/view_server.h>

#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "inputs/standard_input.h"
#include "live/live_cell.h"
#include "live/piped_frames.h"
#include "live/view_output.h"
#include "measuring/markdown_table.h"
#include "options/encoding_options.h"
#include "options/options.h"
#include "outputs/output_path.h"
#include "recording/bag_reader.h"
#include "simulator/robot_cell.h"
#include "viewing/started_server.h"
#include "viewing/viewer_page.h"

#include <filesystem>
#include <memory>
#include <thread>

namespace pcl_ext::tools {

namespace {

struct ViewOptions {
  std::string input;        ///< empty: the cell
  std::string output;       ///< empty: served, not exported
  bool may_replace = false; ///< the output
  std::string page;
  std::string address;
  std::uint16_t port = 0;
  bool opens_browser = true;
  bool shows_cell = false;
  unsigned int sensors = cell::RobotCell::sensor_count;
  std::uint32_t seed = 1;
  EncodingOptions encoding;
  bool is_quiet = false;
};

/** \brief The name of a file or folder, without those that it is in. */
std::string
nameOf(const std::string& path)
{
  const std::filesystem::path given(path);
  return (given.has_filename() ? given : given.parent_path()).filename().string();
}

/** \brief Refuses bags whose files the page, which reads them itself, does not know. */
void
refuseOtherStorages(const std::string& path)
{
  recording::BagReader bag;
  const auto isWanted = [](const recording::McapChannel&) { return false; };
  if (recording::BagReader::isBag(path) && bag.open(path, isWanted).ok() &&
      (bag.isCompressed() || bag.hasDatabases() || bag.profile() == "ros1"))
    throw std::runtime_error(
        "'" + path +
        "' is of ROS 1, has the storage sqlite3 or is compressed by file, which "
        "browsers do not read: copy it with 'pcl_ext cut " +
        path + " -o x.mcap'");
}

/** \brief The files of a recording, which has frames.
 * \throws std::runtime_error
 */
std::vector<std::string>
filesOf(const std::string& path)
{
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored) &&
      !recording::BagReader::isBag(path))
    throw std::runtime_error("the folder '" + path +
                             "' is no recording of rosbag2: name one, or an .mcap or "
                             ".pcxi file");
  recording::RecordingReader reader;
  if (const auto status = reader.open(pathOfInput(path)); !status.ok())
    throw std::runtime_error(status.message());
  refuseOtherStorages(path);
  return reader.files();
}

class View {
public:
  explicit View(const ViewOptions& options)
  : options_(options), console_("view", options.is_quiet)
  {
    if (options.shows_cell != options.input.empty())
      throw UsageError(options.shows_cell ? "--cell is shown without a recording"
                                          : "name a recording, - or --cell");
  }

  int
  run()
  {
    if (!options_.output.empty())
      return writePage();
    const bool has_recording = !options_.shows_cell && options_.input != "-";
    std::vector<std::string> files; // told of before a page that is missing
    if (has_recording)
      files = filesOf(options_.input);
    settings_.page = readPage(options_.page);
    settings_.address = options_.address;
    settings_.port = options_.port;
    if (options_.shows_cell)
      showCell();
    else if (has_recording)
      showRecording(files);
    else
      showStandardInput();
    return has_failed_ ? something_failed : all_done;
  }

private:
  int
  writePage()
  {
    if (options_.input == "-")
      throw UsageError("--export takes the name of a recording, not -");
    if (options_.output == "-")
      throw UsageError("--export takes the name of a file, not -");
    std::error_code ignored;
    if (std::filesystem::is_directory(options_.output, ignored))
      throw UsageError("'" + options_.output +
                       "' is a folder: --export takes the name of a file, as x.html");
    refuseTakenFile(
        {options_.input, options_.page}, options_.output, options_.may_replace);
    checkSizeForPage(options_.input); // before all of it is read
    const std::vector<std::string> files = filesOf(options_.input);
    if (files.size() > 1)
      throw std::runtime_error("'" + options_.input + "' has " +
                               std::to_string(files.size()) +
                               " files, and a page takes one: pcl_ext merge " +
                               options_.input + " -o one.mcap makes one of them");
    const std::uint64_t bytes =
        writePageWithRecording(readPage(options_.page), files.front(), options_.output);
    if (bytes == 0)
      return interrupted;
    constexpr double megabyte = 1e6;
    console_.summary(
        options_.output + ": the page with " + nameOf(files.front()) + ", " +
        measuring::formatted(static_cast<double>(bytes) / megabyte, 1) + " MB");
    return all_done;
  }

  void
  showRecording(const std::vector<std::string>& files)
  {
    settings_.name = nameOf(options_.input);
    view::ViewServer server(settings_);
    throwUnlessOk(server.setRecording(files));
    start(server);
    waitForInterruption();
  }

  void
  showStandardInput()
  {
    settings_.name = "standard input";
    // Nobody can be asked for an I-frame.
    settings_.limits.max_kept_frames = 100'000;
    settings_.limits.max_kept_bytes = std::size_t{1} << 26;
    view::ViewServer server(settings_);
    start(server);
    ViewOutput output(server);
    has_failed_ = !PipedFrames(output, "/stream", console_).run();
    if (!isInterrupted())
      console_.remark("the input has ended; Ctrl-C ends the viewer");
    waitForInterruption();
  }

  void
  showCell()
  {
    LiveCell cell(options_.encoding, options_.sensors, options_.seed);
    settings_.name = "robot cell";
    settings_.request_i_frame = [&cell](std::size_t stream) {
      cell.requestIFrame(stream);
    };
    settings_.metrics = [&cell] { return cell.metrics(); };
    view::ViewServer server(settings_);
    ViewOutput output(server);
    // Before the server starts, so that the first viewer finds them.
    cell.addStreams(output);
    start(server);
    cell.run(output, [&] {
      if (const std::string overload = cell.newOverload(); !overload.empty())
        console_.remark(overload);
    });
    if (const std::string overload = cell.overload(); !overload.empty())
      console_.remark(overload);
  }

  void
  start(view::ViewServer& server)
  {
    startServer(server, settings_, options_.opens_browser, console_);
  }

  static void
  waitForInterruption()
  {
    constexpr std::chrono::milliseconds interval{50};
    while (!isInterrupted())
      std::this_thread::sleep_for(interval);
  }

  ViewOptions options_;
  Console console_;
  view::ViewServerSettings settings_;
  bool has_failed_ = false;
};

/** \brief Adds the options of the simulated cell, which need --cell. */
void
addCellOptions(CLI::App& app, ViewOptions& options, CLI::Option* cell)
{
  const std::vector<CLI::Option*> others = app.get_options();
  addNumber(app,
            "--sensors",
            options.sensors,
            1u,
            cell::RobotCell::sensor_count,
            "N",
            "of the cell, 1 to 6");
  app.add_option("--seed", options.seed, "of the random errors (1)")->type_name("N");
  options.encoding.setDefaults(cell_resolution, cell_law);
  options.encoding.addCropOption(app);
  options.encoding.addCodecOptions(app);
  for (CLI::Option* const option : app.get_options())
    if (std::find(others.begin(), others.end(), option) == others.end())
      option->needs(cell);
}

} // namespace

Run
addView(CLI::App& app)
{
  const auto options = std::make_shared<ViewOptions>();
  app.add_option("IN", options->input, "recording; - shows frames as they arrive")
      ->type_name("");
  CLI::Option* const cell =
      app.add_flag("--cell", options->shows_cell, "the simulated robot cell, live");
  CLI::Option* const output =
      app.add_option("--export",
                     options->output,
                     "write the page with the recording in it, and end")
          ->type_name("OUT");
  addOverwrite(app, options->may_replace)->needs(output);
  CLI::Option* const port = addNumber(app,
                                      "--port",
                                      options->port,
                                      std::uint16_t{0},
                                      std::uint16_t{65535},
                                      "N",
                                      "to serve on; 0: a free one");
  CLI::Option* const address =
      app.add_option("--address",
                     options->address,
                     "to serve on for others, such as 0.0.0.0 (this machine alone)")
          ->type_name("ADDRESS");
  CLI::Option* const browser = app.add_flag_callback(
      "--no-browser",
      [options] { options->opens_browser = false; },
      "print the address alone");
  app.add_option("--page", options->page, "the viewer's HTML (that of the program)")
      ->type_name("FILE");
  for (CLI::Option* const option : {cell, port, address, browser})
    output->excludes(option);
  addCellOptions(app, *options, cell);
  addQuiet(app, options->is_quiet);
  return [options] { return View(*options).run(); };
}

} // namespace pcl_ext::tools
