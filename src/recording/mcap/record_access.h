// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_contents.h"
#include "recording/files.h"
#include "recording/mcap/records.h"
#include "recording/span_reader.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief Reads bytes at a section; false unless all of them were read. */
using ReadAt =
    std::function<bool(std::uint64_t offset, std::size_t count, std::uint8_t* bytes)>;

/** \brief Loads the records of a chunk, as far as they can be read.
 * \param[in] read the file
 * \param[in] section a chunk
 * \param[out] records uncompressed; its memory is reused; empty if the checksum is
 * wrong
 * \return empty, or what is wrong
 */
std::string
loadChunk(const ReadAt& read,
          const Section& section,
          std::vector<std::uint8_t>& records);
std::string
loadChunk(const InputFile& file,
          const Section& section,
          std::vector<std::uint8_t>& records);

/** \brief A record in bytes that it does not own. */
struct Record {
  Opcode opcode{};
  const std::uint8_t* content = nullptr;
  std::size_t size = 0; ///< of the content
};

/** \brief Takes the next record.
 * \return false if there is none, or it is cut off, so that the reader has failed
 */
bool
takeRecord(SpanReader& reader, Record& record);

/** \brief True if the magic bytes of MCAP are at an offset. */
bool
hasMagic(const InputFile& file, std::uint64_t offset);

/** \brief True if the file ends as a complete file does. */
bool
hasMcapEnd(const InputFile& file);

/** \brief Counts what follows the magic bytes that end a file, where another file or
 * anything else was appended to it. */
class BytesAfterEnd {
public:
  /** \brief Takes the next bytes after the data. */
  void
  add(const std::uint8_t* bytes, std::size_t count);

  /** \brief The damage, if there are any. */
  std::string
  describe() const;

  /** \brief Number of bytes; 0 also without an end. */
  std::uint64_t
  count() const
  {
    return count_;
  }

private:
  std::size_t matched_ = 0; // of the magic bytes
  std::uint64_t count_ = 0;
};

/** \brief Reads the opcode and the length of a record.
 * \return false if there are none
 */
bool
readRecordPrefix(const InputFile& file,
                 std::uint64_t offset,
                 Opcode& opcode,
                 std::uint64_t& content_length);

/** \brief Reads the content of a record of a file.
 * \return false if it cannot be read
 */
bool
readRecord(const InputFile& file,
           std::uint64_t offset,
           Opcode opcode,
           std::vector<std::uint8_t>& content);

/** \brief Reads the content of a message.
 * \param[out] message its channel is not set; memory is reused
 * \return false if it is too short
 */
bool
readMessage(const std::uint8_t* content,
            std::size_t size,
            McapMessage& message,
            std::uint16_t& channel_id);

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
