// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/files.h"
#include "recording/mcap/records.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace recording {
namespace mcap {

/** \brief A part of a file with messages: a chunk, or the file itself for messages
 * without a chunk. */
struct Section {
  bool is_chunk = true;
  std::uint64_t offset = 0; // of the record of the chunk
  std::uint64_t length =
      0; // of that record with its prefix, as far as it is in the file
  bool is_cut_off = false; // the end of the chunk is missing
};

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

/** \brief True if the magic bytes of MCAP are at an offset. */
bool
hasMagic(const InputFile& file, std::uint64_t offset);

/** \brief True if the file ends as a complete file does. */
bool
hasMcapEnd(const InputFile& file);

/** \brief Reads the opcode and the length of a record.
 * \return false if there are none
 */
bool
readRecordPrefix(const InputFile& file,
                 std::uint64_t offset,
                 Opcode& opcode,
                 std::uint64_t& content_length);

/** \brief Reads the content of a record of a file.
 * \param[in] max_length larger records are not read
 * \return false if it cannot be read
 */
bool
readRecord(const InputFile& file,
           std::uint64_t offset,
           Opcode opcode,
           std::uint64_t max_length,
           std::vector<std::uint8_t>& content);

} // namespace mcap
} // namespace recording
} // namespace pcl_ext
