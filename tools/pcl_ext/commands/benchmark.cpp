// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>

#include "commands/benchmark_report.h"
#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "inputs/tried_input.h"
#include "measuring/cycle_counter.h"
#include "options/encoding_options.h"
#include "options/options.h"
#include "outliers/unit_choice.h"
#include "streams/stream_decoder.h"
#include "streams/stream_encoder.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

namespace pcl_ext::tools {

namespace {

struct BenchmarkOptions {
  TriedInput input;
  EncodingOptions encoding;
  Output json; ///< empty: none
  std::size_t frames = 300;
  std::vector<io::Effort> efforts;
  std::string given;
  bool is_quiet = false;
};

/** \brief Encodes, decodes and filters the clouds of one stream in turn. */
class MeasuredStream {
public:
  /** \param[in,out] clouds whose stamps go on where they are repeated
   * \param[in] counter of the calling thread
   */
  MeasuredStream(const EncodingOptions& options,
                 HeldClouds& clouds,
                 const measuring::CycleCounter& counter)
  : options_(options)
  , clouds_(clouds)
  , counter_(counter)
  , encoder_(options, clouds.name)
  , first_stamp_(clouds.clouds.front().header.stamp)
  {
    decoder_.setDecodesVoxels(false); // which the filter makes
    row_.stream = clouds.name;
    row_.effort = options.codec().format == io::StreamFormat::Published
                      ? "published"
                      : nameOf(io::efforts, options.codec().effort);
    row_.clouds = clouds.clouds.size();
    row_.period = clouds.period;
    row_.has_assumed_period = clouds.has_assumed_period;
  }

  /** \brief Takes the next cloud through all steps.
   * \throws std::runtime_error if one fails
   */
  void
  run()
  {
    encoder_.chooseLaw(clouds_.clouds);
    pcl::PCLPointCloud2& cloud = clouds_.clouds[row_.frames % clouds_.clouds.size()];
    cloud.header.stamp =
        first_stamp_ + static_cast<std::uint64_t>(std::llround(
                           1e6 * clouds_.period * static_cast<double>(row_.frames)));
    const std::string source = clouds_.name + ", frame " + std::to_string(row_.frames);
    measure(0, [&] { encoder_.encode(cloud, source, bytes_); });
    io::CompressionStatus status;
    measure(1,
            [&] { status = decoder_.decode(bytes_.data(), bytes_.size(), voxels_); });
    throwUnlessOk(status);
    ++row_.frames;
    row_.bytes += bytes_.size();
    filter();
  }

  BenchmarkRow
  row() const
  {
    BenchmarkRow row = row_;
    row.points = encoder_.sums().points;
    row.voxels = encoder_.sums().voxels + encoder_.sums().points_in_order;
    return row;
  }

  IntensityLaw
  law() const
  {
    return encoder_.law();
  }

  std::string
  pointsOutsideGrid() const
  {
    return describePointsOutsideGrid(encoder_.sums());
  }

private:
  template <typename ActionT>
  void
  measure(std::size_t step, const ActionT& action)
  {
    const std::uint64_t cycles = counter_.count();
    row_.steps[step].ms.add(measuring::wallTimeOf(action));
    row_.steps[step].cycles += counter_.count() - cycles;
  }

  /** \brief As the receiver does. */
  void
  filter()
  {
    if (!row_.filter_failure.empty())
      return;
    if (!removal_)
      removal_.emplace(VoxelOutlierRemovalSettings{
          automaticUnitOf(voxels_, encoder_.law(), encoder_.isOfLidar())});
    OutlierRemovalStatus status;
    measure(2, [&] { status = removal_->filter(voxels_); });
    row_.removed += status.removed;
    if (!status.ok()) {
      row_.filter_failure = status.message();
      row_.steps[2] = StepTimes();
    }
  }

  const EncodingOptions& options_;
  HeldClouds& clouds_;
  const measuring::CycleCounter& counter_;
  StreamEncoder encoder_;
  io::FrameDecoder decoder_;
  std::optional<VoxelOutlierRemoval> removal_;
  std::uint64_t first_stamp_; // microseconds
  std::vector<std::uint8_t> bytes_;
  io::VoxelFrame voxels_;
  BenchmarkRow row_;
};

/** \brief Refuses a file that cannot be written, before the frames are measured. */
void
checkJson(const BenchmarkOptions& options)
{
  namespace fs = std::filesystem;
  const std::string& path = options.json.path;
  refuseTakenFile(options.input.input.inputs, path, options.json.may_replace);
  if (path == "-")
    return;
  const fs::path folder = fs::absolute(path).parent_path();
  if (fs::is_directory(path) || !fs::is_directory(folder))
    throw UsageError("--json: '" + path +
                     "' cannot be a file: it is a folder, or there " +
                     "is no folder for it");
}

void
writeJson(const Output& output, const BenchmarkReport& report)
{
  std::ofstream file;
  if (output.path != "-")
    file.open(output.path);
  std::ostream& stream = output.path == "-" ? std::cout : file;
  // Names may have any bytes.
  stream << toJson(report).dump(2, ' ', false, nlohmann::json::error_handler_t::replace)
         << std::endl;
  if (!stream)
    throw std::runtime_error("cannot write '" + output.path + "'");
}

int
benchmark(BenchmarkOptions options)
{
  Console console("benchmark", options.is_quiet);
  if (!options.json.path.empty())
    checkJson(options);
  BenchmarkReport report;
  report.machine = measuring::thisMachine();
  std::vector<HeldClouds> streams =
      holdTriedInput(options.input, options.encoding, options.frames, console);
  options.encoding.check();
  const measuring::CycleCounter counter;
  report.has_cycles = counter.isAvailable();
  report.resolution = options.encoding.codec().resolution;
  report.i_frame_rate = options.encoding.codec().i_frame_rate;
  report.given = options.given;
  report.held_megabytes = measuring::residentMegabytes();
  bool has_failures = false;
  console.startProgress("frames",
                        options.frames * options.efforts.size() * streams.size());
  for (HeldClouds& stream : streams) {
    has_failures |= !stream.failures.empty() || stream.clouds.empty();
    for (const io::Effort effort : options.efforts) {
      if (stream.clouds.empty() || isInterrupted())
        break;
      options.encoding.codec().effort = effort;
      MeasuredStream measured(options.encoding, stream, counter);
      for (std::size_t i = 0; i < options.frames && !isInterrupted(); ++i) {
        measured.run();
        console.advance();
      }
      report.rows.push_back(measured.row());
      if (const std::string outside = measured.pointsOutsideGrid(); !outside.empty()) {
        console.error(outside);
        has_failures = true;
      }
      const std::string law = nameOf(measured.law());
      if (report.law.find(law) == std::string::npos)
        report.law += (report.law.empty() ? "" : " and ") + law;
    }
  }
  console.endProgress();
  if (report.rows.empty() && !isInterrupted())
    throw std::runtime_error("there is no cloud to measure with");
  report.peak_megabytes = measuring::peakResidentMegabytes();
  report.load_at_end = measuring::loadAverage();
  if (options.json.path != "-")
    printBenchmark(report, std::cout);
  if (!options.json.path.empty())
    writeJson(options.json, report);
  return isInterrupted() ? interrupted : has_failures ? something_failed : all_done;
}

/** \brief What follows from which options are given. */
void
complete(const CLI::App& app, BenchmarkOptions& options)
{
  completeTriedInput(app, options.input, options.encoding);
  if (options.json.path.empty())
    refuseOptions(app, {"--overwrite"}, "is for the file of --json: add it");
  const io::EncoderSettings& codec = options.encoding.codec();
  if (isGiven(app, "--effort") || codec.format == io::StreamFormat::Published)
    options.efforts = {codec.effort};
  else
    for (const auto& [effort, name] : io::efforts)
      options.efforts.push_back(effort);
  for (const GivenOption& option : givenOptions(app))
    options.given += ' ' + option.text();
}

} // namespace

Run
addBenchmark(CLI::App& app)
{
  const auto options = std::make_shared<BenchmarkOptions>();
  addTriedInput(app, options->input);
  addNumber(app,
            "-n,--frames",
            options->frames,
            std::size_t{1},
            std::size_t{1} << 30,
            "N",
            "of each effort; clouds are repeated until then");
  app.add_option("--json", options->json.path, "a file for programs; - alone")
      ->type_name("FILE");
  addOverwrite(app, options->json.may_replace);
  options->encoding.addCodecOptions(app);
  options->encoding.addCloudOptions(app);
  addQuiet(app, options->is_quiet);
  return [options, &app] {
    complete(app, *options);
    return benchmark(*options);
  };
}

} // namespace pcl_ext::tools
