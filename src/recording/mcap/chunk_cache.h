#pragma once

#include "recording/files.h"
#include "recording/mcap/file_contents.h"

#include <cstddef>
#include <cstdint>
#include <list>
#include <string>
#include <vector>

namespace pcl_ext {
namespace recording {
namespace mcap {

/** \brief Keeps the last chunks that were read, as frames of several streams are read in
 * turn, each from a chunk of its own. */
class ChunkCache {
public:
  /** \brief Most bytes to keep, apart from the last chunk. */
  static constexpr std::size_t max_bytes = std::size_t{1} << 26;

  /** \brief The records of a chunk.
   * \param[in] file,place where the chunk is
   * \param[in] number of the chunk in the cache
   * \param[out] failure empty, or what is wrong
   * \return the uncompressed records, valid until the next call
   */
  const std::vector<std::uint8_t>&
  records(const InputFile& file,
          const Place& place,
          std::size_t number,
          std::string& failure);

private:
  struct CachedChunk {
    std::size_t number;
    std::string failure;
    std::vector<std::uint8_t> records;
  };

  std::list<CachedChunk> chunks_; // the last one used first
  std::size_t bytes_ = 0;         // of all of them
};

} // namespace mcap
} // namespace recording
} // namespace pcl_ext
