// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include "recording/mcap/channel_list.h"
#include "recording/mcap/records.h"
#include "recording/mcap_content.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Reads an MCAP file from its beginning to its end, while it is written: from a
 * pipe. Messages come in the order of the file; neither indexes nor a summary are
 * needed.
 *
 * It is exported for the program pcl_ext. Any bytes are safe; memory is that of one
 * record, at most max_record_bytes, its chunk, see mostChunkBytes(), and of the channels.
 */
class PCL_EXT_RECORDING_EXPORT McapStream {
public:
  /** \brief Reads up to a number of bytes, and waits for the first; 0 at the end. */
  using ReadSome = std::function<std::size_t(std::uint8_t* bytes, std::size_t count)>;

  /** \brief What next() found. */
  enum class Found { Message, Metadata, Attachment, End };

  /** \param[in] read the file, from after its first 8 bytes, which tell its kind
   * \param[in] name of the input, for damage()
   */
  McapStream(ReadSome read, std::string name);
  McapStream(const McapStream&) = delete;
  McapStream&
  operator=(const McapStream&) = delete;

  /** \brief Reads up to the next content, which has then been read. */
  Found
  next();

  /** \brief Profile of the file; after the first next(). */
  const std::string&
  profile() const
  {
    return profile_;
  }

  /** \brief All channels until now. */
  const std::vector<McapChannel>&
  channels() const
  {
    return channels_;
  }

  /** \brief What next() found last. */
  McapMessage&
  message()
  {
    return message_;
  }

  const McapMetadata&
  metadata() const
  {
    return metadata_;
  }

  const McapAttachment&
  attachment() const
  {
    return attachment_;
  }

  /** \brief What could not be read until now. */
  const std::vector<RecordingDamage>&
  damage() const
  {
    return damage_;
  }

private:
  bool
  readRecord();

  std::uint64_t
  readBytes(std::uint64_t count, bool is_kept);

  bool
  takeNextOfChunk();

  bool
  takeMessage(const std::uint8_t* content, std::size_t size);

  void
  readAfterData();

  void
  addChannel(const std::uint8_t* content, std::size_t size);

  void
  unpackChunk();

  bool
  takeRecord(Found& found);

  void
  addDamage(const std::string& message)
  {
    constexpr std::size_t most = 1000;
    if (damage_.size() < most)
      damage_.push_back({offset_, message, name_});
  }

  ReadSome read_;
  std::string name_;
  const ChannelFilter wants_; // all
  mcap::ChannelList list_;
  std::map<std::uint16_t, std::size_t> numbers_; // of channels, by id
  std::vector<std::uint8_t> record_;             // with its prefix
  std::uint64_t offset_ = mcap::magic.size();    // of the record
  std::uint64_t position_ = mcap::magic.size();  // in the file
  bool is_at_end_ = false;
  std::string profile_;
  std::vector<McapChannel> channels_;
  McapMessage message_;
  McapMetadata metadata_;
  McapAttachment attachment_;
  std::vector<RecordingDamage> damage_;
  std::vector<std::uint8_t> chunk_; // its records, uncompressed
  std::size_t next_in_chunk_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
