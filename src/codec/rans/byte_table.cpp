// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/rans/byte_table.h"

#include <array>
#include <cstdint>
#include <memory>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace rans {

namespace {

/** \brief Slots of the values of a byte, each at least one.
 * \param[in] weights their sum is 2^32 or a little less
 */
ByteTable::Widths
widthsOf(const std::array<std::uint32_t, ByteTable::symbol_count>& weights)
{
  constexpr std::uint64_t shared = probability_one - ByteTable::symbol_count;
  ByteTable::Widths widths;
  std::uint64_t below = 0;
  std::uint32_t start = 0;
  for (std::uint32_t i = 0; i < widths.size(); ++i) {
    below += weights[i];
    const std::uint32_t end =
        i + 1 == widths.size()
            ? probability_one
            : i + 1 + static_cast<std::uint32_t>(below * shared >> 32);
    widths[i] = static_cast<std::uint16_t>(end - start);
    start = end;
  }
  return widths;
}

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
      std::array<std::uint32_t, ByteTable::symbol_count> weights;
      for (unsigned int byte = 0; byte < weights.size(); ++byte) {
        std::uint64_t weight = 1;
        for (unsigned int bit = 0; bit < 8; ++bit)
          weight *= (byte >> bit & 1) != 0 ? probability : 128 - probability;
        weights[byte] = static_cast<std::uint32_t>(weight >> 24);
      }
      tables[index(fine)].set(widthsOf(weights));
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
