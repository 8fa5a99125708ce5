// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/bag_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::recording::sqlite {

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
class BagDatabase : public BagFile {
public:
  explicit BagDatabase(InputFile&& file);
  ~BagDatabase() override;

  /** \brief NotARecording also if the program was built without SQLite. */
  RecordingStatus
  findContents(const ChannelFilter& wants, FileContents& contents) override;

  std::string
  read(const MessagePlace& place,
       McapMessage& message,
       std::uint16_t& channel_id) override;

  bool
  hasRows() const override
  {
    return true;
  }

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::sqlite
