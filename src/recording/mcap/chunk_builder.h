// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/mcap/records.h"

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
  add(const MessagePrefix& prefix, const std::vector<std::uint8_t>& message);

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
  take(bool is_compressed, std::uint64_t offset, std::vector<std::uint8_t>& bytes);

private:
  std::vector<std::uint8_t> records_;
  std::vector<std::uint8_t> compressed_;
  std::map<std::uint16_t, MessageIndex> indexes_; // by channel
  std::uint64_t start_time_ = 0;
  std::uint64_t end_time_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::mcap
