// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/recording/recording_reader.h>

#include "recording/bag_reader.h"
#include "recording/frame_file.h"
#include "recording/guarded.h"
#include "recording/mcap_frames.h"
#include "recording/point_cloud_messages.h"
#include "recording/rosbag2_folder.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

class RecordingReader::Implementation {
public:
  RecordingStatus
  open(const std::string& path)
  {
    const bool is_folder = isRosbag2Folder(path);
    InputFile file;
    if (!is_folder)
      files_ = {path};
    RecordingStatus status =
        is_folder ? filesOfRosbag2Folder(path, files_) : file.open(path);
    if (!status.ok())
      return status;
    if (!is_folder && !BagReader::isBagFile(file)) {
      auto frames = std::make_unique<FrameFile>();
      status = frames->open(std::move(file));
      setSource(std::move(frames));
      return status;
    }
    BagReader reader;
    status = is_folder ? reader.open(path, isCompressedPointCloud)
                       : reader.open(std::move(file), isCompressedPointCloud);
    if (!status.ok())
      return status;
    auto frames = std::make_unique<McapFrames>();
    status = frames->open(std::move(reader), path);
    setSource(std::move(frames));
    return status;
  }

  /** \brief A frame by its number; null if there is no such frame. */
  const IndexedFrame*
  find(std::size_t stream, std::size_t number) const
  {
    if (stream >= by_stream_.size() || number >= by_stream_[stream].size())
      return nullptr;
    return &source_->frames()[by_stream_[stream][number]];
  }

  RecordingStatus
  read(const IndexedFrame& indexed, RecordedFrame& frame)
  {
    frame.stream = indexed.stream;
    frame.number = indexed.number;
    frame.time = indexed.time;
    RecordingStatus status = source_->read(indexed, frame);
    frame.description = status.ok() ? io::describeFrame(frame.bytes.data(),
                                                        frame.bytes.size(),
                                                        limitsOfReading())
                                    : io::FrameDescription();
    if (!status.ok())
      frame.description.status = {io::CompressionCode::InputFailed, status.message()};
    return status;
  }

  void
  setSource(std::unique_ptr<FrameSource> source)
  {
    source_ = std::move(source);
    for (const RecordedStream& stream : source_->streams()) {
      by_stream_.emplace_back();
      by_stream_.back().reserve(stream.frames);
    }
    for (std::size_t i = 0; i < source_->frames().size(); ++i)
      by_stream_[source_->frames()[i].stream].push_back(i);
  }

  std::unique_ptr<FrameSource> source_{new FrameFile};
  std::vector<std::vector<std::size_t>> by_stream_; // indices in the frames
  std::size_t next_ = 0;                            // index in the frames
  std::vector<std::string> files_;
  io::DecodingMemory decoding_memory_; // of all decoders of its streams
};

RecordingReader::RecordingReader() : implementation_(new Implementation) {}
RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader&
RecordingReader::operator=(RecordingReader&&) noexcept = default;

RecordingStatus
RecordingReader::open(const std::string& path)
{
  return guarded([&] {
    implementation_ = std::make_unique<Implementation>();
    return implementation_->open(path);
  });
}

const std::vector<RecordedStream>&
RecordingReader::streams() const
{
  return implementation_->source_->streams();
}

RecordingStatus
RecordingReader::next(RecordedFrame& frame)
{
  const std::vector<IndexedFrame>& frames = implementation_->source_->frames();
  if (implementation_->next_ >= frames.size())
    return {RecordingCode::EndOfRecording, "the recording has no more frames"};
  const IndexedFrame& indexed = frames[implementation_->next_++];
  return guarded([&] { return implementation_->read(indexed, frame); });
}

void
RecordingReader::seek(Time time)
{
  const std::vector<IndexedFrame>& frames = implementation_->source_->frames();
  const auto found =
      std::find_if(frames.begin(), frames.end(), [time](const IndexedFrame& indexed) {
        return indexed.time >= time;
      });
  implementation_->next_ = static_cast<std::size_t>(found - frames.begin());
}

RecordingStatus
RecordingReader::read(std::size_t stream, std::size_t number, RecordedFrame& frame)
{
  const IndexedFrame* const indexed = implementation_->find(stream, number);
  if (indexed == nullptr)
    return {RecordingCode::InvalidArgument,
            "the recording has no frame " + std::to_string(number) + " of stream " +
                std::to_string(stream)};
  return guarded([&] { return implementation_->read(*indexed, frame); });
}

std::optional<std::size_t>
RecordingReader::frameAt(std::size_t stream, Time time) const
{
  std::optional<std::size_t> last;
  if (stream >= implementation_->by_stream_.size())
    return last;
  for (const std::size_t index : implementation_->by_stream_[stream]) {
    const IndexedFrame& indexed = implementation_->source_->frames()[index];
    if (indexed.time <= time)
      last = indexed.number;
  }
  return last;
}

Time
RecordingReader::timeOf(std::size_t stream, std::size_t number) const
{
  const IndexedFrame* const indexed = implementation_->find(stream, number);
  return indexed == nullptr ? Time(0) : indexed->time;
}

std::size_t
RecordingReader::iFrameBefore(std::size_t stream, std::size_t number)
{
  RecordedFrame frame;
  const std::size_t frames =
      stream < streams().size() ? streams()[stream].frames : std::size_t{0};
  number = std::min(number, std::max<std::size_t>(frames, 1) - 1);
  for (; number > 0; --number)
    if (read(stream, number, frame).ok() && frame.description.status.ok() &&
        frame.description.is_i_frame)
      break;
  return number;
}

const std::vector<RecordingDamage>&
RecordingReader::damage() const
{
  return implementation_->source_->damage();
}

bool
RecordingReader::isUnfinished() const
{
  return implementation_->source_->isUnfinished();
}

std::uint64_t
RecordingReader::fileBytes() const
{
  return implementation_->source_->fileBytes();
}

const std::vector<std::string>&
RecordingReader::files() const
{
  return implementation_->files_;
}

class RecordedStreamDecoder::Implementation {
public:
  Implementation(RecordingReader& reader,
                 std::size_t stream,
                 const io::DecoderLimits& limits)
  : reader_(reader), stream_(stream), limits_(limits), decoder_(limits)
  {}

  void
  setDecodesVoxels(bool decodes_voxels)
  {
    decodes_voxels_ = decodes_voxels;
    decoder_.setDecodesVoxels(decodes_voxels);
  }

  io::CompressionStatus
  decode(std::size_t number, io::VoxelFrame& voxels)
  {
    voxels.clearVoxels();
    const std::vector<RecordedStream>& streams = reader_.streams();
    if (stream_ >= streams.size() || number >= streams[stream_].frames)
      return {io::CompressionCode::InputFailed,
              "the recording has no frame " + std::to_string(number) + " of stream " +
                  std::to_string(stream_)};
    std::size_t first = number;
    if (number != next_) {
      first = reader_.iFrameBefore(stream_, number);
      // If the last frame lies between the two, its history serves, too.
      if (next_ > first && next_ <= number)
        first = next_;
      else
        restartDecoder();
    }
    return decodeFrom(first, number, voxels, false);
  }

  io::CompressionStatus
  decode(const RecordedFrame& frame, io::VoxelFrame& voxels)
  {
    const bool has_reference = is_last_decoded_ && frame.number == next_;
    io::CompressionStatus status = decodeNext(frame, voxels);
    // The frame before it was decoded, and then dropped to keep the memory limit.
    if (status.code() != io::CompressionCode::MissingReference || !has_reference)
      return status;
    const std::size_t number = frame.number; // of frame_, perhaps
    restartDecoder();
    return decodeFrom(reader_.iFrameBefore(stream_, number), number, voxels, true);
  }

  const io::CodedFrameStatistics&
  statistics() const
  {
    return decoder_.statistics();
  }

private:
  void
  restartDecoder()
  {
    decoder_ = io::FrameDecoder(limits_);
    decoder_.setDecodesVoxels(decodes_voxels_);
  }

  /** \brief Decodes frames of the recording, and keeps the last one.
   * \param[in] is_again they were decoded before
   */
  io::CompressionStatus
  decodeFrom(std::size_t first,
             std::size_t number,
             io::VoxelFrame& voxels,
             bool is_again)
  {
    io::CompressionStatus status;
    for (std::size_t i = first; i <= number; ++i) {
      voxels.clearVoxels();
      const RecordingStatus read = reader_.read(stream_, i, frame_);
      frame_.number = i;
      if (read.ok())
        status = is_again ? decodeNext(frame_, voxels) : decode(frame_, voxels);
      else
        status = {io::CompressionCode::InputFailed, read.message()};
    }
    next_ = number + 1;
    return status;
  }

  /** \brief Decodes a frame after the last one. */
  io::CompressionStatus
  decodeNext(const RecordedFrame& frame, io::VoxelFrame& voxels)
  {
    const auto decode_bytes = [&] {
      return decoder_.decode(frame.bytes.data(),
                             frame.bytes.size(),
                             voxels,
                             reader_.implementation_->decoding_memory_);
    };
    io::CompressionStatus status = decode_bytes();
    // Frames arrive in order here: this is a stream that was recorded again, as of a bag
    // that was played in a loop, and an I-frame decodes whatever was before it.
    if (status.code() == io::CompressionCode::OldFrame &&
        frame.description.status.ok() && frame.description.is_i_frame) {
      restartDecoder();
      status = decode_bytes();
    }
    next_ = frame.number + 1;
    is_last_decoded_ = status.ok();
    return status;
  }

  RecordingReader& reader_;
  std::size_t stream_;
  io::DecoderLimits limits_;
  io::FrameDecoder decoder_;
  bool decodes_voxels_ = true;
  std::size_t next_ = 0;         // number of the frame that follows the last one
  bool is_last_decoded_ = false; // the last one, by decoder_
  RecordedFrame frame_;
};

RecordedStreamDecoder::RecordedStreamDecoder(RecordingReader& reader,
                                             std::size_t stream,
                                             const io::DecoderLimits& limits)
: implementation_(new Implementation(reader, stream, limits))
{}
RecordedStreamDecoder::~RecordedStreamDecoder() = default;
RecordedStreamDecoder::RecordedStreamDecoder(RecordedStreamDecoder&&) noexcept =
    default;
RecordedStreamDecoder&
RecordedStreamDecoder::operator=(RecordedStreamDecoder&&) noexcept = default;

void
RecordedStreamDecoder::setDecodesVoxels(bool decodes_voxels)
{
  implementation_->setDecodesVoxels(decodes_voxels);
}

io::CompressionStatus
RecordedStreamDecoder::decode(std::size_t number, io::VoxelFrame& voxels)
{
  return implementation_->decode(number, voxels);
}

io::CompressionStatus
RecordedStreamDecoder::decode(const RecordedFrame& frame, io::VoxelFrame& voxels)
{
  return implementation_->decode(frame, voxels);
}

const io::CodedFrameStatistics&
RecordedStreamDecoder::statistics() const
{
  return implementation_->statistics();
}

} // namespace pcl_ext::PCL_EXT_ABI::recording
