// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/compression/frame_description.h>
#include <pcl_ext/recording/recording_writer.h>

#include "recording/files.h"
#include "recording/frame_source.h"
#include "recording/guarded.h"
#include "recording/mcap_writer.h"
#include "recording/output_paths.h"
#include "recording/point_cloud_messages.h"
#include "stream/frame_chain.h"

#include <filesystem>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

namespace fs = std::filesystem;

constexpr std::uint8_t float32_datatype = 7;

struct WrittenStream {
  std::string name;
  PointCloudMessage message; // with the layout of the decoded clouds
  io::ImageSize size;        // of organised clouds
  std::size_t channel = 0;
  std::uint32_t frames = 0;
  io::FrameChain chain; // of the recorded frames
  bool has_gap = false; // the last frame was not recorded
};

void
setFields(bool has_intensities, bool has_colours, PointCloudMessage& message)
{
  message.fields.clear();
  message.point_step = 0;
  const auto add = [&](const char* name) {
    message.fields.push_back({name, message.point_step, float32_datatype, 1});
    message.point_step += sizeof(float);
  };
  for (const char* coordinate : {"x", "y", "z"})
    add(coordinate);
  if (has_intensities)
    add("intensity");
  if (has_colours)
    add("rgb");
}

} // namespace

class RecordingWriter::Implementation {
public:
  ~Implementation()
  {
    std::error_code ignored;
    if (has_file_of_frames_ && !is_finished_ && file_.position() == 0 &&
        path_ != standard_stream) {
      file_ = OutputFile(); // Windows removes no open file
      fs::remove(path_ + unfinished_suffix, ignored);
    }
  }

  RecordingStatus
  open(const std::string& path)
  {
    path_ = path;
    OutputKind kind{};
    status_ = checkOutput(path, kind);
    has_file_of_frames_ = status_.ok() && kind == OutputKind::Frames;
    if (!status_.ok())
      return status_;
    if (!has_file_of_frames_)
      status_ = mcap_.open(path, "ros2");
    else if (path == standard_stream)
      status_ = file_.open(path);
    else {
      const std::string unfinished = path + unfinished_suffix;
      status_ = setAsideUnfinished(unfinished, unfinished);
      if (status_.ok())
        status_ = file_.open(unfinished);
    }
    is_finished_ = !status_.ok();
    return status_;
  }

  RecordingStatus
  addStream(const StreamToRecord& stream, std::size_t& number)
  {
    if (!status_.ok())
      return status_;
    if (stream.name.empty())
      return {RecordingCode::InvalidArgument, "a stream needs a name"};
    if (has_file_of_frames_ && !streams_.empty())
      return {RecordingCode::InvalidArgument,
              "a .pcxi file has one stream; several need .mcap"};
    if (names_.count(stream.name) != 0)
      return {RecordingCode::InvalidArgument,
              "there are two streams of the name '" + stream.name + "'"};
    WrittenStream written;
    written.name = stream.name;
    written.message.frame_id = stream.frame_id;
    setFields(true, false, written.message);
    if (!has_file_of_frames_) {
      McapChannel channel = compressedPointCloudChannel(stream.name);
      channel.metadata = stream.metadata;
      RecordingStatus status =
          mcap_.addChannel(channel, McapChunking::OwnStream, written.channel);
      if (!status.ok())
        return status;
    }
    names_.insert(stream.name);
    number = streams_.size();
    streams_.push_back(std::move(written));
    return {};
  }

  RecordingStatus
  append(std::size_t stream, Time time, const std::uint8_t* bytes, std::size_t size)
  {
    if (!status_.ok())
      return status_;
    if (stream >= streams_.size())
      return {RecordingCode::InvalidArgument, "a frame of an unknown stream"};
    WrittenStream& written = streams_[stream];
    const bool has_gap =
        std::exchange(written.has_gap, true); // also if this one throws
    const RecordingStatus status = appendFrame(written, has_gap, time, bytes, size);
    written.has_gap = !status.ok();
    return status;
  }

  RecordingStatus
  flush()
  {
    return has_file_of_frames_ ? status_ : mcap_.flush();
  }

  std::uint64_t
  bytes() const
  {
    return has_file_of_frames_ ? file_.position() : mcap_.bytes();
  }

  RecordingStatus
  finish(ExistingFile existing)
  {
    if (!status_.ok())
      return status_;
    RecordingStatus status;
    if (!has_file_of_frames_)
      status = mcap_.finish(existing);
    else {
      status = file_.close();
      if (status.ok() && path_ != standard_stream)
        status = renameFile(path_ + unfinished_suffix, path_, existing);
    }
    is_finished_ = true;
    status_ = status.ok() ? RecordingStatus{RecordingCode::OutputFailed,
                                            "the recording is finished"}
                          : status;
    return status;
  }

private:
  RecordingStatus
  appendFrame(WrittenStream& stream,
              bool has_gap,
              Time time,
              const std::uint8_t* bytes,
              std::size_t size)
  {
    if (time.count() < 0)
      return {RecordingCode::InvalidArgument, "a frame of a negative time"};
    const io::FrameSize frame_size = io::frameSize(bytes, size, limitsOfReading());
    const io::FrameDescription frame =
        io::describeFrame(bytes, size, limitsOfReading());
    if (!frame_size.status.ok() || frame_size.known != size || !frame.status.ok())
      return {RecordingCode::InvalidArgument,
              "the bytes are not one frame: " +
                  (frame_size.status.ok()
                       ? "it has " + std::to_string(frame_size.known) + " bytes, not " +
                             std::to_string(size)
                       : frame_size.status.message())};
    if (has_gap &&
        stream.chain.placeOf(frame, bytes, size) != io::FrameChain::Place::Next)
      return {RecordingCode::InvalidArgument,
              "a frame that needs one before it that was not recorded"};
    RecordingStatus status;
    if (has_file_of_frames_)
      status = status_ = file_.write(bytes, size);
    else
      status = appendMessage(stream, time, frame, bytes, size);
    if (!status.ok())
      return status;
    ++stream.frames;
    stream.chain.follow(frame, bytes, size);
    return status;
  }

  RecordingStatus
  appendMessage(WrittenStream& stream,
                Time time,
                const io::FrameDescription& frame,
                const std::uint8_t* bytes,
                std::size_t size)
  {
    PointCloudMessage& message = stream.message;
    if (frame.is_i_frame) {
      setFields(frame.intensity_scale.bits > 0 ||
                    frame.format == io::StreamFormat::Published,
                frame.colour_bits > 0,
                message);
      stream.size = frame.is_organised ? frame.scan : io::ImageSize();
    }
    if (frame.frame_id && !frame.frame_id->empty())
      message.frame_id = *frame.frame_id;
    message.stamp = time;
    const bool is_organised = stream.size.width > 0;
    message.width =
        is_organised ? stream.size.width : static_cast<std::uint32_t>(frame.points);
    message.height = is_organised ? stream.size.height : 1;
    message.is_dense = !is_organised; // with missing points
    message.row_step = message.point_step * message.width;
    message.bytes.assign(bytes, bytes + size);
    mcap_message_.channel = stream.channel;
    mcap_message_.sequence = stream.frames;
    mcap_message_.log_time = mcap_message_.publish_time = time;
    writePointCloud(message, true, mcap_message_.bytes);
    return mcap_.write(mcap_message_, frame.is_i_frame);
  }

  bool has_file_of_frames_ = false;
  bool is_finished_ = true;
  std::string path_;
  OutputFile file_; // of frames
  RecordingStatus status_{RecordingCode::OutputFailed, "no recording is open"};
  McapWriter mcap_;
  McapMessage mcap_message_;
  std::vector<WrittenStream> streams_;
  std::set<std::string> names_; // of the streams
};

RecordingWriter::RecordingWriter() : implementation_(new Implementation) {}
RecordingWriter::~RecordingWriter() = default;
RecordingWriter::RecordingWriter(RecordingWriter&&) noexcept = default;
RecordingWriter&
RecordingWriter::operator=(RecordingWriter&&) noexcept = default;

RecordingStatus
RecordingWriter::open(const std::string& path)
{
  return guarded([&] {
    implementation_ = std::make_unique<Implementation>();
    return implementation_->open(path);
  });
}

RecordingStatus
RecordingWriter::addStream(const StreamToRecord& stream, std::size_t& number)
{
  return guarded([&] { return implementation_->addStream(stream, number); });
}

RecordingStatus
RecordingWriter::append(std::size_t stream,
                        Time time,
                        const std::uint8_t* bytes,
                        std::size_t size)
{
  return guarded([&] { return implementation_->append(stream, time, bytes, size); });
}

RecordingStatus
RecordingWriter::flush()
{
  return guarded([&] { return implementation_->flush(); });
}

std::uint64_t
RecordingWriter::bytes() const
{
  return implementation_->bytes();
}

RecordingStatus
RecordingWriter::finish(ExistingFile existing)
{
  return guarded([&] { return implementation_->finish(existing); });
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
