// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <string>
#include <vector>

namespace pcl_ext {
namespace recording {

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

  /** \brief Loads a chunk unless it is here.
   * \param[in] number of the chunk in the cache
   * \param[in] load reads a chunk
   * \return valid until the next call
   */
  const Records&
  records(std::size_t number, const std::function<void(Records&)>& load);

private:
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
};

} // namespace recording
} // namespace pcl_ext
