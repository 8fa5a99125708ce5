#include "codec/fast/byte_table.h"

#include <algorithm>
#include <cstring>
#include <memory>

namespace pcl_ext {
namespace io {
namespace fast {

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

QuadModel::QuadModel() { setTable(); }

void
QuadModel::adapt()
{
  std::uint32_t below = 0;
  for (unsigned int i = 1; i < number_count; ++i) {
    below += static_cast<std::uint16_t>(counts_ >> (16 * (i - 1)));
    const std::uint32_t goal = below << (14 - period_log2_);
    starts_[i] = (starts_[i] + goal) / 2;
  }
  counts_ = 0;
  period_log2_ = std::min(period_log2_ + 1, +last_period_log2);
  left_ = 1u << period_log2_;
  setTable();
}

void
QuadModel::setTable()
{
  // Their sum is 2^8; each is at least 1.
  std::array<std::uint32_t, number_count> shares;
  for (std::uint32_t i = 0; i < number_count; ++i)
    shares[i] = 1 + (252 * starts_[i + 1] >> 16) - (252 * starts_[i] >> 16);
  ByteTable::Weights weights;
  for (unsigned int high = 0; high < 16; ++high) {
    const std::uint32_t weight = shares[high >> 2] * shares[high & 3];
    for (unsigned int low = 0; low < 16; ++low)
      weights[high << 4 | low] = weight * (shares[low >> 2] * shares[low & 3]);
  }
  table_.set(weights);
}

} // namespace fast
} // namespace io
} // namespace pcl_ext
