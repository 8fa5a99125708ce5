// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_contents.h"
#include "recording/mcap/chunk_compression.h"
#include "recording/mcap/records.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording::mcap {

/** \brief A chunk to which messages are added until it is written. */
class ChunkBuilder {
public:
  /** \brief Adds a message. */
  void
  add(const MessagePrefix& prefix, const std::vector<std::uint8_t>& message)
  {
    start_time_ =
        indexes_.empty() ? prefix.log_time : std::min(start_time_, prefix.log_time);
    end_time_ =
        indexes_.empty() ? prefix.log_time : std::max(end_time_, prefix.log_time);
    MessageIndex& index = indexes_[prefix.channel_id];
    index.channel_id = prefix.channel_id;
    index.entries.emplace_back(prefix.log_time, records_.size());
    append(prefix, message, records_);
  }

  /** \brief Bytes of the records so far. */
  std::size_t
  size() const
  {
    return records_.size();
  }

  /** \brief Takes the chunk and its message indexes, and begins another one.
   * \param[in] is_compressed compress the records, if that saves bytes
   * \param[in] offset of the chunk in the file
   * \param[out] bytes fields of the chunk, its records and its message indexes are
   * appended
   * \return the index of the chunk
   */
  ChunkIndex
  take(bool is_compressed, std::uint64_t offset, std::vector<std::uint8_t>& bytes)
  {
    const bool has_compressed = is_compressed && compress(records_, compressed_) &&
                                records_.size() <= mostChunkBytes(compressed_.size());
    const std::vector<std::uint8_t>& records = has_compressed ? compressed_ : records_;
    ChunkIndex index;
    Chunk chunk;
    index.start_time = chunk.start_time = start_time_;
    index.end_time = chunk.end_time = end_time_;
    index.uncompressed_size = chunk.uncompressed_size = records_.size();
    index.compression = chunk.compression =
        has_compressed ? zstd_compression : no_compression;
    index.compressed_size = chunk.records_size = records.size();
    chunk.uncompressed_checksum = checksumOf(records_.data(), records_.size());
    const std::size_t begin = bytes.size();
    appendChunkFields(chunk, bytes);
    bytes.insert(bytes.end(), records.begin(), records.end());
    index.chunk_offset = offset;
    index.chunk_length = bytes.size() - begin;
    const std::size_t indexes_begin = bytes.size();
    for (const auto& [channel_id, message_index] : indexes_) {
      index.message_index_offsets[channel_id] = offset + (bytes.size() - begin);
      append(message_index, bytes);
    }
    index.message_index_length = bytes.size() - indexes_begin;
    records_.clear();
    indexes_.clear();
    return index;
  }

private:
  std::vector<std::uint8_t> records_;
  std::vector<std::uint8_t> compressed_;
  std::map<std::uint16_t, MessageIndex> indexes_; // by channel
  std::uint64_t start_time_ = 0;
  std::uint64_t end_time_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
