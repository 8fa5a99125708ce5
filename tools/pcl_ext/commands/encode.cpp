#include "commands/commands.h"
#include "commands/encode_summary.h"
#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/cloud_input.h"
#include "inputs/point_cloud_conversions.h"
#include "measuring/markdown_table.h"
#include "options/encoding_options.h"
#include "options/options.h"
#include "outputs/frame_output.h"
#include "outputs/output_path.h"
#include "streams/frame_failures.h"
#include "streams/stream_encoder.h"

#include <algorithm>
#include <memory>
#include <optional>

namespace pcl_ext {
namespace tools {

namespace {

using measuring::formatted;
using recording::McapMessage;

struct EncodeOptions {
  InputOptions input;
  EncodingOptions encoding;
  Output output;
  bool is_quiet = false;
};

/** \brief Encodes all clouds of an input. */
class Encode {
public:
  explicit Encode(const EncodeOptions& options)
  : options_(options)
  , console_("encode")
  , failures_([this](const std::string& line) { console_.error(line); })
  {
    if (options.is_quiet)
      console_.beQuiet();
    if (options.output.path == "-")
      console_.keepOutputFree();
  }

  int
  run()
  {
    options_.encoding.check();
    const std::string& path = options_.output.path;
    checkOutput(path);
    const OutputKind kind = kindOfOutput(path);
    options_.encoding.checkFrameId(kind != OutputKind::Frames);
    options_.input.may_have_streams = kind != OutputKind::Frames;
    input_ = openInput(options_.input);
    refuseTakenFile(options_.input.inputs, path, options_.output.may_replace);
    for (const std::string& remark : input_->remarks())
      console_.remark(remark);
    const std::vector<std::string>& names = input_->streams();
    if (!input_->isLive()) // else there may be more
      options_.encoding.checkStreams(names);
    checkNumberOfStreams();
    // Not only of bags: the messages tell how many points the clouds had.
    output_.emplace(options_.output, true, input_->profile());
    addStreams();
    // Who writes a pipe may wait for what becomes of it.
    input_->setBeforeWaiting([this] { output_->flush(); });
    encodeAll();
    return finish();
  }

private:
  struct Stream {
    Stream(const EncodingOptions& options, const std::string& name)
    : encoder(options, name)
    {}

    StreamEncoder encoder;
    std::optional<std::size_t> output;
    std::vector<InputCloud> waiting; // empty ones, until there is one with a law
    std::size_t failures = 0;
    bool is_refused = false;       // its clouds are left out
    recording::Time first_time{0}; // of the frames
    recording::Time last_time{0};
  };

  /** \brief True for channels whose messages are not encoded. */
  bool
  passesThrough(const recording::McapChannel& channel) const
  {
    const std::vector<std::string>& names = input_->streams();
    const bool is_cloud = recording::isPointCloud(channel) ||
                          channel.schema.name == "sensor_msgs/PointCloud2"; // of ROS 1
    return !is_cloud ||
           std::find(names.begin(), names.end(), channel.topic) == names.end();
  }

  void
  checkNumberOfStreams() const
  {
    const std::string& path = options_.output.path;
    const std::vector<std::string>& names = input_->streams();
    if (kindOfOutput(path) != OutputKind::Frames || names.size() < 2)
      return;
    throw UsageError("'" + path + "' takes one stream, and there are " +
                     std::to_string(names.size()) + ": " + names[0] + ", " + names[1] +
                     (names.size() > 2 ? ", ..." : "") +
                     (input_->isBag() ? "; choose one with --topics or name x.mcap"
                                      : "; name x.mcap"));
  }

  /** \brief Adds the streams and channels of the input that there were not before. */
  void
  addStreams()
  {
    const std::vector<std::string>& names = input_->streams();
    while (streams_.size() < names.size()) {
      const std::size_t number = streams_.size();
      streams_.push_back(std::make_unique<Stream>(options_.encoding, names[number]));
      if (number > 0)
        tryOn(number, [this] { checkNumberOfStreams(); });
    }
    const std::vector<recording::McapChannel>& channels = input_->channels();
    while (other_channels_.size() < channels.size()) {
      const recording::McapChannel& channel = channels[other_channels_.size()];
      other_channels_.push_back(passesThrough(channel) && output_->isBag()
                                    ? std::optional(output_->addChannel(
                                          channel, recording::McapChunking::Shared))
                                    : std::nullopt);
    }
  }

  /** \brief Does a step on a stream. If the command line is not one for it, the other
   * streams go on.
   * \throws UsageError if that is noticed before the first frame; nothing is written
   * then
   */
  template <typename StepT>
  void
  tryOn(std::size_t number, const StepT& step)
  {
    try {
      step();
    }
    catch (const UsageError& error) {
      if (std::none_of(streams_.begin(), streams_.end(), [](const auto& stream) {
            return stream->output.has_value();
          })) {
        output_->discard();
        throw;
      }
      console_.error(input_->streams()[number] +
                     ": its clouds are left out: " + error.what());
      Stream& stream = *streams_[number];
      stream.is_refused = true;
      stream.failures += stream.waiting.size();
      stream.waiting.clear();
    }
  }

  void
  encodeAll()
  {
    InputCloud cloud;
    McapMessage other;
    console_.startProgress(input_->isBag() ? "messages" : "clouds", input_->size());
    while (!isInterrupted()) {
      const CloudInput::Found found = input_->next(cloud, other);
      if (found == CloudInput::Found::End)
        break;
      addStreams();
      if (found == CloudInput::Found::Cloud)
        encode(cloud);
      else if (found == CloudInput::Found::Extra)
        input_->copyExtra(*output_);
      else
        passThrough(other);
      console_.advance();
    }
    console_.endProgress();
  }

  /** \brief Encodes a cloud, when the law of its stream is known. */
  void
  encode(const InputCloud& cloud)
  {
    Stream& stream = *streams_[cloud.stream];
    if (stream.is_refused) {
      ++stream.failures;
      return;
    }
    tryOn(cloud.stream, [&] { encode(stream, cloud); });
    stream.failures += stream.is_refused ? 1 : 0;
  }

  void
  encode(Stream& stream, const InputCloud& cloud)
  {
    if (cloud.failure.empty() && stream.encoder.leavesLawOpen(cloud.cloud)) {
      stream.waiting.push_back(cloud);
      return;
    }
    if (cloud.failure.empty() && !stream.waiting.empty()) {
      stream.encoder.chooseLaw(cloud.cloud);
      encodeWaiting(stream);
    }
    encodeNow(stream, cloud);
  }

  void
  encodeWaiting(Stream& stream)
  {
    for (const InputCloud& waiting : stream.waiting)
      encodeNow(stream, waiting);
    stream.waiting.clear();
  }

  void
  encodeNow(Stream& stream, const InputCloud& cloud)
  {
    std::string failure = cloud.failure;
    if (failure.empty())
      try {
        if (!stream.encoder.encode(
                cloud.cloud, cloud.source, frame_.bytes, cloud.message.log_time))
          return;
      }
      catch (const UsageError&) {
        throw;
      }
      catch (const std::runtime_error& error) {
        failure = error.what();
      }
    if (!failure.empty()) {
      // The next clouds may be valid.
      failures_.add(input_->streams()[cloud.stream], cloud.number, "", failure);
      ++stream.failures;
      return;
    }
    if (!stream.output) {
      stream.output = addStream(cloud.stream, stream);
      stream.first_time = cloud.message.log_time;
    }
    stream.last_time = cloud.message.log_time;
    frame_.message.log_time = cloud.message.log_time;
    frame_.message.publish_time = cloud.message.publish_time;
    frame_.message.sequence = cloud.message.sequence;
    frame_.cloud = describeCloud(cloud.cloud, cloud.stamp);
    frame_.cloud.frame_id = stream.encoder.frameId();
    output_->write(*stream.output, frame_);
  }

  std::size_t
  addStream(std::size_t number, const Stream& stream)
  {
    recording::StreamToRecord added;
    added.name = input_->streams()[number];
    if (input_->isBag())
      added.name += compressed_suffix;
    added.frame_id = stream.encoder.frameId();
    const std::string& name = input_->streams()[number];
    added.metadata = options_.encoding.metadataOf(name, stream.encoder.law());
    addViewpoints(number, added.metadata);
    for (const recording::McapChannel& channel : input_->channels())
      if (channel.topic == name)
        addOtherMetadata(channel.metadata, added.metadata);
    return output_->addStream(added);
  }

  void
  addViewpoints(std::size_t number, StreamMetadata& metadata)
  {
    const std::string& name = input_->streams()[number];
    const Viewpoints viewpoints = input_->viewpointsOf(number);
    if (viewpoints.areDefault())
      return;
    if (options_.encoding.hasPose(name))
      console_.remark(name + ": the VIEWPOINT of the files is left out, as it does not "
                             "hold for points that --pose has moved");
    else if (!output_->isBag())
      console_.remark(name +
                      ": the VIEWPOINT of the files is left out, as a .pcxi file "
                      "has no field for it; x.mcap has");
    else
      viewpoints.addTo(metadata);
  }

  void
  passThrough(McapMessage& message)
  {
    if (!output_->isBag() || !other_channels_[message.channel])
      return;
    message.channel = *other_channels_[message.channel];
    output_->write(message);
    ++other_messages_;
  }

  /** \brief Prints what is to be known of a stream.
   * \return false if nothing of it was encoded
   */
  bool
  report(const Stream& stream)
  {
    const EncodedSums& sums = stream.encoder.sums();
    if (sums.warnings > 0)
      console_.remark(
          sums.first_warning +
          (sums.warnings > 1
               ? " (and " + counted(sums.warnings - 1, "more frame") + " with warnings)"
               : ""));
    const auto& kept = options_.encoding.codec().fields;
    const bool are_all = std::any_of(kept.begin(), kept.end(), [](const auto& field) {
      return field.name == io::all_fields;
    });
    if (const std::string& left_out = stream.encoder.leftOut(); !left_out.empty())
      console_.remark(stream.encoder.name() + ": " + left_out +
                      (left_out.rfind("fields", 0) == 0 && !are_all
                           ? "; --fields keeps fields"
                           : ""));
    for (const std::string& remark : {stream.encoder.budgetRemark(),
                                      stream.encoder.frameIdRemark(),
                                      stream.encoder.unitRemark(),
                                      stream.encoder.outlierRemark()})
      if (!remark.empty())
        console_.remark(remark);
    if (sums.frames == 0 && sums.clouds_left_out > 0) {
      console_.error(stream.encoder.name() +
                     ": --max-rate has no room for any of its " +
                     counted(sums.clouds_left_out, "cloud") +
                     ": raise it, --rate-buffer or --rate-doublings, or take a larger "
                     "--resolution");
      return false;
    }
    const std::string why = stream.encoder.whyNothingWasEncoded();
    if (!why.empty())
      console_.error(why);
    return why.empty();
  }

  int
  finish()
  {
    for (std::size_t number = 0; number < streams_.size(); ++number)
      if (!streams_[number]->is_refused)
        tryOn(number, [&] { encodeWaiting(*streams_[number]); });
    failures_.finish();
    std::size_t failures = 0;
    EncodedSums sums;
    bool has_empty_stream = false;
    for (const auto& stream : streams_) {
      const EncodedSums& part = stream->encoder.sums();
      failures += stream->failures;
      sums.frames += part.frames;
      sums.clouds_left_out += part.clouds_left_out;
      sums.largest_edge = std::max(sums.largest_edge, part.largest_edge);
      sums.all_points += part.all_points;
      sums.points += part.points;
      sums.encoded_points += part.encoded_points;
      sums.voxels += part.voxels;
      sums.outliers += part.outliers;
      sums.judged_by |= part.judged_by;
      sums.judged_points += part.judged_points;
      sums.point_outliers += part.point_outliers;
      sums.hidden_voxels += part.hidden_voxels;
      sums.held_voxels += part.held_voxels;
      sums.bytes += part.bytes;
      sums.point_bytes += part.point_bytes;
      has_empty_stream |= !report(*stream);
    }
    const std::vector<std::string> damage = input_->damage();
    for (const std::string& place : damage)
      console_.error(place);
    bool has_wrong_option =
        std::any_of(streams_.begin(), streams_.end(), [](const auto& stream) {
          return stream->is_refused;
        });
    try {
      options_.encoding.checkStreams(input_->streams());
    }
    catch (const UsageError& error) {
      console_.error(error.what());
      has_wrong_option = true;
    }
    if (sums.frames == 0) {
      output_.reset(); // which removes a file that holds nothing
      throw std::runtime_error((sums.clouds_left_out > 0
                                    ? "--max-rate has no room for any cloud; '"
                                    : "no cloud could be encoded; '") +
                               options_.output.path + "' was not written" +
                               describeUnfinished(options_.output.path));
    }
    if (input_->mcap() != nullptr && output_->isBag())
      output_->copyExtras(*input_->mcap());
    printSummary(sums, failures, output_->finish());
    if (isInterrupted())
      return interrupted;
    return failures > 0 || has_empty_stream || has_wrong_option || !damage.empty()
               ? something_failed
               : all_done;
  }

  /** \brief Bytes that all streams take in a second of their clouds; 0: unknown. */
  double
  bytesASecond() const
  {
    double rate = 0.0;
    for (const auto& stream : streams_) {
      const EncodedSums& sums = stream->encoder.sums();
      const double seconds =
          std::chrono::duration<double>(stream->last_time - stream->first_time).count();
      // The last frame is as long as the others.
      if (sums.frames > 1 && seconds > 0.0)
        rate += static_cast<double>(sums.bytes) / seconds *
                static_cast<double>(sums.frames - 1) / static_cast<double>(sums.frames);
    }
    return rate;
  }

  void
  printSummary(const EncodedSums& sums,
               std::size_t failures,
               const std::string& interruption)
  {
    std::string line = options_.output.path + ": " + counted(sums.frames, "frame");
    const auto streams =
        std::count_if(streams_.begin(), streams_.end(), [](const auto& stream) {
          return !stream->is_refused;
        });
    if (streams > 1)
      line += " of " + std::to_string(streams) + " streams";
    line += ", " + describeEncoded(sums, options_.encoding, bytesASecond());
    if (other_messages_ > 0)
      line += ", " + counted(other_messages_, "other message") + " passed through";
    if (failures > 0)
      line += ", " + formatted(static_cast<double>(failures), 0) + " failed";
    console_.summary(line + interruption);
  }

  EncodeOptions options_;
  Console console_;
  FrameFailures failures_;
  std::unique_ptr<CloudInput> input_;
  std::optional<FrameOutput> output_;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::vector<std::optional<std::size_t>> other_channels_; // of the input's channels
  std::size_t other_messages_ = 0;
  OutputFrame frame_; // a member so that its memory is reused
};

} // namespace

Run
addEncode(CLI::App& app)
{
  const auto options = std::make_shared<EncodeOptions>();
  addInput(app,
           options->input.inputs,
           "PCD, PLY, KITTI .bin files, folders, 'globs' of them; or a bag: "
           "MCAP, rosbag2, ROS 1; -: standard input; one stream per folder");
  addOutput(app,
            options->output,
            "x.pcxi (one stream), x.mcap, a folder (rosbag2), - (.pcxi)");
  addNumber(app,
            "--rate",
            options->input.rate,
            1e-6,
            1e6,
            "HZ",
            "clouds per second, of files; times in names are left out");
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
  options->encoding.addCodecOptions(app);
  options->encoding.addCloudOptions(app);
  options->encoding.addBudget(app);
  addQuiet(app, options->is_quiet);
  return [options, &app] {
    options->input.has_rate = isGiven(app, "--rate");
    return Encode(*options).run();
  };
}

} // namespace tools
} // namespace pcl_ext
