// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/rans/byte_table.h"

#include <algorithm>
#include <cstring>
#include <memory>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

void
ByteTable::set(const Weights& weights)
{
  constexpr std::uint64_t shared = probability_one - symbol_count;
  std::uint64_t below = 0;
  std::uint32_t start = 0;
  for (unsigned int i = 0; i < symbol_count; ++i) {
    below += weights[i];
    const std::uint32_t end =
        i + 1 == symbol_count
            ? probability_one
            : i + 1 + static_cast<std::uint32_t>(below * shared >> 32);
    ranges_[i] = start | (end - start) << 16;
    // Slots written beyond `end` are overwritten by the next symbol.
    for (std::uint32_t slot = start; slot < end; slot += fill_size)
      std::memset(&symbols_[slot], static_cast<int>(i), fill_size);
    start = end;
  }
}

namespace {

struct OccupancyTables {
  std::array<ByteTable, 43> tables;

  static unsigned int
  index(unsigned int probability)
  {
    // The probabilities are 1..7, 10, 14, .., 118, 120..127.
    return probability < 8     ? probability - 1
           : probability < 120 ? probability / 4 + 5
                               : probability - 85;
  }

  OccupancyTables()
  {
    for (unsigned int fine = 1; fine < 128; ++fine) {
      const std::uint64_t probability = tableProbability(fine << 9);
      if (probability != fine)
        continue;
      ByteTable::Weights weights;
      for (unsigned int byte = 0; byte < weights.size(); ++byte) {
        std::uint64_t weight = 1;
        for (unsigned int bit = 0; bit < 8; ++bit)
          weight *= (byte >> bit & 1) != 0 ? probability : 128 - probability;
        weights[byte] = static_cast<std::uint32_t>(weight >> 24);
      }
      tables[index(fine)].set(weights);
    }
  }
};

} // namespace

const ByteTable&
occupancyTable(unsigned int probability)
{
  static const std::unique_ptr<const OccupancyTables> tables(new OccupancyTables);
  return tables->tables[OccupancyTables::index(tableProbability(probability))];
}

} // namespace rans
} // namespace pcl_ext::PCL_EXT_ABI::io
