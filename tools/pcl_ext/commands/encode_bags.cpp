// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/encode_bags.h"

#include "console/exit_status.h"
#include "console/interruption.h"
#include "measuring/markdown_table.h"
#include "outputs/manifest.h"
#include "recording/rosbag2_folder.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <filesystem>
#include <iostream>
#include <map>
#include <mutex>
#include <optional>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;
using measuring::formatted;

/** \brief Which recording a bag becomes. */
std::string
outputOf(const std::string& bag, const std::string& folder)
{
  const fs::path path =
      fs::path(bag).has_filename() ? fs::path(bag) : fs::path(bag).parent_path();
  const fs::path name = fs::is_directory(path)
                            ? path.filename()
                            : fs::path(recording::nameOfBagFile(path.string()));
  return (fs::path(folder) / name).string() + ".mcap";
}

std::string
megabytes(std::uintmax_t bytes)
{
  return formatted(static_cast<double>(bytes) / 1e6, 1);
}

class BagsEncoding {
public:
  BagsEncoding(const EncodeOptions& options,
               const std::vector<std::string>& bags,
               const std::string& manifest_options)
  : options_(options), console_("encode", options.is_quiet), crew_(options.jobs)
  {
    if (options.reports_progress)
      console_.reportProgress();
    checkFolder();
    pairWithOutputs(bags);
    manifest_.emplace(
        options.output.path, manifest_options, options.output.may_replace);
    for (Bag& bag : bags_) {
      bag.is_done = bag.is_skipped = manifest_->isDone(bag.paths);
      if (!bag.is_done)
        // One that a run before has begun is replaced.
        refuseTakenFile({bag.paths.input},
                        bag.paths.output,
                        options.output.may_replace || manifest_->isOwn(bag.paths));
    }
  }

  int
  run()
  {
    const auto to_do = static_cast<std::size_t>(std::count_if(
        bags_.begin(), bags_.end(), [](const Bag& bag) { return !bag.is_done; }));
    if (to_do < bags_.size())
      console_.remark(counted(bags_.size() - to_do, "bag") +
                      " done before and unchanged");
    console_.startProgress("bags", to_do);
    runInThreads(options_.jobs, [this] { work(); });
    console_.endProgress();
    if (fault_)
      std::rethrow_exception(fault_);
    return report();
  }

private:
  struct Bag {
    BagToEncode paths;
    bool is_done = false;           // also by a run before
    bool is_skipped = false;        // as a run before has done it
    std::vector<std::string> lines; // errors and remarks
    Json line;                      // of the manifest
  };

  void
  checkFolder() const
  {
    const std::string& folder = options_.output.path;
    std::error_code ignored;
    refuseDevice(folder);
    if (kindOfOutput(folder) != OutputKind::Folder)
      throw UsageError("'" + folder +
                       "' takes one bag, and there are more: name a folder, which gets "
                       "a recording of each");
    if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored))
      throw UsageError("'" + folder + "' is a file: name a folder for the recordings");
    if (recording::isRosbag2Folder(folder) &&
        !fs::exists(fs::path(folder) / Manifest::file_name, ignored))
      throw UsageError("'" + folder +
                       "' is a rosbag2 folder: name another one for the recordings");
    if (options_.input.has_rate)
      throw UsageError("--rate is for files; bags have their own times");
    options_.encoding.checkFrameId(true);
  }

  void
  pairWithOutputs(const std::vector<std::string>& bags)
  {
    std::map<std::string, std::string> taken; // output, input
    for (const std::string& input : bags) {
      const std::string output = outputOf(input, options_.output.path);
      const auto [known, is_new] = taken.emplace(output, input);
      if (!is_new)
        throw UsageError("'" + known->second + "' and '" + input +
                         "' would both become '" + output +
                         "': encode them into two folders");
      bags_.push_back({{input, output}, false, false, {}, {}});
      refuseTakenFile(bags, output, true);
    }
  }

  /** \brief Encodes one bag after the other, and then clouds of others' bags. */
  void
  work()
  {
    for (std::size_t i; (i = next_++) < bags_.size();)
      if (!bags_[i].is_done && !isInterrupted() && !has_fault_)
        try {
          ++running_;
          encode(bags_[i]);
          crew_.wake([this] { --running_; });
        }
        catch (...) { // the manifest cannot be written
          const std::lock_guard<std::mutex> lock(mutex_);
          fault_ = std::current_exception();
          has_fault_ = true;
          crew_.wake([this] { --running_; });
        }
    crew_.workUntil([this] { return running_ == 0; });
  }

  void
  encode(Bag& bag)
  {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      manifest_->begin(bag.paths);
    }
    // Of a run before; none else writes here.
    std::error_code ignored;
    fs::remove(bag.paths.output + unfinished_suffix, ignored);
    Console console("encode", options_.is_quiet);
    console.holdLines();
    Json line = encode(bag.paths, console);
    const std::lock_guard<std::mutex> lock(mutex_);
    manifest_->finish(bag.paths, line);
    bag.line = manifest_->lineOf(bag.paths);
    bag.lines = console.takeLines();
    bag.is_done = true;
    console_.advance();
    printLines();
  }

  Json
  encode(const BagToEncode& bag, Console& console)
  {
    EncodeOptions options = options_;
    options.input.inputs = {bag.input};
    options.output = {bag.output, true};
    InputState state;
    std::string status = "failed";
    const auto at_once =
        static_cast<unsigned int>(std::min<std::size_t>(crew_.size(), bags_.size()));
    BagEncoding encoding(options, console, crew_, crew_.size() / at_once);
    try {
      state = stateOf(bag.input);
      status = statusName(encoding.run());
    }
    catch (const std::exception& error) {
      console.error(error.what());
    }
    if (isInterrupted() && status == "failed")
      status = "interrupted";
    std::error_code error;
    const std::uintmax_t size =
        status == "failed" ? 0 : fs::file_size(bag.output, error);
    Json line =
        toJson({bag.input}, bag.output, status, encoding.summary(), console.errors());
    line.erase("inputs");
    line.erase("output");
    line.update({{"input_bytes", state.bytes},
                 {"input_mtime_ns", state.mtime_ns},
                 {"output_bytes", error ? 0 : size}});
    return line;
  }

  /** \brief Prints what was kept of bags before which none is at work, so that lines are
   * in the order of the bags. */
  void
  printLines()
  {
    for (; printed_ < bags_.size() && bags_[printed_].is_done; ++printed_)
      for (const std::string& line : bags_[printed_].lines)
        console_.error(bags_[printed_].paths.input + ": " + line);
  }

  int
  report()
  {
    std::size_t failed = 0;
    std::size_t frames = 0;
    std::uintmax_t bytes_in = 0;
    std::uintmax_t bytes_out = 0;
    measuring::MarkdownTable failures({"bag", "status", "frames", "why"});
    Json json = {{"bags", Json::array()}};
    for (Bag& bag : bags_) {
      if (bag.line.is_null())
        bag.line = manifest_->lineOf(bag.paths);
      const std::string status = bag.line.value("status", "not begun");
      const std::size_t of_bag = bag.line.value("frames", std::size_t{0});
      frames += of_bag;
      bytes_in += bag.line.value("input_bytes", std::uintmax_t{0});
      bytes_out += bag.line.value("output_bytes", std::uintmax_t{0});
      if (status != "done") {
        ++failed;
        const std::vector<std::string> errors =
            bag.line.value("errors", std::vector<std::string>());
        failures.addRow({bag.paths.input,
                         status,
                         formatted(static_cast<double>(of_bag), 0),
                         errors.empty() ? "" : errors[0]});
      }
      bag.line["inputs"] = {bag.paths.input};
      bag.line["output"] = bag.paths.output;
      bag.line["skipped"] = bag.is_skipped;
      json["bags"].push_back(bag.line);
    }
    json["left_out"] = options_.left_out;
    if (options_.is_json)
      std::cout << asText(json);
    else
      printTables(failed, frames, bytes_in, bytes_out, failures);
    return isInterrupted() ? interrupted : failed > 0 ? something_failed : all_done;
  }

  void
  printTables(std::size_t failed,
              std::size_t frames,
              std::uintmax_t bytes_in,
              std::uintmax_t bytes_out,
              const measuring::MarkdownTable& failures) const
  {
    measuring::MarkdownTable sums({"bags", "not done", "frames", "MB in", "MB out"});
    sums.addRow({formatted(static_cast<double>(bags_.size()), 0),
                 formatted(static_cast<double>(failed), 0),
                 formatted(static_cast<double>(frames), 0),
                 megabytes(bytes_in),
                 megabytes(bytes_out)});
    sums.print(std::cout);
    if (failed > 0)
      failures.print(std::cout);
  }

  const EncodeOptions& options_;
  Console console_;
  Crew crew_;
  std::vector<Bag> bags_;
  std::optional<Manifest> manifest_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> running_{0};
  std::atomic<bool> has_fault_{false};
  std::mutex mutex_; // of what follows, the manifest and the console
  std::exception_ptr fault_;
  std::size_t printed_ = 0; // bags
};

} // namespace

int
encodeBags(const EncodeOptions& options,
           const std::vector<std::string>& bags,
           const std::string& manifest_options)
{
  return BagsEncoding(options, bags, manifest_options).run();
}

} // namespace pcl_ext::tools
