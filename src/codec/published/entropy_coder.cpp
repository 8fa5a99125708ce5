// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/published/entropy_coder.h"

#include "bytes/byte_writer.h"

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace published {

namespace {

constexpr std::uint32_t top = std::uint32_t{1} << 24;
constexpr std::uint32_t bottom = std::uint32_t{1} << 16;
constexpr unsigned int alphabet_size = 256;

/** \brief Cumulative frequencies: entry s is the number of symbols below s, scaled.
 * Every symbol has a frequency of at least 1, also if it does not occur. */
using CumulativeTable = std::array<std::uint32_t, alphabet_size + 1>;

CumulativeTable
makeTable(const std::vector<std::uint8_t>& symbols)
{
  std::array<std::uint32_t, alphabet_size> histogram{};
  for (const std::uint8_t symbol : symbols)
    ++histogram[symbol];
  CumulativeTable table{};
  for (unsigned int s = 0; s < alphabet_size; ++s)
    table[s + 1] = table[s] + std::max(histogram[s], std::uint32_t{1});
  while (table[alphabet_size] >= bottom)
    for (unsigned int s = 0; s < alphabet_size; ++s)
      table[s + 1] = std::max(table[s + 1] / 2, table[s] + 1);
  return table;
}

/** \brief The interval that encoder and decoder narrow with each symbol. */
class Range {
public:
  /** \brief Width of a frequency of 1. */
  std::uint32_t
  unit(std::uint32_t total) const
  {
    return size_ / total;
  }

  void
  narrow(std::uint32_t unit, std::uint32_t start, std::uint32_t frequency)
  {
    low_ += start * unit;
    size_ = unit * frequency;
  }

  /** \brief True while the first byte is the same in the whole interval. An interval
   * that is too small without that is cut off at the next carry. */
  bool
  hasByte()
  {
    if ((low_ ^ (low_ + size_)) < top)
      return true;
    if (size_ >= bottom)
      return false;
    size_ = (0u - low_) & (bottom - 1);
    return true;
  }

  std::uint8_t
  shift()
  {
    const auto byte = static_cast<std::uint8_t>(low_ >> 24);
    low_ <<= 8;
    size_ <<= 8;
    return byte;
  }

  std::uint32_t
  low() const
  {
    return low_;
  }

private:
  std::uint32_t low_ = 0;
  std::uint32_t size_ = 0xffffffff;
};

bool
isTable(const CumulativeTable& table)
{
  if (table[0] != 0 || table[alphabet_size] >= bottom)
    return false;
  for (unsigned int s = 0; s < alphabet_size; ++s)
    if (table[s + 1] <= table[s])
      return false;
  return true;
}

/** \brief False if no row of that many symbols has the table.
 *
 * In a table that was not scaled the frequency of a symbol is its count, or 1 if it
 * does not occur. A scaled table has a total of at least bottom / 2, and before scaling
 * symbols that do not occur contributed less than 256 to the total.
 */
bool
allowsCount(const CumulativeTable& table, std::size_t count)
{
  const std::uint32_t total = table[alphabet_size];
  std::uint32_t certain = 0; // counts of symbols that must occur
  for (unsigned int s = 0; s < alphabet_size; ++s)
    if (table[s + 1] - table[s] > 1)
      certain += table[s + 1] - table[s];
  return (count >= certain && count <= total) ||
         (total >= bottom / 2 && count > bottom - alphabet_size);
}

/** \brief For each number below the total, the symbol whose range contains it. */
std::vector<std::uint8_t>
symbolOfCount(const CumulativeTable& table)
{
  std::vector<std::uint8_t> symbols(table[alphabet_size]);
  for (unsigned int s = 0; s < alphabet_size; ++s)
    std::fill(symbols.data() + table[s],
              symbols.data() + table[s + 1],
              static_cast<std::uint8_t>(s));
  return symbols;
}

} // namespace

void
encodeStaticRange(const std::vector<std::uint8_t>& symbols,
                  std::vector<std::uint8_t>& bytes)
{
  const CumulativeTable table = makeTable(symbols);
  ByteWriter writer(bytes);
  for (const std::uint32_t entry : table)
    writer.u32(entry);
  Range range;
  for (const std::uint8_t symbol : symbols) {
    range.narrow(range.unit(table[alphabet_size]),
                 table[symbol],
                 table[symbol + 1u] - table[symbol]);
    while (range.hasByte())
      writer.u8(range.shift());
  }
  for (int i = 0; i < 4; ++i)
    writer.u8(range.shift());
}

bool
decodeStaticRange(ByteSource& source,
                  std::size_t count,
                  std::vector<std::uint8_t>& symbols)
{
  CumulativeTable table;
  for (std::uint32_t& entry : table)
    entry = source.u32();
  symbols.clear();
  if (source.failure() != ByteSource::Failure::None || !isTable(table) ||
      !allowsCount(table, count))
    return false;

  const std::uint32_t total = table[alphabet_size];
  const std::vector<std::uint8_t> symbol_of_count = symbolOfCount(table);
  std::uint32_t code = 0;
  for (int i = 0; i < 4; ++i)
    code = code << 8 | source.u8();
  Range range;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t unit = range.unit(total);
    const std::uint32_t position = (code - range.low()) / unit;
    if (position >= total || source.failure() != ByteSource::Failure::None)
      return false;
    const std::uint8_t symbol = symbol_of_count[position];
    symbols.push_back(symbol);
    range.narrow(unit, table[symbol], table[symbol + 1u] - table[symbol]);
    while (range.hasByte()) {
      range.shift();
      code = code << 8 | source.u8();
    }
  }
  return source.failure() == ByteSource::Failure::None && code == range.low() &&
         table == makeTable(symbols);
}

} // namespace published
} // namespace pcl_ext::PCL_EXT_ABI::io
