// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_file.h"
#include "recording/span_reader.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief Keeps the last chunks that were read, as frames of several streams are read
 * in turn, each from a chunk of its own. */
class ChunkCache {
public:
  /** \brief Most bytes to keep, apart from the last chunk. */
  static constexpr std::size_t max_bytes = std::size_t{1} << 26;

  /** \brief The records of a chunk, and where they begin. */
  struct Records {
    std::vector<std::uint8_t> bytes;
    std::vector<std::uint64_t> offsets; // of the messages, ascending
    std::string failure;                // empty, or what is wrong with the chunk

    /** \brief True if a message begins at an offset. Within another message there may
     * be bytes that look like one. */
    bool
    hasMessageAt(std::uint64_t offset) const;
  };

  /** \brief Allows for the chunks of a file. Chunks that are loaded again and again, as
   * their messages come in turn, take time: 1 GiB may be loaded in a pass through the
   * messages, and 1000 times the bytes of all files. */
  void
  allowFile(std::uint64_t bytes)
  {
    bytes_of_pass_ += 1000 * bytes;
    beginPass();
  }

  /** \brief Begins another pass, as where a reader goes back. */
  void
  beginPass()
  {
    bytes_left_ = bytes_of_pass_;
  }

  /** \brief Finds the record of a message in its chunk.
   * \param[in] place of the message
   * \param[in] load reads the chunk, unless it is here
   * \param[out] record begins with it; valid until the next call
   * \return empty, or what is wrong
   */
  std::string
  findMessage(const MessagePlace& place,
              const std::function<void(Records&)>& load,
              SpanReader& record);

private:
  const Records&
  records(std::size_t number, const std::function<void(Records&)>& load);

  struct CachedChunk {
    std::size_t number;
    Records records;

    /** \brief Bytes that count; small chunks count more, so that they are not too many
     * to search. */
    std::size_t
    cost() const;
  };

  std::list<CachedChunk> chunks_; // the last one used first
  std::size_t bytes_ = 0;         // of all of them
  std::uint64_t bytes_of_pass_ = std::uint64_t{1} << 30;
  std::uint64_t bytes_left_ = bytes_of_pass_; // that may be loaded
  Records refused_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording
