// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/chunk_cache.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

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

std::string
ChunkCache::findMessage(const MessagePlace& place,
                        const std::function<void(Records&)>& load,
                        SpanReader& record)
{
  const Records& chunk = records(place.section_number, load);
  // What could be read of a chunk that was cut off is valid.
  if (!chunk.failure.empty() && !place.section.is_cut_off)
    return "a chunk: " + chunk.failure;
  if (!chunk.hasMessageAt(place.offset))
    return not_indexed;
  const auto offset = static_cast<std::size_t>(place.offset);
  record = SpanReader(chunk.bytes.data() + offset, chunk.bytes.size() - offset);
  return {};
}

/** \brief Loads a chunk unless it is here. */
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
  if (bytes_left_ == 0) {
    refused_.failure = "its messages and those of others come in turn, too often for a "
                       "file of this size; they are lost";
    return refused_;
  }
  Records records;
  load(records);
  // Of a damaged chunk there may be no bytes, though it took time.
  constexpr std::uint64_t least_bytes = std::uint64_t{1} << 20;
  bytes_left_ -=
      std::min(bytes_left_, std::max<std::uint64_t>(least_bytes, records.bytes.size()));
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

} // namespace pcl_ext::PCL_EXT_ABI::recording
