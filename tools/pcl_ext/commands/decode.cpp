// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/filters/lidar_clouds.h>

#include "commands/commands.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/point_cloud_conversions.h"
#include "inputs/recording_input.h"
#include "measuring/markdown_table.h"
#include "options/decoding_options.h"
#include "options/options.h"
#include "options/setting_options.h"
#include "outputs/cloud_folder.h"
#include "outputs/decoded_bag.h"
#include "outputs/output_path.h"
#include "streams/frame_failures.h"
#include "streams/stream_decoder.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>

namespace pcl_ext::tools {

namespace {

using measuring::formatted;
using recording::RecordedFrame;

/** \brief Order of the points of decoded clouds. */
enum class PointOrder { AsDecoded, ByTime, ByRing };

struct DecodeOptions {
  std::string input;
  Output output;
  Selection selection;
  DecodingOptions decoding;
  CloudFormat format = CloudFormat::PcdCompressed;
  bool is_bag = false;
  bool is_packed = false;
  PointOrder order = PointOrder::AsDecoded;
  bool is_quiet = false;
  const CLI::App* app = nullptr; // whose options these are
};

/** \brief Decodes the frames of a recording into files, or a bag. */
class Decode {
public:
  explicit Decode(const DecodeOptions& options)
  : options_(options)
  , console_("decode", options.is_quiet)
  , is_bag_(isBag(options))
  , input_(is_bag_ ? RecordingInput::openBag(options.input)
                   : RecordingInput(options.input))
  , failures_([this](const std::string& line) { console_.error(line); })
  {
    input_.select(options.selection);
    refuseTakenFile({input_.path()}, options.output.path, options.output.may_replace);
    std::vector<std::string> chosen;
    for (std::size_t stream = 0; stream < input_.reader().streams().size(); ++stream) {
      decoders_.emplace_back(
          input_.reader(), stream, input_.nameOf(stream), options.decoding, voxels_);
      viewpoints_.emplace_back(input_.reader().streams()[stream].metadata);
      folder_of_stream_.push_back(chosen.size());
      if (input_.isChosen(stream))
        chosen.push_back(input_.nameOf(stream));
    }
    if (is_bag_)
      bag_ = std::make_unique<DecodedBag>(options.output, input_, options.is_packed);
    else
      folder_ = std::make_unique<CloudFolder>(options.output.path,
                                              options.format,
                                              options.output.may_replace,
                                              folderNames(chosen));
    streams_ = chosen.size();
  }

  int
  run()
  {
    console_.startProgress("frames", input_.size());
    RecordingInput::Item item;
    while (!isInterrupted() && input_.next(item)) {
      if (item.is_frame)
        decode(item);
      else if (bag_) {
        bag_->passThrough(item, input_);
        ++other_messages_;
      }
      console_.advance();
    }
    failures_.finish();
    console_.endProgress();
    remarkOnMemory(options_.decoding.limits, console_);
    for (const std::string& place : input_.damage())
      console_.error(place);
    if (const std::string remark = input_.unfinishedRemark(); !remark.empty())
      console_.remark(remark);
    if (outside_grid_ > 0)
      console_.error(first_outside_grid_ + "; in all frames " +
                     counted(outside_grid_, "point"));
    bool is_failure = false;
    for (const StreamDecoder& decoder : decoders_) {
      is_failure |= decoder.isFailure();
      if (const std::string remark = decoder.remark(); decoder.isFailure())
        console_.error(remark);
      else if (!remark.empty())
        console_.remark(remark);
    }
    if (bag_)
      remarkOnLayouts();
    if (frames_ == 0)
      throw std::runtime_error("no frame could be decoded; '" + options_.output.path +
                               "' was not written");
    printSummary(bag_ ? bag_->finish(input_) : folder_->finish());
    if (isInterrupted())
      return interrupted;
    return is_failure || lost_ + outside_grid_ + unordered_ > 0 ||
                   !input_.damage().empty()
               ? something_failed
               : all_done;
  }

private:
  /** \brief True if the clouds go into a bag.
   * \throws UsageError if there is no such output, or options are for the other kind
   */
  static bool
  isBag(const DecodeOptions& options)
  {
    const std::string& path = options.output.path;
    const std::string extension = std::filesystem::path(path).extension().string();
    for (const char* other : {".pcxi", ".pcd", ".ply", ".bag", ".db3"})
      if (path == "-" || path.empty() || extension == other)
        throw UsageError("'" + path +
                         "' is no output of this command: name a folder for files, or "
                         "x.mcap for a bag");
    if (!options.is_bag && extension != ".mcap") {
      refuseDevice(path);
      refuseOptions(*options.app,
                    {"--packed"},
                    "is for a bag, and '" + path +
                        "' is a folder of files: leave it out, or name x.mcap");
      return false;
    }
    refuseOptions(*options.app,
                  {"--ply", "--pcd"},
                  "is for a folder of files, and '" + path +
                      "' is a bag: leave it out, or name a folder");
    checkOutput(path);
    return true;
  }

  void
  remarkOnLayouts()
  {
    for (const auto& [stream, reason] : bag_->streamsWithoutLayout())
      console_.remark(input_.nameOf(stream) +
                      ": messages do not have the layout that they had, as " + reason);
    for (const auto& [stream, limited] : bag_->streamsWithLimitedNumbers())
      console_.remark(input_.nameOf(stream) + ": " + counted(limited, "number") +
                      " (intensities or fields) outside of the types that the messages "
                      "had are limited to these; --packed keeps them");
  }

  void
  decode(const RecordingInput::Item& item)
  {
    StreamDecoder& decoder = decoders_[item.stream];
    std::string failure;
    const auto read = input_.read(item, frame_);
    if (input_.size() == 1)
      console_.status("decoding " +
                      counted(frame_.description.voxels,
                              frame_.description.has_points ? "point" : "voxel"));
    io::CompressionStatus status;
    if (!read.ok())
      failure = read.message();
    else if (status = decoder.decode(frame_); !status.ok())
      failure = reasonOf(status);
    if (!item.is_wanted)
      return;
    if (!failure.empty()) {
      ++lost_;
      failures_.add(input_.nameOf(item.stream),
                    item.number,
                    " at byte " + std::to_string(frame_.offset),
                    failure);
      return;
    }
    ++frames_;
    if (status.hasWarning() && outside_grid_ == 0)
      first_outside_grid_ = input_.nameOf(item.stream) + ", frame " +
                            std::to_string(item.number) + ": " + messageOf(status);
    outside_grid_ += decoder.voxels().points.outside_grid;
    decoded_ += decoder.decodedVoxels();
    removed_ += decoder.decodedVoxels() - decoder.voxels().size();
    toCloud(decoder.voxels(), cloud_);
    orderPoints(item);
    points_ += decoder.voxels().pointCount();
    if (bag_)
      bag_->write(item, frame_, decoder.voxels().layout.get(), cloud_, input_);
    else if (decoder.voxels().pointCount() > 0 || hasMissingPoints())
      folder_->write(folder_of_stream_[item.stream],
                     item.number,
                     cloud_,
                     frame_.stamp.count() != 0 ? frame_.stamp : item.time,
                     viewpoints_[item.stream].at(item.time));
    else
      ++empty_;
  }

  /** \brief Whether a cloud without points has rows and columns of missing ones, and the
   * files, too. */
  bool
  hasMissingPoints() const
  {
    return cloud_.width > 0 && cloud_.height > 0 && options_.format != CloudFormat::Ply;
  }

  /** \brief Puts the points of a cloud into the order that was asked for. Of each
   * stream the first failure is told. */
  void
  orderPoints(const RecordingInput::Item& item)
  {
    if (options_.order == PointOrder::AsDecoded || cloud_.width == 0)
      return;
    const PreprocessingStatus status = options_.order == PointOrder::ByTime
                                           ? sortByTime(cloud_)
                                           : arrangeByRing(cloud_);
    if (status.ok())
      return;
    ++unordered_;
    if (unordered_streams_.insert(item.stream).second)
      console_.error(
          input_.nameOf(item.stream) + ", frame " + std::to_string(item.number) +
          ": its points stay in the order of the frame: " + status.message());
  }

  /** \brief What outliers were judged by: the units of the streams. */
  std::string
  judgedBy() const
  {
    std::string text;
    for (const auto& [unit, name] : density_units)
      if (std::any_of(decoders_.begin(),
                      decoders_.end(),
                      [chosen = unit](const StreamDecoder& decoder) {
                        return decoder.judgedBy() == chosen;
                      }))
        text += std::string(text.empty() ? ", judged by " : " and ") + name;
    return text;
  }

  /** \param[in] ending what became of what was there before */
  void
  printSummary(const std::string& ending)
  {
    const auto number = [](std::size_t count) {
      return formatted(static_cast<double>(count), 0);
    };
    std::string line = options_.output.path + ": " + counted(frames_, "frame");
    if (streams_ > 1)
      line += " of " + std::to_string(streams_) + " streams";
    line += ", " + counted(points_, "point");
    if (empty_ > 0)
      line += ", " + counted(empty_, "frame") + " without points and file";
    if (options_.decoding.removes_outliers || options_.decoding.min_intensity)
      line += ", " +
              formatted(100.0 * static_cast<double>(removed_) /
                            static_cast<double>(std::max<std::size_t>(decoded_, 1)),
                        1) +
              " % of the voxels or points left out" + judgedBy();
    if (other_messages_ > 0)
      line += ", " + counted(other_messages_, "other message") + " passed through";
    if (unordered_ > 0)
      line += ", " + counted(unordered_, "frame") + " in the order that it had";
    if (lost_ > 0)
      line += ", " + number(lost_) + " lost";
    console_.summary(line + ending);
  }

  DecodeOptions options_;
  Console console_;
  bool is_bag_;
  RecordingInput input_;
  FrameFailures failures_;
  io::VoxelFrame voxels_;                     // of the last frame
  std::vector<StreamDecoder> decoders_;       // of each stream
  std::vector<std::size_t> folder_of_stream_; // likewise
  std::vector<Viewpoints> viewpoints_;        // likewise
  std::size_t streams_ = 0;                   // that were chosen
  std::unique_ptr<DecodedBag> bag_;           // or the next one
  std::unique_ptr<CloudFolder> folder_;
  RecordedFrame frame_;
  pcl::PCLPointCloud2 cloud_;
  std::size_t frames_ = 0;
  std::size_t points_ = 0;
  std::size_t empty_ = 0;
  std::size_t decoded_ = 0; // voxels
  std::size_t removed_ = 0; // of these
  std::size_t other_messages_ = 0;
  std::size_t lost_ = 0;
  std::size_t unordered_ = 0; // frames whose points could not be ordered
  std::set<std::size_t> unordered_streams_;
  std::size_t outside_grid_ = 0; // points without a voxel
  std::string first_outside_grid_;
};

constexpr std::array<NamedValue<CloudFormat>, 3> pcd_formats = {
    {{CloudFormat::PcdBinary, "binary"},
     {CloudFormat::PcdCompressed, "compressed"},
     {CloudFormat::PcdAscii, "ascii"}}};

} // namespace

Run
addDecode(CLI::App& app)
{
  const auto options = std::make_shared<DecodeOptions>();
  addInput(app, options->input, "recording; - is standard input");
  addOutput(app, options->output, "folder for the clouds, one file a frame; or x.mcap");
  CLI::Option* const pcd =
      addChoice(app, "--pcd", pcd_formats, options->format, "kind of PCD files");
  CLI::Option* const ply = app.add_flag_callback(
      "--ply", [options] { options->format = CloudFormat::Ply; }, "PLY files");
  CLI::Option* const bag = app.add_flag(
      "--bag", options->is_bag, "OUT is a rosbag2 folder with PointCloud2");
  app.add_flag("--packed",
               options->is_packed,
               "points of a bag without padding, instead of the layout of the messages "
               "that the stream was made of");
  const auto add_order = [&](const char* name, PointOrder order, const char* help) {
    return app.add_flag_callback(
        name, [options, order] { options->order = order; }, help);
  };
  CLI::Option* const by_time = add_order(
      "--sort-by-time",
      PointOrder::ByTime,
      "points in the order in which a lidar measured them, by their fields of "
      "time and ring");
  add_order("--arrange-by-ring",
            PointOrder::ByRing,
            "points in a row for each ring and a column for each time")
      ->excludes(by_time);
  ply->excludes(pcd);
  bag->excludes(pcd)->excludes(ply);
  addDecodingOptions(app, options->decoding);
  addSelection(app, options->selection);
  addQuiet(app, options->is_quiet);
  options->app = &app;
  return [options] { return Decode(*options).run(); };
}

} // namespace pcl_ext::tools
