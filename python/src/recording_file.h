// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>
#include <pcl_ext/status.h>

#include "decoded_cloud.h"
#include "outlier_filter.h"
#include "recording/output_paths.h"
#include "voxels/point_voxels.h"

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>

namespace pcl_ext::python {

/** \brief A RecordingReader and the decoders of its streams.
 *
 * Any thread may call it, and not with the GIL held, as a call may wait for another
 * thread.
 */
class RecordingFile {
public:
  /** \brief Opens a recording; see RecordingReader::open. */
  recording::RecordingStatus
  open(const std::string& path)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    reader_ = std::make_unique<recording::RecordingReader>();
    return reader_->open(path);
  }

  /** \brief Limits of decoding from now on; before the first decode(). */
  void
  setLimits(const io::DecoderLimits& limits)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    limits_ = limits;
  }

  /** \brief Closes the file. Every other call then throws std::invalid_argument. */
  void
  close()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    decoders_.clear();
    reader_.reset();
  }

  /** \brief Returns what a function returns that is called with the reader. */
  template <typename FunctionT>
  auto
  withReader(const FunctionT& function) const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return function(reader());
  }

  /** \brief Decodes a frame.
   * \param[in] stream below the number of streams
   * \param[in] number of the frame in its stream
   * \param[in] denoising what to remove
   * \param[out] cloud the points; none unless the status is Ok
   */
  io::CompressionStatus
  decode(std::size_t stream,
         std::size_t number,
         const Denoising& denoising,
         std::optional<DecodedCloud>& cloud)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    cloud.reset();
    auto decoder = decoders_.find(stream);
    if (decoder == decoders_.end()) {
      decoder =
          decoders_
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

private:
  recording::RecordingReader&
  reader() const
  {
    if (!reader_)
      throw std::invalid_argument("the recording is closed");
    return *reader_;
  }

  mutable std::mutex mutex_;
  io::DecoderLimits limits_;
  std::unique_ptr<recording::RecordingReader> reader_;
  std::map<std::size_t, recording::RecordedStreamDecoder> decoders_; // by stream
  io::VoxelFrame frame_; // member so that its memory is reused
};

/** \brief A RecordingWriter that any thread may use; not to be called with the GIL
 * held. */
class RecordingOutput {
public:
  /** \brief Begins a recording.
   * \param[in] may_replace a file of this name is replaced, else refused
   */
  recording::RecordingStatus
  open(const std::string& path, bool may_replace)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    recording::OutputKind kind{};
    if (recording::RecordingStatus status = recording::checkOutput(path, kind);
        !status.ok())
      return status;
    if (!may_replace)
      if (recording::RecordingStatus status =
              recording::refuseTakenFile(path, "overwrite=True");
          !status.ok())
        return status;
    existing_ =
        may_replace ? recording::ExistingFile::Replace : recording::ExistingFile::Keep;
    writer_ = std::make_unique<recording::RecordingWriter>();
    return writer_->open(path);
  }

  recording::RecordingStatus
  addStream(const recording::StreamToRecord& stream, std::size_t& number)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    recording::RecordingStatus status = writer().addStream(stream, number);
    written_.streams += status.ok() ? 1 : 0;
    return status;
  }

  /** \brief Appends a frame; none of 0 bytes, which is a cloud that max_rate left
   * out. */
  recording::RecordingStatus
  append(std::size_t stream,
         recording::Time time,
         const std::uint8_t* bytes,
         std::size_t size)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    recording::RecordingWriter& to = writer();
    if (size == 0 && stream < written_.streams)
      return {};
    recording::RecordingStatus status = to.append(stream, time, bytes, size);
    written_.frames += status.ok() ? 1 : 0;
    return status;
  }

  recording::RecordingStatus
  flush()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return writer().flush();
  }

  struct Written {
    bool is_open = false;
    std::size_t streams = 0;
    std::size_t frames = 0;
  };

  Written
  written() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Written written = written_;
    written.is_open = writer_ != nullptr;
    return written;
  }

  recording::RecordingStatus
  finish()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!writer_)
      return {};
    recording::RecordingStatus status = writer_->finish(existing_);
    if (status.ok()) // else the next call fails, too
      writer_.reset();
    return status;
  }

  /** \brief Ends without finish(); the file keeps its name of an unfinished one. */
  void
  abandon()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (writer_)
      static_cast<void>(writer_->flush()); // nobody is there to be told of a failure
    writer_.reset();
  }

private:
  recording::RecordingWriter&
  writer() const
  {
    if (!writer_)
      throw std::invalid_argument("the recording is finished");
    return *writer_;
  }

  mutable std::mutex mutex_;
  std::unique_ptr<recording::RecordingWriter> writer_;
  recording::ExistingFile existing_ = recording::ExistingFile::Keep;
  Written written_;
};

} // namespace pcl_ext::python
