// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/mcap/chunk_cache.h"

#include "recording/mcap/records.h"
#include "recording/span_reader.h"

#include <algorithm>
#include <utility>

namespace pcl_ext {
namespace recording {
namespace mcap {

namespace {

void
findMessages(ChunkCache::Records& records)
{
  SpanReader reader(records.bytes.data(), records.bytes.size());
  while (reader.remaining() > 0) {
    const std::size_t offset = reader.position();
    const auto opcode = static_cast<Opcode>(reader.u8());
    if (reader.take(reader.u64()) != nullptr && opcode == Opcode::Message)
      records.offsets.push_back(offset);
  }
}

} // namespace

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
ChunkCache::records(const InputFile& file, const Section& section, std::size_t number)
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
  records.failure = loadChunk(file, section, records.bytes);
  findMessages(records);
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

} // namespace mcap
} // namespace recording
} // namespace pcl_ext
