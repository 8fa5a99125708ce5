// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/frame_output.h"

#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/recording/recording_reader.h>

#include "console/interruption.h"
#include "console/throw_unless_ok.h"
#include "options/text_values.h"

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <utility>

namespace pcl_ext::tools {

namespace fs = std::filesystem;

using recording::McapChunking;
using recording::RecordingStatus;

namespace {

std::string
unfinishedPath(const std::string& path)
{
  return (fs::path(path).has_filename() ? fs::path(path) : fs::path(path).parent_path())
             .string() +
         unfinished_suffix;
}

} // namespace

std::string
describeUnfinished(const std::string& path)
{
  const std::string unfinished = unfinishedPath(path);
  std::error_code ignored;
  return fs::exists(unfinished, ignored)
             ? "; what was written until then is in '" + unfinished + "'"
             : "";
}

bool
keepsEarlierOutput(const std::string& path)
{
  std::error_code ignored;
  return isInterrupted() && path != "-" && fs::exists(path, ignored) &&
         !(fs::is_directory(path, ignored) && fs::is_empty(path, ignored));
}

std::string
describeInterruption(const std::string& path, bool keeps_earlier)
{
  if (!isInterrupted())
    return {};
  return keeps_earlier ? "; interrupted: '" + path + "' is still the earlier one" +
                             describeUnfinished(path)
                       : "; interrupted, and complete up to there";
}

/** \brief \throws std::runtime_error after a failure, with what is left of the
 * output */
void
FrameOutput::check(const RecordingStatus& status)
{
  if (status.ok())
    return;
  // They remove their files if these hold nothing.
  recording_ = recording::RecordingWriter();
  bag_ = recording::McapWriter();
  throw std::runtime_error(status.message() + describeUnfinished(path_));
}

std::string
FrameOutput::describeLeftOut(std::size_t messages) const
{
  std::string left_out;
  if (messages > 0)
    left_out = counted(messages, "message") + " of other topics";
  if (has_other_times_)
    left_out += std::string(left_out.empty() ? "" : ", and ") +
                "the log times, which are not the stamps of the clouds";
  return left_out.empty() ? left_out
                          : "left out: " + left_out +
                                ", as a file of frames has one stream and stamps; "
                                "x.mcap has all";
}

FrameOutput::FrameOutput(const Output& output, bool is_bag, const std::string& profile)
: path_(output.path)
, existing_(output.existing())
, is_of_bag_(is_bag)
, is_bag_(is_bag && kindOfOutput(path_) != OutputKind::Frames)
{
  throwUnlessOk(is_bag_ ? bag_.open(path_, profile == "ros1" ? "" : profile)
                        : recording_.open(path_));
}

std::size_t
FrameOutput::addStream(const recording::StreamToRecord& stream)
{
  std::size_t number = 0;
  if (is_bag_) {
    recording::McapChannel channel =
        recording::compressedPointCloudChannel(stream.name);
    channel.metadata = stream.metadata;
    number = addChannel(channel, McapChunking::OwnStream);
  }
  else
    check(recording_.addStream(stream, number));
  return number;
}

std::size_t
FrameOutput::addChannel(const recording::McapChannel& channel, McapChunking chunking)
{
  std::size_t number = 0;
  check(bag_.addChannel(channel, chunking, number));
  return number;
}

void
FrameOutput::write(std::size_t stream, OutputFrame& frame)
{
  if (!is_bag_) {
    using std::chrono::floor;
    using std::chrono::microseconds; // which frames count
    has_other_times_ |= is_of_bag_ && floor<microseconds>(frame.message.log_time) !=
                                          floor<microseconds>(frame.cloud.stamp);
    check(recording_.append(
        stream, frame.message.log_time, frame.bytes.data(), frame.bytes.size()));
    return;
  }
  const bool is_i_frame = io::describeFrame(frame.bytes.data(),
                                            frame.bytes.size(),
                                            io::DecoderLimits::none())
                              .is_i_frame;
  frame.message.channel = stream;
  std::swap(frame.cloud.bytes, frame.bytes);
  recording::writePointCloud(frame.cloud, true, frame.message.bytes);
  copy(frame.message, is_i_frame);
}

void
FrameOutput::copy(const recording::McapMessage& message, bool is_i_frame)
{
  check(bag_.write(message, is_i_frame));
}

void
FrameOutput::write(const recording::McapMessage& message)
{
  check(bag_.write(message));
}

void
FrameOutput::write(const recording::McapMetadata& metadata)
{
  if (is_bag_)
    check(bag_.write(metadata));
}

void
FrameOutput::write(const recording::McapAttachment& attachment)
{
  if (is_bag_)
    check(bag_.write(attachment));
}

void
FrameOutput::flush()
{
  check(is_bag_ ? bag_.flush() : recording_.flush());
}

void
FrameOutput::discard()
{
  recording_ = recording::RecordingWriter();
  bag_ = recording::McapWriter();
  std::error_code ignored;
  if (path_ != "-")
    fs::remove_all(unfinishedPath(path_), ignored);
}

void
FrameOutput::copyExtras(recording::BagReader& bag)
{
  if (!is_bag_)
    return;
  std::vector<recording::McapMetadata> metadata;
  throwUnlessOk(bag.readMetadata(metadata));
  for (const recording::McapMetadata& record : metadata)
    throwUnlessOk(bag_.write(record));
  throwUnlessOk(
      bag.readAttachments([this](const recording::McapAttachment& attachment) {
        return bag_.write(attachment);
      }));
}

std::string
FrameOutput::finish()
{
  const bool keeps_earlier = keepsEarlierOutput(path_);
  if (keeps_earlier) {
    // They write what they have.
    recording_ = recording::RecordingWriter();
    bag_ = recording::McapWriter();
  }
  else
    check(is_bag_ ? bag_.finish(existing_) : recording_.finish(existing_));
  return describeInterruption(path_, keeps_earlier);
}

} // namespace pcl_ext::tools
