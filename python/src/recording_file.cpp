// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording_file.h"

#include "recording/output_paths.h"
#include "voxels/point_voxels.h"

#include <new>
#include <stdexcept>
#include <utility>

namespace pcl_ext::python {

using recording::RecordingStatus;

RecordingStatus
RecordingFile::open(const std::string& path)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  reader_ = std::make_unique<recording::RecordingReader>();
  return reader_->open(path);
}

void
RecordingFile::setLimits(const io::DecoderLimits& limits)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  limits_ = limits;
}

void
RecordingFile::close()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  decoders_.clear();
  reader_.reset();
}

recording::RecordingReader&
RecordingFile::reader() const
{
  if (!reader_)
    throw std::invalid_argument("the recording is closed");
  return *reader_;
}

std::vector<recording::RecordedStream>
RecordingFile::streams() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().streams();
}

RecordingStatus
RecordingFile::next(recording::RecordedFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().next(frame);
}

void
RecordingFile::seek(recording::Time time)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  reader().seek(time);
}

RecordingStatus
RecordingFile::read(std::size_t stream,
                    std::size_t number,
                    recording::RecordedFrame& frame)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().read(stream, number, frame);
}

std::optional<std::size_t>
RecordingFile::frameAt(std::size_t stream, recording::Time time) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().frameAt(stream, time);
}

recording::Time
RecordingFile::timeOf(std::size_t stream, std::size_t number) const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().timeOf(stream, number);
}

io::CompressionStatus
RecordingFile::decode(std::size_t stream,
                      std::size_t number,
                      const Denoising& denoising,
                      std::optional<DecodedCloud>& cloud)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  cloud.reset();
  auto decoder = decoders_.find(stream);
  if (decoder == decoders_.end()) {
    decoder = decoders_
                  .emplace(stream,
                           recording::RecordedStreamDecoder(reader(), stream, limits_))
                  .first;
    decoder->second.setDecodesVoxels(false);
  }
  io::CompressionStatus status = decoder->second.decode(number, frame_);
  if (!status.ok())
    return status;
  try {
    denoising.apply(frame_, reader().timeOf(stream, number));
    cloud.emplace(frame_);
    status = io::statusOfVoxels(frame_); // which filters make
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<io::CompressionStatus>();
  }
  return status;
}

std::vector<recording::RecordingDamage>
RecordingFile::damage() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().damage();
}

bool
RecordingFile::isUnfinished() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().isUnfinished();
}

std::uint64_t
RecordingFile::fileBytes() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return reader().fileBytes();
}

RecordingStatus
RecordingOutput::open(const std::string& path, bool may_replace)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  recording::OutputKind kind{};
  if (RecordingStatus status = recording::checkOutput(path, kind); !status.ok())
    return status;
  if (!may_replace)
    if (RecordingStatus status = recording::refuseTakenFile(path, "overwrite=True");
        !status.ok())
      return status;
  existing_ =
      may_replace ? recording::ExistingFile::Replace : recording::ExistingFile::Keep;
  writer_ = std::make_unique<recording::RecordingWriter>();
  return writer_->open(path);
}

recording::RecordingWriter&
RecordingOutput::writer() const
{
  if (!writer_)
    throw std::invalid_argument("the recording is finished");
  return *writer_;
}

RecordingStatus
RecordingOutput::addStream(const recording::StreamToRecord& stream, std::size_t& number)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  RecordingStatus status = writer().addStream(stream, number);
  written_.streams += status.ok() ? 1 : 0;
  return status;
}

RecordingStatus
RecordingOutput::append(std::size_t stream,
                        recording::Time time,
                        const std::uint8_t* bytes,
                        std::size_t size)
{
  const std::lock_guard<std::mutex> lock(mutex_);
  recording::RecordingWriter& to = writer();
  if (size == 0)
    return {};
  RecordingStatus status = to.append(stream, time, bytes, size);
  written_.frames += status.ok() ? 1 : 0;
  return status;
}

RecordingOutput::Written
RecordingOutput::written() const
{
  const std::lock_guard<std::mutex> lock(mutex_);
  Written written = written_;
  written.is_open = writer_ != nullptr;
  return written;
}

RecordingStatus
RecordingOutput::flush()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  return writer().flush();
}

RecordingStatus
RecordingOutput::finish()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!writer_)
    return {};
  RecordingStatus status = writer_->finish(existing_);
  if (status.ok()) // else the next call fails, too
    writer_.reset();
  return status;
}

void
RecordingOutput::abandon()
{
  const std::lock_guard<std::mutex> lock(mutex_);
  if (writer_)
    static_cast<void>(writer_->flush()); // nobody is there to be told of a failure
  writer_.reset();
}

} // namespace pcl_ext::python
