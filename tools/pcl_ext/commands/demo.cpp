// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/commands.h"
#include "commands/demo_stream.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "measuring/markdown_table.h"
#include "options/options.h"
#include "outputs/cloud_folder.h"
#include "outputs/frame_output.h"
#include "simulator/robot_cell.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

struct DemoOptions {
  unsigned int sensors = 3;
  std::uint32_t frames = 100;
  std::uint32_t seed = 1;
  Output output{"out"};
  std::optional<float> threshold;
  EncodingOptions encoding;
  bool is_quiet = false;
};

std::string
percent(std::size_t part, std::size_t whole)
{
  const double share = static_cast<double>(part) / static_cast<double>(whole);
  return whole == 0 ? "-" : measuring::formatted(100.0 * share, 1) + " %";
}

void
print(const std::vector<DemoReport>& reports)
{
  measuring::MarkdownTable table({"stream",
                                  "frames",
                                  "points",
                                  "voxels",
                                  "bytes",
                                  "ratio",
                                  "encode ms",
                                  "decode ms",
                                  "noise removed",
                                  "surfaces kept"});
  for (const DemoReport& report : reports) {
    const EncodedSums& sums = report.encoded;
    const double frames = static_cast<double>(std::max<std::size_t>(sums.frames, 1));
    const auto mean = [frames](auto sum, int digits) {
      return measuring::formatted(static_cast<double>(sum) / frames, digits);
    };
    const double ratio = 16.0 * static_cast<double>(sums.encoded_points) /
                         static_cast<double>(std::max<std::size_t>(sums.bytes, 1));
    const DenoisingReport& denoising = report.denoising;
    table.addRow(
        {report.name,
         std::to_string(sums.frames),
         mean(sums.encoded_points, 0),
         mean(sums.voxels, 0),
         mean(sums.bytes, 0),
         measuring::formatted(ratio, 1),
         mean(report.encode_ms, 2),
         mean(report.decode_ms, 2),
         percent(denoising.noise_removed, denoising.noise),
         percent(denoising.surfaces - denoising.surfaces_removed, denoising.surfaces)});
  }
  std::cout << "Means of a frame:\n";
  table.print(std::cout);
  std::cout << "points: those in voxels. ratio: 16 bytes for each of them against the "
               "bytes. ms: processor\ntime; encoding begins with the sensor's cloud. "
               "noise: voxels without a point of a surface,\nwhich are known in the "
               "robot cell; -: not with a temporal filter.\n";
}

/** \brief Some sensors of the robot cell, through the whole pipeline. */
class Demo {
public:
  explicit Demo(const DemoOptions& options)
  : options_(options), console_("demo", options.is_quiet)
  {
    options_.encoding.completeForCell();
    options_.encoding.check();
    for (unsigned int sensor = 1; sensor <= options.sensors; ++sensor)
      streams_.push_back(std::make_unique<DemoStream>(
          options_.encoding, sensor, options.frames, options.seed, options.threshold));
    if (!options.output.path.empty())
      openOutput();
  }

  int
  run()
  {
    console_.startProgress("frames", streams_.size() * options_.frames);
    for (std::uint32_t frame = 0; frame < options_.frames && !isInterrupted(); ++frame)
      for (std::size_t i = 0; i < streams_.size(); ++i) {
        streams_[i]->run(frame);
        if (output_)
          write(i, frame);
        console_.advance();
      }
    console_.endProgress();
    std::vector<DemoReport> reports;
    for (const auto& stream : streams_)
      reports.push_back(stream->report());
    if (reports.front().encoded.encoded_points == 0)
      throw std::runtime_error("no point is inside the crop box: choose --crop to hold "
                               "some of the cell, which is 10 x 10 x 4 m");
    std::string ending;
    if (output_) {
      ending = output_->finish();
      if (const std::string of_clouds = clouds_->finish(); of_clouds != ending)
        ending += of_clouds;
    }
    print(reports);
    if (output_)
      printNextSteps();
    if (!ending.empty())
      console_.remark(recording_ + ending);
    return isInterrupted() ? interrupted : all_done;
  }

private:
  void
  openOutput()
  {
    const Output& output = options_.output;
    recording_ = (fs::path(output.path) / "cell.mcap").string();
    refuseTakenFolder(output.path, output.may_replace);
    std::error_code error;
    fs::create_directories(output.path, error);
    if (error)
      throw std::runtime_error("cannot create the folder '" + output.path +
                               "': " + error.message());
    output_.emplace(Output{recording_, output.may_replace}, false, "ros2");
    std::vector<std::string> folders;
    for (const auto& stream : streams_) {
      folders.push_back(stream->name() + "/decoded");
      folders.push_back(stream->name() + "/denoised");
      numbers_.push_back(output_->addStream(
          {"/" + stream->name(),
           "world",
           options_.encoding.metadataOf("/" + stream->name(), stream->law(), false)}));
    }
    constexpr bool may_replace = true; // the recording is in the folder, too
    clouds_ = std::make_unique<CloudFolder>(
        output.path, CloudFormat::PcdCompressed, may_replace, folders);
  }

  void
  write(std::size_t i, std::size_t frame)
  {
    const DemoStream& stream = *streams_[i];
    frame_.message.log_time = stream.time();
    frame_.bytes = stream.bytes();
    output_->write(numbers_[i], frame_);
    if (stream.decoded().width > 0)
      clouds_->write(2 * i, frame, stream.decoded());
    if (stream.denoised().width > 0)
      clouds_->write(2 * i + 1, frame, stream.denoised());
  }

  void
  printNextSteps() const
  {
    // tools/run.sh says how it is called.
    const char* const given = std::getenv("PCL_EXT_COMMAND");
    const std::string command = given != nullptr ? given : "pcl_ext";
    std::cout << "\nThe frames are in " << recording_
              << ", the decoded and the denoised clouds beside it. Next:\n  " << command
              << " info " << recording_ << "\n  " << command << " decode " << recording_
              << " -o decoded --remove-outliers\n  " << command << " view "
              << recording_ << '\n';
  }

  DemoOptions options_;
  Console console_;
  std::vector<std::unique_ptr<DemoStream>> streams_;
  std::string recording_;
  std::optional<FrameOutput> output_;
  std::vector<std::size_t> numbers_; // of the streams in output_
  std::unique_ptr<CloudFolder> clouds_;
  OutputFrame frame_;
};

} // namespace

Run
addDemo(CLI::App& app)
{
  const auto options = std::make_shared<DemoOptions>();
  addNumber(app,
            "--sensors",
            options->sensors,
            1u,
            cell::RobotCell::sensor_count,
            "N",
            "sensors of the robot cell, 1 to 6");
  addNumber(app,
            "-n,--frames",
            options->frames,
            std::uint32_t{1},
            std::uint32_t{1} << 30,
            "N",
            "frames of each");
  app.add_option("--seed", options->seed, "of the random errors (1)")->type_name("N");
  app.add_option("-o,--output", options->output.path, "folder; '' for none (out)")
      ->type_name("OUT");
  addOverwrite(app, options->output.may_replace);
  app.add_option_function<float>(
         "-t,--threshold",
         [options](float threshold) {
           if (!std::isfinite(threshold))
             throw UsageError("--threshold must be a finite number");
           options->threshold = threshold;
         },
         "least intensity that denoising keeps, instead of the outlier filter")
      ->type_name("I");
  options->encoding.setDefaults(cell_resolution, cell_law);
  options->encoding.codec().effort = effort_of_files;
  options->encoding.addCropOption(app);
  options->encoding.addCodecOptions(app);
  addQuiet(app, options->is_quiet);
  return [options] { return Demo(*options).run(); };
}

} // namespace pcl_ext::tools
