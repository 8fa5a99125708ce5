// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/files.h"
#include "recording/mcap/file_contents.h"
#include "recording/mcap_content.h"
#include "recording/mcap_reader.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace pcl_ext {
namespace recording {
namespace sqlite {

constexpr char magic[] = "SQLite format 3"; // and the 0 after it

/** \brief True if a file begins as databases of SQLite do. */
inline bool
isDatabase(const InputFile& file)
{
  std::array<std::uint8_t, sizeof(magic)> beginning{};
  return file.read(0, beginning.size(), beginning.data()) &&
         std::equal(beginning.begin(), beginning.end(), magic);
}

/** \brief A file of rosbag2's storage sqlite3, which is the default before Iron. It has
 * the tables topics and messages, and since Iron message_definitions.
 *
 * Nothing is written. Any bytes are safe: messages are indexed by ascending rows, so that
 * pages that form a ring have an end, and the size of a message is checked before memory
 * is taken for it.
 */
class BagDatabase {
public:
  BagDatabase();
  ~BagDatabase();

  /** \brief Finds topics and messages.
   * \param[in] file must exist, at the same place, as long as this
   * \param[in] wants channels whose messages are wanted; empty: all
   * \param[out] contents one section; the offsets of its messages are rows
   * \return NotARecording if it is no bag, or the program was built without SQLite
   */
  RecordingStatus
  open(const InputFile& file,
       const McapReader::ChannelFilter& wants,
       mcap::FileContents& contents);

  /** \brief Reads a message.
   * \param[in] row offset of an indexed message
   * \param[out] message its channel is not set; memory is reused
   * \param[out] channel_id of the contents
   * \return empty, or what is wrong
   */
  std::string
  read(std::uint64_t row, McapMessage& message, std::uint16_t& channel_id);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace sqlite
} // namespace recording
} // namespace pcl_ext
