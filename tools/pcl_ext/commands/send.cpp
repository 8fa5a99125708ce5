// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/recording/recording_reader.h>

#include "commands/commands.h"
#include "console/console.h"
#include "console/events.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/cloud_input.h"
#include "inputs/standard_input.h"
#include "inputs/tried_input.h"
#include "link/link_metrics.h"
#include "live/link_output.h"
#include "live/live_cell.h"
#include "live/piped_frames.h"
#include "live/played_clouds.h"
#include "live/played_recording.h"
#include "live/status_line.h"
#include "measuring/markdown_table.h"
#include "options/encoding_options.h"
#include "options/link_options.h"
#include "options/options.h"
#include "simulator/robot_cell.h"
#include "site/site_view.h"
#include "streams/frame_failures.h"

#include <algorithm>
#include <memory>

namespace pcl_ext::tools {

namespace {

struct SendOptions {
  TriedInput tried;
  EncodingOptions encoding;
  link::LinkSettings link;
  std::string prefix; ///< of names of streams
  MetricsOptions metrics;
  bool is_quiet = false;
  const CLI::App* app = nullptr;       ///< of the command
  std::vector<std::string> for_clouds; ///< options without effect on encoded frames
};

class Send {
public:
  explicit Send(const SendOptions& options)
  : options_(options), console_("send", options.is_quiet)
  {}

  int
  run()
  {
    completeLinkSettings(options_.link);
    options_.encoding.check();
    if (options_.tried.takes_cell)
      sendCell();
    else if (options_.tried.input.inputs == std::vector<std::string>{"-"})
      sendStandardInput();
    else
      sendFiles();
    events_.print(console_);
    return isInterrupted() ? interrupted : has_failed_ ? something_failed : all_done;
  }

private:
  void
  sendCell()
  {
    constexpr std::uint32_t seed = 1;
    LiveCell cell(options_.encoding, cell::RobotCell::sensor_count, seed);
    LinkOutput output(
        options_.link,
        options_.prefix,
        [&cell](std::size_t stream) { cell.requestIFrame(stream); },
        events_);
    cell.addStreams(output);
    const auto served = serve(output, [&] { return cell.metrics(options_.prefix); });
    announce("robot cell");
    cell.run(output, [&] {
      if (const std::string overload = cell.newOverload(); !overload.empty())
        console_.remark(overload);
      showStatus(output, cell.overload().empty() ? "" : ", this machine is too slow");
    });
    if (const std::string overload = cell.overload(); !overload.empty())
      console_.error(overload);
    for (const std::string& sentence : cell.remarks())
      console_.remark(sentence);
    summarise(output, cell.cloudsWithoutRoom());
  }

  /** \brief Prints what has happened, and how far the command is.
   * \param[in] rest see LiveFigures
   */
  void
  showStatus(const LinkOutput& output, const std::string& rest = "")
  {
    events_.print(console_);
    status_.update([&] {
      const link::PublisherStatistics sent = output.statistics();
      LiveFigures figures{sent.frames, sent.bytes, sent.is_connected, sent.age, rest};
      figures.rest += lossesOf(sent, 0);
      return figures;
    });
  }

  /** \brief Refuses options that have no effect on frames.
   * \param[in] have_times the frames, and so --rate has none either
   * \throws UsageError
   */
  void
  refuseOptionsOfClouds(bool have_times) const
  {
    const std::string why =
        " has encoded frames, which are sent as they are: leave it out";
    const std::string& input = options_.tried.input.inputs[0];
    const std::string name = input == "-" ? "the standard input" : "'" + input + "'";
    refuseOptions(*options_.app, options_.for_clouds, "is for clouds; " + name + why);
    if (have_times)
      refuseOptions(
          *options_.app, {"--rate"}, "is for files; " + name + " has its own times");
  }

  static bool
  hasTimes(const recording::RecordingReader& reader)
  {
    const auto& streams = reader.streams();
    return std::all_of(streams.begin(), streams.end(), [](const auto& stream) {
      return stream.has_times;
    });
  }

  void
  sendStandardInput()
  {
    refuseOptionsOfClouds(true);
    LinkOutput output(options_.link, options_.prefix, nullptr, events_);
    const auto served = serve(output);
    announce("standard input");
    has_failed_ =
        !PipedFrames(output, "/stream", console_).run([&] { showStatus(output); });
    summarise(output);
  }

  void
  sendFiles()
  {
    if (options_.tried.input.inputs.size() == 1) {
      recording::RecordingReader reader;
      const auto status = reader.open(options_.tried.input.inputs[0]);
      if (status.ok()) {
        refuseOptionsOfClouds(hasTimes(reader));
        sendRecording(reader);
        return;
      }
    }
    const std::unique_ptr<CloudInput> input = openInput(options_.tried.input);
    for (const std::string& remark : input->remarks())
      console_.remark(remark);
    FrameFailures failures([this](const std::string& line) { console_.error(line); });
    PlayedClouds clouds(options_.encoding, *input, failures);
    LinkOutput output(
        options_.link,
        options_.prefix,
        [&clouds](std::size_t stream) { clouds.requestIFrame(stream); },
        events_);
    const auto served = serve(output, [&] { return clouds.metrics(options_.prefix); });
    announce(options_.tried.input.inputs[0]);
    clouds.run(output, [&] {
      const std::size_t left_out =
          clouds.lateClouds() + clouds.blockedClouds() + clouds.cloudsWithoutRoom();
      showStatus(output,
                 left_out == 0 ? "" : ", " + counted(left_out, "cloud") + " left out");
    });
    has_failed_ = !report(clouds, *input);
    if (clouds.frames() == 0 && !isInterrupted())
      throw std::runtime_error("no cloud could be encoded");
    summarise(output, clouds.cloudsWithoutRoom());
  }

  /** \brief Prints what of clouds is not as it was sent; false if some are missing. */
  bool
  report(const PlayedClouds& clouds, const CloudInput& input)
  {
    for (const std::string& sentence : clouds.remarks())
      console_.remark(sentence);
    for (const std::string& place : input.damage())
      console_.error(place);
    if (clouds.lateClouds() > 0)
      console_.error(counted(clouds.lateClouds(), "cloud") +
                     " left out, as this machine is too slow for them: take " +
                     (options_.encoding.codec().effort == io::Effort::Fast
                          ? ""
                          : "a faster --effort, ") +
                     "a larger --resolution or a faster machine");
    if (clouds.blockedClouds() > 0)
      console_.error(counted(clouds.blockedClouds(), "cloud") +
                     " left out, as the server took none for a while");
    std::vector<std::string> faults = clouds.pointsOutsideGrid();
    for (std::string& stream : clouds.streamsWithoutRoom())
      faults.push_back(std::move(stream));
    for (const std::string& fault : faults)
      console_.error(fault);
    return faults.empty() && input.damage().empty() &&
           clouds.failedClouds() + clouds.lateClouds() + clouds.blockedClouds() == 0;
  }

  void
  sendRecording(recording::RecordingReader& reader)
  {
    LinkOutput output(options_.link, options_.prefix, nullptr, events_);
    const auto served = serve(output);
    announce(options_.tried.input.inputs[0]);
    has_failed_ =
        !playRecording(reader, options_.tried.input.rate, output, console_, [&] {
          showStatus(output);
        });
    summarise(output);
  }

  /** \brief Serves the metrics of what is sent, and those of its encoders. */
  std::shared_ptr<void>
  serve(const LinkOutput& output, const std::function<std::string()>& encoders = {})
  {
    return serveMetrics(
        options_.metrics,
        [&output, encoders] {
          return link::linkMetrics(output.statistics()) + (encoders ? encoders() : "");
        },
        console_);
  }

  void
  announce(const std::string& input)
  {
    console_.remark("sending " + shown(input) + " to site " + options_.link.site +
                    "; Ctrl-C ends");
  }

  /** \param[in] without_room clouds that were left out for --max-rate */
  void
  summarise(LinkOutput& output, std::size_t without_room = 0)
  {
    output.end(); // so that it is known which frames the server has
    events_.print(console_);
    const link::PublisherStatistics statistics = output.statistics();
    constexpr double megabyte = 1e6;
    std::string line =
        counted(statistics.frames, "frame") + " sent to site " + options_.link.site +
        ", " +
        measuring::formatted(static_cast<double>(statistics.bytes) / megabyte, 2) +
        " MB";
    if (without_room > 0)
      line += ", " + counted(without_room, "cloud") + " left out for --max-rate";
    if (statistics.violations > 0) {
      console_.error("the server did not permit all that was asked of it");
      has_failed_ = true;
    }
    const std::string losses = lossesOf(statistics, statistics.frames_under_way);
    has_failed_ |= !losses.empty();
    console_.summary(line + losses);
  }

  SendOptions options_;
  Console console_;
  Events events_;
  StatusLine status_{console_};
  bool has_failed_ = false;
};

} // namespace

Run
addSend(CLI::App& app)
{
  const auto options = std::make_shared<SendOptions>();
  addTriedInput(
      app,
      options->tried,
      "recording, or clouds or a bag as for encode, at the pace of their times; "
      "- passes frames on as they arrive");
  addLinkOptions(app, options->link);
  app.add_option("--prefix", options->prefix, "put before the names of the streams")
      ->type_name("TEXT");
  addMetricsOptions(app, options->metrics);
  const std::size_t others = app.get_options().size();
  options->encoding.addCodecOptions(app);
  options->encoding.addCloudOptions(app);
  options->encoding.addBudget(app);
  options->for_clouds = {"--bin-fields", "--topics"};
  for (std::size_t i = others; i < app.get_options().size(); ++i)
    options->for_clouds.push_back(app.get_options()[i]->get_name());
  options->app = &app;
  addQuiet(app, options->is_quiet);
  return [options, &app] {
    if (!options->tried.takes_cell && options->tried.input.inputs.empty())
      throw UsageError("name an input, - or --cell");
    completeTriedInput(app, options->tried, options->encoding);
    return Send(*options).run();
  };
}

} // namespace pcl_ext::tools
