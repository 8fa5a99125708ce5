// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "commands/bag_encoding.h"

#include "commands/encode_remarks.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/point_cloud_conversions.h"
#include "measuring/markdown_table.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::tools {

using recording::McapMessage;
using Outcome = CloudInWork::Outcome;

struct BagEncoding::Stream {
  Stream(const EncodingOptions& options,
         const std::string& name,
         Crew& crew,
         CloudInput& input)
  : encoded(options, name, crew, input)
  {}

  EncodedStream encoded;
  std::optional<std::size_t> output;
  EncodedSums sums; // of what was written
  std::size_t failures = 0;
  bool is_refused = false;       // its clouds are left out
  recording::Time first_time{0}; // of the frames
  recording::Time last_time{0};
};

BagEncoding::BagEncoding(const EncodeOptions& options,
                         Console& console,
                         Crew& crew,
                         unsigned int jobs)
: options_(options)
, console_(console)
, crew_(crew)
, jobs_(jobs)
// One job encodes a cloud before the next one is read.
, most_clouds_(crew.size() == 1 ? 0 : std::size_t{3} * jobs)
, failures_([this](const std::string& line) { console_.error(line); })
{}

BagEncoding::~BagEncoding() = default;

int
BagEncoding::run()
{
  const std::string& path = options_.output.path;
  checkOutput(path);
  const OutputKind kind = kindOfOutput(path);
  options_.encoding.checkFrameId(kind != OutputKind::Frames);
  InputOptions input = options_.input;
  input.may_have_streams = kind != OutputKind::Frames;
  input_ = openInput(input);
  refuseTakenFile(input.inputs, path, options_.output.may_replace);
  for (const std::string& remark : input_->remarks())
    console_.remark(remark);
  if (!input_->isLive()) // else there may be more
    options_.encoding.checkStreams(input_->streams());
  checkNumberOfStreams();
  shareTopics();
  // Not only of bags: the messages tell how many points the clouds had.
  output_.emplace(options_.output, true, input_->profile());
  addStreams();
  // Who writes a pipe may wait for what becomes of it.
  input_->setBeforeWaiting([this] {
    writeUntil(0, 0);
    output_->flush();
  });
  encodeAll();
  return finish();
}

/** \brief True for channels whose messages are not encoded. */
bool
BagEncoding::passesThrough(const recording::McapChannel& channel) const
{
  const std::vector<std::string>& names = input_->streams();
  const bool is_cloud = recording::isPointCloud(channel) ||
                        channel.schema.name == "sensor_msgs/PointCloud2"; // of ROS 1
  return !is_cloud ||
         std::find(names.begin(), names.end(), channel.topic) == names.end();
}

void
BagEncoding::checkNumberOfStreams() const
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

/** \brief With more jobs than topics several parts of a topic are encoded at once, whose
 * clouds are read when they are needed. */
void
BagEncoding::shareTopics()
{
  const std::size_t topics = input_->streams().size();
  if (jobs_ <= topics || input_->isLive())
    return;
  const std::size_t in_part = EncodedStream::cloudsInPart(options_.encoding);
  const std::string remark =
      "--jobs " + std::to_string(jobs_) + " is more than there are streams: ";
  if (in_part == 0)
    console_.remark(remark +
                    "with --max-rate, --max-encode-ms, --temporal-filter, "
                    "--remove-outliers or --format published one job encodes each");
  else if (!input_->leaveUnread())
    console_.remark(remark +
                    "parts of one are encoded side by side only if it is in an "
                    "MCAP file that is complete");
  else {
    other_reader_ = input_->placeReader();
    most_clouds_ = ((jobs_ + topics - 1) / topics + 1) * topics * in_part;
  }
}

/** \brief Adds the streams and channels of the input that there were not before. */
void
BagEncoding::addStreams()
{
  const std::vector<std::string>& names = input_->streams();
  const std::vector<recording::McapChannel>& channels = input_->channels();
  if (streams_.size() == names.size() && other_channels_.size() == channels.size())
    return;
  // What is done then depends on what was written.
  writeUntil(0, 0);
  while (streams_.size() < names.size()) {
    const std::size_t number = streams_.size();
    streams_.push_back(
        std::make_unique<Stream>(options_.encoding, names[number], crew_, *input_));
    if (number > 0)
      tryOn(number, [this] { checkNumberOfStreams(); });
  }
  while (other_channels_.size() < channels.size()) {
    const recording::McapChannel& channel = channels[other_channels_.size()];
    const bool passes = passesThrough(channel) && output_->isBag();
    const bool is_taken = passes && stream_topics_.count(channel.topic) != 0;
    if (is_taken) {
      console_.error(channel.topic +
                     ": its messages are left out, as frames were written under that "
                     "name before it was met: encode a file instead of a pipe");
      is_incomplete_ = true;
    }
    other_channels_.push_back(passes && !is_taken
                                  ? std::optional(output_->addChannel(
                                        channel, recording::McapChunking::Shared))
                                  : std::nullopt);
  }
}

/** \brief The topic that frames of a stream of a bag get: none that another one has, as
 * of a publisher that compressed the same clouds while they were recorded. */
std::string
BagEncoding::topicOfFrames(const std::string& name)
{
  const auto isTaken = [this](const std::string& topic) {
    const auto& channels = input_->channels();
    return stream_topics_.count(topic) != 0 ||
           (output_->isBag() &&
            std::any_of(channels.begin(), channels.end(), [&](const auto& channel) {
              return channel.topic == topic && passesThrough(channel);
            }));
  };
  std::string topic = name;
  while (isTaken(topic + compressed_suffix))
    topic += "/encoded";
  if (topic != name)
    console_.remark(name + ": its frames are under " + topic + compressed_suffix +
                    ", as " + name + compressed_suffix +
                    " is another topic of the bag");
  stream_topics_.insert(topic + compressed_suffix);
  return topic + compressed_suffix;
}

/** \brief Does a step on a stream. If the command line is not one for it, the other
 * streams go on.
 * \throws UsageError if that is noticed before the first frame; nothing is written
 * then
 */
template <typename StepT>
void
BagEncoding::tryOn(std::size_t number, const StepT& step)
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
    const bool has_frames = streams_[number]->output.has_value();
    console_.error(input_->streams()[number] +
                   (has_frames ? ": its clouds are left out from here on: "
                               : ": its clouds are left out: ") +
                   error.what());
    streams_[number]->is_refused = true;
  }
}

void
BagEncoding::encodeAll()
{
  constexpr std::size_t most_bytes = std::size_t{64} << 20;
  McapMessage message;
  console_.startProgress(input_->isBag() ? "messages" : "clouds", input_->size());
  while (!isInterrupted()) {
    std::shared_ptr<CloudInWork> cloud = unusedCloud();
    if (input_->size() == 1)
      console_.status("reading a cloud");
    const CloudInput::Found found = input_->next(cloud->cloud, message);
    if (found == CloudInput::Found::End)
      break;
    addStreams();
    if (found == CloudInput::Found::Cloud)
      take(cloud);
    else if (found == CloudInput::Found::Extra) {
      writeUntil(0, 0);
      input_->copyExtra(*output_);
    }
    else {
      bytes_in_flight_ += message.bytes.size();
      in_flight_.push_back(
          {nullptr,
           std::move(message),
           cloud->cloud.is_unread ? std::optional(cloud->cloud.place) : std::nullopt});
      message = McapMessage();
    }
    writeUntil(most_clouds_, most_bytes);
    console_.advance();
  }
  writeUntil(0, 0);
  for (const auto& stream : streams_)
    queue(stream->encoded.addWaiting());
  writeUntil(0, 0);
  console_.endProgress();
}

void
BagEncoding::take(const std::shared_ptr<CloudInWork>& cloud)
{
  has_clouds_ = true;
  Stream& stream = *streams_[cloud->cloud.stream];
  const pcl::PCLPointCloud2& points = cloud->cloud.cloud;
  if (input_->size() == 1 && !cloud->cloud.is_unread)
    console_.status("encoding " +
                    counted(std::size_t{points.width} * points.height, "point"));
  if (stream.is_refused)
    ++stream.failures;
  else
    queue(stream.encoded.add(cloud));
}

std::shared_ptr<CloudInWork>
BagEncoding::unusedCloud()
{
  if (unused_.empty())
    return std::make_shared<CloudInWork>();
  std::shared_ptr<CloudInWork> cloud = std::move(unused_.back());
  unused_.pop_back();
  return cloud;
}

void
BagEncoding::queue(const std::vector<std::shared_ptr<CloudInWork>>& clouds)
{
  for (const auto& cloud : clouds)
    in_flight_.push_back({cloud, {}, {}});
  clouds_in_flight_ += clouds.size();
}

/** \brief Writes what is done, in the order of the input, and waits until not more than
 * so many clouds and bytes of other messages are left. */
void
BagEncoding::writeUntil(std::size_t most_clouds, std::size_t most_bytes)
{
  while (!in_flight_.empty()) {
    InFlight& first = in_flight_.front();
    if (!first.cloud) {
      bytes_in_flight_ -= first.message.bytes.size();
      // What cannot be read is damage of the input.
      if (!is_cut_ &&
          (!first.place || other_reader_->read(*first.place, first.message)))
        passThrough(first.message);
    }
    else {
      const auto isDone = [&cloud = *first.cloud] { return cloud.is_done.load(); };
      if (clouds_in_flight_ > most_clouds || bytes_in_flight_ > most_bytes)
        crew_.workUntil(isDone);
      if (!isDone())
        return;
      --clouds_in_flight_;
      write(*first.cloud);
      first.cloud->is_done = false;
      if (first.cloud.use_count() == 1)
        unused_.push_back(std::move(first.cloud));
    }
    in_flight_.pop_front();
  }
}

/** \brief Writes the frame of a cloud, or tells why there is none. */
void
BagEncoding::write(CloudInWork& cloud)
{
  const std::size_t number = cloud.cloud.stream;
  Stream& stream = *streams_[number];
  if (cloud.fault)
    std::rethrow_exception(cloud.fault);
  // Frames after it would leave a gap.
  is_cut_ |= cloud.outcome == Outcome::Unread;
  if (is_cut_)
    return;
  if (stream.is_refused || cloud.outcome == Outcome::Refused) {
    if (!stream.is_refused)
      tryOn(number, [&cloud] { throw UsageError(cloud.reason); });
    ++stream.failures;
  }
  else if (cloud.outcome == Outcome::Failed) {
    failures_.add(input_->streams()[number], cloud.cloud.number, "", cloud.reason);
    ++stream.failures;
  }
  else {
    if (cloud.outcome == Outcome::Frame)
      writeFrame(stream, cloud);
    stream.sums += cloud.sums;
  }
}

void
BagEncoding::writeFrame(Stream& stream, CloudInWork& cloud)
{
  const recording::Time time = cloud.frame.message.log_time;
  if (!stream.output) {
    stream.output = addStream(cloud.cloud.stream);
    stream.first_time = time;
  }
  stream.last_time = time;
  output_->write(*stream.output, cloud.frame);
}

std::size_t
BagEncoding::addStream(std::size_t number)
{
  const std::string& name = input_->streams()[number];
  recording::StreamToRecord added;
  added.name = input_->isBag() ? topicOfFrames(name) : name;
  added.frame_id = in_flight_.front().cloud->frame.cloud.frame_id;
  const EncodedStream& encoded = streams_[number]->encoded;
  added.metadata =
      options_.encoding.metadataOf(name, encoded.law(), encoded.isOfLidar());
  addViewpoints(console_,
                options_.encoding,
                name,
                input_->viewpointsOf(number),
                output_->isBag(),
                added.metadata);
  for (const recording::McapChannel& channel : input_->channels())
    if (channel.topic == name)
      addOtherMetadata(channel.metadata, added.metadata);
  return output_->addStream(added);
}

void
BagEncoding::passThrough(McapMessage& message)
{
  if (!output_->isBag())
    ++left_out_;
  if (!output_->isBag() || !other_channels_[message.channel])
    return;
  message.channel = *other_channels_[message.channel];
  output_->write(message);
  ++summary_.other_messages;
}

/** \brief Sets the summary, and prints what is to be known of the streams. */
void
BagEncoding::sumUp()
{
  for (std::size_t number = 0; number < streams_.size(); ++number) {
    Stream& stream = *streams_[number];
    const std::string& name = input_->streams()[number];
    const EncodedStreamReport& of_stream = stream.encoded.finish();
    summary_.failures += stream.failures;
    summary_.sums += stream.sums;
    is_incomplete_ |= !remarkOnStream(console_, name, of_stream);
    if (options_.encoding.codec().max_rate > 0.0 && input_->assumesTimes(number))
      console_.remark(name + ": nothing tells the times of its clouds: " +
                      measuring::formatted(options_.input.rate, 1) +
                      " Hz are assumed for --max-rate; --rate sets it");
    if (!stream.is_refused)
      summary_.streams.push_back(
          {name, stream.sums.frames, stream.sums.bytes, stream.failures});
  }
  summary_.bytes_a_second = bytesASecond();
}

std::string
BagEncoding::whyNoFrames() const
{
  if (summary_.sums.clouds_left_out > 0)
    return "--max-rate has no room for any cloud";
  if (has_clouds_ || !input_->isBag() || isInterrupted() || !input_->damage().empty())
    return "no cloud could be encoded";
  std::string topics;
  for (const std::string& topic : input_->streams())
    topics += (topics.empty() ? "" : ", ") + topic;
  return "no cloud could be encoded: there are no messages of " + topics;
}

int
BagEncoding::finish()
{
  failures_.finish();
  for (const std::string& remark : input_->remarksOnClouds())
    console_.remark(remark);
  sumUp();
  if (const std::string left_out =
          output_->describeLeftOut(options_.input.topics.empty() ? left_out_ : 0);
      !left_out.empty())
    console_.remark(left_out);
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
  if (summary_.sums.frames == 0) {
    output_->discard();
    throw std::runtime_error(whyNoFrames() + "; '" + options_.output.path +
                             "' was not written");
  }
  if (input_->bag() != nullptr && output_->isBag())
    output_->copyExtras(*input_->bag());
  const std::string interruption = output_->finish();
  if (!options_.is_json)
    console_.summary(
        describeBag(options_.output.path, summary_, options_.encoding, interruption));
  if (isInterrupted())
    return interrupted;
  return summary_.failures > 0 || is_incomplete_ || has_wrong_option || !damage.empty()
             ? something_failed
             : all_done;
}

/** \brief Bytes that all streams take in a second of their clouds; 0: unknown. */
double
BagEncoding::bytesASecond() const
{
  double rate = 0.0;
  for (const auto& stream : streams_) {
    const double seconds =
        std::chrono::duration<double>(stream->last_time - stream->first_time).count();
    const auto frames = static_cast<double>(stream->sums.frames);
    // The last frame is as long as the others.
    if (stream->sums.frames > 1 && seconds > 0.0)
      rate +=
          static_cast<double>(stream->sums.bytes) / seconds * (frames - 1.0) / frames;
  }
  return rate;
}

} // namespace pcl_ext::tools
