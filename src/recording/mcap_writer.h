// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief How the messages of a channel are put into chunks. */
enum class McapChunking {
  Shared,   ///< compressed chunks that all channels of this kind share
  OwnStream ///< uncompressed chunks of this channel alone, which begin where asked for
};

/** \brief Writes MCAP files with all indexes, statistics and checksums.
 *
 * The file is written beside its final name, with ".unfinished" added, and renamed by
 * finish(). What was written until a failure or a crash stays there and can be read.
 * After a failure all calls return that failure.
 */
class PCL_EXT_RECORDING_EXPORT McapWriter {
public:
  /** \brief A chunk of this size ends with the next message, bytes; those of OwnStream
   * with the next message that may begin a chunk. */
  static constexpr std::size_t shared_chunk_bytes = std::size_t{1} << 20;
  static constexpr std::size_t own_chunk_bytes = std::size_t{1} << 16;

  /** \brief A chunk of OwnStream of this size ends with any message, bytes. */
  static constexpr std::size_t max_own_chunk_bytes = std::size_t{1} << 22;

  McapWriter();

  /** \brief Writes the messages at hand to an unfinished file; removes it if it has
   * none. */
  ~McapWriter();
  McapWriter(McapWriter&&) noexcept;
  McapWriter&
  operator=(McapWriter&&) noexcept;

  /** \brief Begins a file.
   * \param[in] path file, which is replaced if it exists; a path that ends in / or has
   * no extension is a rosbag2 folder, which must not exist; - is the standard output
   * \param[in] profile such as "ros2"
   */
  RecordingStatus
  open(const std::string& path, const std::string& profile);

  /** \brief Adds a channel.
   * \param[in] channel at most 65535 of them
   * \param[in] chunking where its messages go
   * \param[out] number for write()
   */
  RecordingStatus
  addChannel(const McapChannel& channel, McapChunking chunking, std::size_t& number);

  /** \brief Writes a message.
   * \param[in] message its channel is a number of addChannel()
   * \param[in] may_begin_chunk OwnStream: whether a chunk may begin with it
   */
  RecordingStatus
  write(const McapMessage& message, bool may_begin_chunk = true);

  RecordingStatus
  write(const McapMetadata& metadata);

  RecordingStatus
  write(const McapAttachment& attachment);

  /** \brief Writes all messages at hand to the file. */
  RecordingStatus
  flush();

  /** \brief Bytes of the file so far, with messages that are at hand. */
  std::uint64_t
  bytes() const;

  /** \brief Completes the file and gives it its name.
   * \param[in] existing what becomes of a file of that name
   */
  RecordingStatus
  finish(ExistingFile existing = ExistingFile::Replace);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
