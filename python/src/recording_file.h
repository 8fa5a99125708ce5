// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/recording/recording_reader.h>
#include <pcl_ext/recording/recording_writer.h>
#include <pcl_ext/status.h>

#include "decoded_cloud.h"
#include "outlier_filter.h"

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

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
  open(const std::string& path);

  /** \brief Limits of decoding from now on; before the first decode(). */
  void
  setLimits(const io::DecoderLimits& limits);

  /** \brief Closes the file. Every other call then throws std::invalid_argument. */
  void
  close();

  std::vector<recording::RecordedStream>
  streams() const;

  recording::RecordingStatus
  next(recording::RecordedFrame& frame);

  void
  seek(recording::Time time);

  recording::RecordingStatus
  read(std::size_t stream, std::size_t number, recording::RecordedFrame& frame);

  std::optional<std::size_t>
  frameAt(std::size_t stream, recording::Time time) const;

  recording::Time
  timeOf(std::size_t stream, std::size_t number) const;

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
         std::optional<DecodedCloud>& cloud);

  std::vector<recording::RecordingDamage>
  damage() const;

  bool
  isUnfinished() const;

  std::uint64_t
  fileBytes() const;

private:
  recording::RecordingReader&
  reader() const;

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
  open(const std::string& path, bool may_replace);

  recording::RecordingStatus
  addStream(const recording::StreamToRecord& stream, std::size_t& number);

  /** \brief Appends a frame; none of 0 bytes, which is a cloud that max_rate left
   * out. */
  recording::RecordingStatus
  append(std::size_t stream,
         recording::Time time,
         const std::uint8_t* bytes,
         std::size_t size);

  recording::RecordingStatus
  flush();

  /** \brief What was written. */
  struct Written {
    bool is_open = false;
    std::size_t streams = 0;
    std::size_t frames = 0;
  };

  Written
  written() const;

  recording::RecordingStatus
  finish();

  /** \brief Ends without finish(); the file keeps its name of an unfinished one. */
  void
  abandon();

private:
  recording::RecordingWriter&
  writer() const;

  mutable std::mutex mutex_;
  std::unique_ptr<recording::RecordingWriter> writer_;
  recording::ExistingFile existing_ = recording::ExistingFile::Keep;
  Written written_;
};

} // namespace pcl_ext::python
