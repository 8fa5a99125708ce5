// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/scan/symbol_coding.h"

#include <algorithm>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

namespace {

/** \brief Models of the widths of tables, by the length of the width before. */
using WidthModels = std::array<rans::NibbleModel, rans::NibbleModel::symbol_count>;

/** \brief Codes the widths of a table: how many bits each has, and those below its
 * highest. After the last one that is above 0 there is none.
 * \return false if they are no table
 */
template <class CoderT>
bool
codeWidths(CoderT& coder, WidthModels& models, SymbolTable::Widths& widths)
{
  std::uint32_t left = rans::probability_one;
  unsigned int length = 0;
  coder.reserve(2 * widths.size());
  for (std::size_t symbol = 0; left > 0; ++symbol) {
    if (symbol == widths.size() || coder.isOverrun())
      return false;
    std::uint32_t width = widths[symbol];
    length = coder.code(models[length], width > 0 ? highestBit(width) + 1 : 0);
    if (length > rans::probability_bits)
      return false;
    const unsigned int low_bits = length > 1 ? length - 1 : 0;
    if (low_bits > 0)
      width = 1u << low_bits | coder.codeBits(low_bits, width & ((1u << low_bits) - 1));
    else
      width = length;
    if (width > left)
      return false;
    left -= width;
    widths[symbol] = static_cast<std::uint16_t>(width);
  }
  return true;
}

/** \brief Codes whether a context has a table of its own, or that of the one before. */
template <class CoderT>
bool
codeHasTable(CoderT& coder, bool has_table)
{
  coder.reserve(1);
  return coder.codeBits(1, has_table ? 1 : 0) != 0;
}

/** \brief Merges the counts of contexts which take fewer bits with one table.
 * \param[in,out] counts of a context with a table of its own: those of all that use it;
 * of others: zeros
 */
void
mergeCounts(std::vector<SymbolCounts>& counts)
{
  std::size_t first = 0;
  std::uint64_t cost = costOf(counts[0]);
  for (std::size_t context = 1; context < counts.size(); ++context) {
    SymbolCounts both;
    std::transform(counts[first].begin(),
                   counts[first].end(),
                   counts[context].begin(),
                   both.begin(),
                   [](std::uint32_t a, std::uint32_t b) { return a + b; });
    const std::uint64_t cost_of_both = costOf(both);
    const std::uint64_t cost_of_context = costOf(counts[context]);
    if (cost_of_both > cost + cost_of_context) {
      first = context;
      cost = cost_of_context;
      continue;
    }
    counts[first] = both;
    counts[context].fill(0);
    cost = cost_of_both;
  }
}

/** \brief How often the coder codes something for so many symbols and their low bits. */
std::size_t
codesOf(const std::vector<SymbolCounts>& counts)
{
  std::size_t codes = 0;
  for (const SymbolCounts& of_context : counts)
    for (unsigned int symbol = 0; symbol < SymbolTable::symbol_count; ++symbol) {
      const unsigned int bits = symbol < number_symbol_count ? lowBitsOf(symbol) : 0;
      const unsigned int parts =
          (bits + rans::probability_bits - 1) / rans::probability_bits;
      codes += of_context[symbol] * std::size_t{1 + parts};
    }
  return codes;
}

bool
isEmpty(const SymbolCounts& counts)
{
  return std::all_of(
      counts.begin(), counts.end(), [](std::uint32_t count) { return count == 0; });
}

} // namespace

void
SymbolEncoding::reserve(std::size_t numbers)
{
  std::vector<std::uint32_t>& symbols = work_->symbols;
  const auto used = static_cast<std::size_t>(next_ - symbols.data());
  if (symbols.size() - used >= 2 * numbers)
    return;
  symbols.resize(used + used / 2 + 2 * numbers);
  next_ = symbols.data() + used;
}

void
SymbolEncoding::countSymbols(std::size_t context_count)
{
  work_->counts.assign(context_count, SymbolCounts{});
  for (const std::uint32_t* symbol = work_->symbols.data(); symbol != next_; ++symbol)
    if ((*symbol & low_bits) == 0)
      ++work_->counts[*symbol >> 8][*symbol & 0xff];
}

void
SymbolEncoding::encodeSymbols(rans::ReverseEncoder& encoder_now) const
{
  rans::ReverseEncoder encoder = encoder_now; // in registers
  const auto push_bits = [&encoder](std::uint32_t number, unsigned int count) {
    const unsigned int shift = rans::probability_bits - count;
    const std::uint32_t bits = number & ((1u << count) - 1);
    encoder.push(rans::packed({bits << shift, 1u << shift}));
  };
  const std::uint32_t* const begin = work_->symbols.data();
  for (const std::uint32_t* symbol = next_; symbol != begin;) {
    const std::uint32_t low = *--symbol;
    if ((low & low_bits) != 0) {
      --symbol;
      const unsigned int bits = lowBitsOf(*symbol & 0xff);
      unsigned int done = (bits - 1) % rans::probability_bits + 1;
      push_bits(low, done);
      for (; done < bits; done += rans::probability_bits)
        push_bits(low >> done, rans::probability_bits);
    }
    const SymbolTable& table = *work_->table_of_context[*symbol >> 8];
    encoder.push(rans::packed(table.range(*symbol & 0xff)));
  }
  encoder_now = encoder;
}

void
SymbolEncoding::finish(std::size_t context_count, std::vector<std::uint8_t>& bytes)
{
  countSymbols(context_count);
  const std::size_t code_count = codesOf(work_->counts);
  mergeCounts(work_->counts);
  rans::NibbleEncoder coder(work_->ranges); // of the tables
  WidthModels models;
  std::size_t table_count = 0;
  for (std::size_t context = 0; context < context_count; ++context) {
    const bool has_table = context == 0 || !isEmpty(work_->counts[context]);
    if (context > 0)
      codeHasTable(coder, has_table);
    if (has_table) {
      SymbolTable::Widths widths = widthsOf(work_->counts[context]);
      codeWidths(coder, models, widths);
      if (work_->tables.size() == table_count)
        work_->tables.emplace_back();
      work_->tables[table_count++].set(widths);
    }
    work_->table_of_context[context] = &work_->tables[table_count - 1];
  }
  rans::ReverseEncoder encoder(
      coder.size() + code_count, rans::Interleaving::Four, work_->words);
  encodeSymbols(encoder);
  encoder.push(coder.ranges(), coder.size());
  encoder.finish(bytes);
}

SymbolDecoding::SymbolDecoding(const std::uint8_t* begin,
                               const std::uint8_t* end,
                               std::size_t context_count,
                               SymbolWorkspace& work)
: coder_(begin, end, rans::Interleaving::Four, work.copy), work_(&work)
{
  has_tables_ = readTables(context_count);
}

bool
SymbolDecoding::readTables(std::size_t context_count)
{
  WidthModels models;
  std::size_t table_count = 0;
  for (std::size_t context = 0; context < context_count; ++context) {
    if (coder_.isOverrun())
      return false;
    if (context == 0 || codeHasTable(coder_, false)) {
      SymbolTable::Widths widths{};
      if (!codeWidths(coder_, models, widths))
        return false;
      if (work_->tables.size() == table_count)
        work_->tables.emplace_back();
      work_->tables[table_count++].set(widths);
    }
    work_->table_of_context[context] = &work_->tables[table_count - 1];
  }
  return true;
}

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
