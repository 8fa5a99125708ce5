#include "recording/mcap/chunk_cache.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace recording {
namespace mcap {

const std::vector<std::uint8_t>&
ChunkCache::records(const InputFile& file,
                    const Place& place,
                    std::size_t number,
                    std::string& failure)
{
  const auto found =
      std::find_if(chunks_.begin(), chunks_.end(), [number](const CachedChunk& chunk) {
        return chunk.number == number;
      });
  if (found != chunks_.end()) {
    chunks_.splice(chunks_.begin(), chunks_, found);
    failure = chunks_.front().failure;
    return chunks_.front().records;
  }
  std::vector<std::uint8_t> records;
  failure = loadChunk(file, place, records);
  bytes_ += records.size();
  chunks_.push_front({number, failure, std::move(records)});
  while (bytes_ > max_bytes && chunks_.size() > 1) {
    bytes_ -= chunks_.back().records.size();
    chunks_.pop_back();
  }
  return chunks_.front().records;
}

} // namespace mcap
} // namespace recording
} // namespace pcl_ext
