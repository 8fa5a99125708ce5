// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/files.h"
#include "recording/mcap/record_access.h"
#include "recording/mcap/records.h"
#include "recording/mcap_content.h"
#include "recording/mcap_reader.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace pcl_ext {
namespace recording {
namespace mcap {

/** \brief A message of a wanted channel. */
struct IndexedMessage {
  std::uint64_t log_time = 0;
  std::size_t section = 0;  // index in the sections
  std::uint64_t offset = 0; // of the record in the uncompressed chunk, or in the file
  std::uint16_t channel_id = 0;
};

/** \brief All that a reader has to know of an MCAP file before it reads messages. */
struct FileContents {
  std::string profile;
  std::map<std::uint16_t, McapChannel> channels;
  std::vector<Section> sections;       // the first one is the file itself
  std::deque<IndexedMessage> messages; // of wanted channels, in the order of the file
  std::vector<RecordExtent> attachments;
  std::vector<RecordExtent> metadata;
  std::vector<RecordingDamage> damage;
  bool has_end = false; // the file ends as a complete one does
};

/** \brief True if a file has the magic bytes of MCAP at its beginning or, if these are
 * damaged, at its end. */
bool
isMcapFile(const InputFile& file);

/** \brief Finds the contents of a file: by its summary, and if that is missing or does
 * not tell of all messages, by reading all of the file.
 * \param[in] file the file
 * \param[in] wants channels whose messages are wanted; empty: all
 * \param[out] contents also of a damaged file
 * \return NotARecording if it is no MCAP file
 */
RecordingStatus
findContents(const InputFile& file,
             const McapReader::ChannelFilter& wants,
             FileContents& contents);

} // namespace mcap
} // namespace recording
} // namespace pcl_ext
