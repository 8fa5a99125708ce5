// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/chunk_cache.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace recording {

bool
ChunkCache::Records::hasMessageAt(std::uint64_t offset) const
{
  return std::binary_search(offsets.begin(), offsets.end(), offset);
}

std::size_t
ChunkCache::CachedChunk::cost() const
{
  constexpr std::size_t least_cost = std::size_t{1} << 16;
  return std::max(least_cost,
                  records.bytes.size() +
                      records.offsets.size() * sizeof(records.offsets.front()));
}

const ChunkCache::Records&
ChunkCache::records(std::size_t number, const std::function<void(Records&)>& load)
{
  const auto found =
      std::find_if(chunks_.begin(), chunks_.end(), [number](const CachedChunk& chunk) {
        return chunk.number == number;
      });
  if (found != chunks_.end()) {
    chunks_.splice(chunks_.begin(), chunks_, found);
    return chunks_.front().records;
  }
  Records records;
  load(records);
  // Decompression leaves room after the bytes.
  records.bytes.shrink_to_fit();
  chunks_.push_front({number, std::move(records)});
  bytes_ += chunks_.front().cost();
  while (bytes_ > max_bytes && chunks_.size() > 1) {
    bytes_ -= chunks_.back().cost();
    chunks_.pop_back();
  }
  return chunks_.front().records;
}

} // namespace recording
} // namespace pcl_ext
