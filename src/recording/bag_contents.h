// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/mcap/records.h"
#include "recording/mcap_content.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Largest record that is read, bytes: a cloud in CDR has no more. */
constexpr std::uint64_t max_record_bytes = std::numeric_limits<std::uint32_t>::max();

/** \brief Largest chunk or message that few compressed bytes become, bytes. */
constexpr std::uint64_t max_chunk_bytes = std::uint64_t{1} << 28;

/** \brief Most uncompressed bytes of a chunk, which bound memory and the time to read a
 * file that was made to take long: so many, and so many more for each stored one. A
 * chunk that is not compressed always has fewer, if it is a record that is read. */
inline std::uint64_t
mostChunkBytes(std::uint64_t stored_bytes)
{
  constexpr std::uint64_t plausible_bytes = std::uint64_t{1} << 24;
  constexpr std::uint64_t plausible_ratio = 1000;
  constexpr std::uint64_t usual_ratio = 16; // of clouds at most
  stored_bytes = std::min(stored_bytes, max_record_bytes);
  return std::min(max_record_bytes,
                  std::max(usual_ratio * stored_bytes,
                           std::min(max_chunk_bytes,
                                    plausible_bytes + plausible_ratio * stored_bytes)));
}

/** \brief What is wrong with a record, a chunk or a message that has more bytes. */
inline std::string
largerThan(std::uint64_t most_bytes)
{
  return "it is larger than the limit of " + std::to_string(most_bytes) + " bytes";
}

/** \brief Most messages of a file: so many, and one more for some of its bytes.
 * Compressed empty messages would take far more memory than the file. */
constexpr std::uint64_t
mostMessages(std::uint64_t file_bytes)
{
  constexpr std::uint64_t plausible_messages = std::uint64_t{1} << 20;
  constexpr std::uint64_t plausible_bytes = 8; // of a message: times hardly compress
  return plausible_messages + file_bytes / plausible_bytes;
}

/** \brief Whether the messages of a channel are wanted; others are not indexed. Empty:
 * all are. */
using ChannelFilter = std::function<bool(const McapChannel&)>;

/** \brief A part of a file with messages: a chunk, or the file itself for messages
 * without a chunk. */
struct Section {
  bool is_chunk = true;
  std::uint64_t offset = 0; // of the record of the chunk
  std::uint64_t length =
      0; // of that record with its prefix, as far as it is in the file
  bool is_cut_off = false; // the end of the chunk is missing
};

/** \brief A message of a wanted channel. */
struct IndexedMessage {
  std::uint64_t log_time = 0;
  std::size_t section = 0;  // index in the sections
  std::uint64_t offset = 0; // of the record in the uncompressed chunk, or in the file
  std::uint16_t channel_id = 0;
};

/** \brief All that a reader has to know of a file before it reads messages. */
struct FileContents {
  std::string profile;
  std::map<std::uint16_t, McapChannel> channels;
  std::vector<Section> sections;       // the first one is the file itself
  std::deque<IndexedMessage> messages; // of wanted channels, in the order of the file
  std::vector<mcap::RecordExtent> attachments;
  std::vector<mcap::RecordExtent> metadata;
  std::vector<RecordingDamage> damage;
  bool has_end = false; // the file ends as a complete one does

  /** \brief Adds a place to the damage, unless there are very many. */
  void
  addDamage(RecordingDamage place)
  {
    constexpr std::size_t most = 1000;
    if (damage.size() == most)
      place.message = "from here on damage is not listed";
    if (damage.size() <= most)
      damage.push_back(std::move(place));
  }
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
