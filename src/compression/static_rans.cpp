#include "static_rans.h"

#include "bit_io.h"
#include "byte_writer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pcl_ext {
namespace io {

namespace {

constexpr unsigned int alphabet_size = 256;
constexpr std::uint32_t lowest_state = std::uint32_t{1} << 16;
constexpr unsigned int largest_state_count = 2;

enum class RowCoding : std::uint8_t { Raw = 0, Constant = 1, Rans = 2 };

using Histogram = std::array<std::uint32_t, alphabet_size>;

/** \brief Frequencies that add up to 2^scale_bits, and where each symbol's share
 * begins.
 */
struct FrequencyTable {
  unsigned int scale_bits = 0;
  std::array<std::uint32_t, alphabet_size> frequency{};
  std::array<std::uint32_t, alphabet_size> start{};

  /** \brief Sets the starts; false if the frequencies do not add up. */
  bool
  accumulate()
  {
    std::uint32_t sum = 0;
    for (unsigned int symbol = 0; symbol < alphabet_size; ++symbol) {
      start[symbol] = sum;
      sum += frequency[symbol];
    }
    return sum == std::uint32_t{1} << scale_bits;
  }
};

/** \brief A long row can afford finer frequencies; both sides know its length. */
unsigned int
scaleBits(std::size_t count)
{
  return count < (std::size_t{1} << 15) ? 12 : 14;
}

/** \brief Two states work in parallel on a long row; a short one saves the four bytes.
 */
unsigned int
stateCount(std::size_t count)
{
  return count < 256 ? 1 : largest_state_count;
}

Histogram
countSymbols(const std::vector<std::uint8_t>& symbols)
{
  Histogram histogram{};
  for (const std::uint8_t symbol : symbols)
    ++histogram[symbol];
  return histogram;
}

/** \brief Scales counts to frequencies: each symbol that occurs keeps at least 1, the
 * rounding error goes to the most frequent ones, where it costs least. */
FrequencyTable
normalise(const Histogram& histogram, std::size_t count)
{
  FrequencyTable table;
  table.scale_bits = scaleBits(count);
  const std::uint32_t total = std::uint32_t{1} << table.scale_bits;
  std::int64_t excess = -static_cast<std::int64_t>(total);
  for (unsigned int symbol = 0; symbol < alphabet_size; ++symbol) {
    if (histogram[symbol] == 0)
      continue;
    const std::uint64_t scaled =
        (static_cast<std::uint64_t>(histogram[symbol]) * total + count / 2) / count;
    table.frequency[symbol] =
        static_cast<std::uint32_t>(std::max<std::uint64_t>(scaled, 1));
    excess += table.frequency[symbol];
  }
  while (excess != 0) {
    auto largest = std::max_element(table.frequency.begin(), table.frequency.end());
    const std::int64_t correction =
        excess > 0 ? std::min<std::int64_t>(excess, (*largest + 3) / 4) : excess;
    *largest = static_cast<std::uint32_t>(*largest - correction);
    excess -= correction;
  }
  table.accumulate();
  return table;
}

/** \brief Table on the wire: the last symbol that occurs, then frequency + 1 of each
 * symbol up to it as an Elias gamma code. */
void
writeTable(const FrequencyTable& table, std::vector<std::uint8_t>& bytes)
{
  unsigned int last = alphabet_size - 1;
  while (table.frequency[last] == 0)
    --last;
  bytes.push_back(static_cast<std::uint8_t>(last));
  BitWriter bits(bytes);
  for (unsigned int symbol = 0; symbol <= last; ++symbol)
    bits.gamma(table.frequency[symbol] + 1);
  bits.flush();
}

bool
readTable(const std::uint8_t*& cursor, const std::uint8_t* end, FrequencyTable& table)
{
  if (cursor == end)
    return false;
  const unsigned int last = *cursor++;
  BitReader bits(cursor, end);
  for (unsigned int symbol = 0; symbol <= last; ++symbol) {
    const std::uint32_t code = bits.gamma();
    if (code == 0)
      return false;
    table.frequency[symbol] = code - 1;
  }
  cursor = bits.position();
  return table.frequency[last] != 0 && table.accumulate();
}

void
encodeRans(const std::vector<std::uint8_t>& symbols,
           const FrequencyTable& table,
           std::vector<std::uint8_t>& bytes)
{
  const unsigned int states = stateCount(symbols.size());
  std::array<std::uint32_t, largest_state_count> state;
  state.fill(lowest_state);
  std::vector<std::uint16_t> words;
  words.reserve(symbols.size() / 2 + 16);
  // Backwards, so that the decoder reads forwards.
  for (std::size_t i = symbols.size(); i-- > 0;) {
    const std::uint8_t symbol = symbols[i];
    const std::uint32_t frequency = table.frequency[symbol];
    std::uint32_t& x = state[i & (states - 1)];
    // 64 bits: a symbol that has nearly the whole table leaves no state too large.
    if (x >= static_cast<std::uint64_t>(frequency) << (32 - table.scale_bits)) {
      words.push_back(static_cast<std::uint16_t>(x));
      x >>= 16;
    }
    x = ((x / frequency) << table.scale_bits) + x % frequency + table.start[symbol];
  }
  ByteWriter writer(bytes);
  for (unsigned int i = 0; i < states; ++i)
    writer.u32(state[i]);
  for (std::size_t i = words.size(); i-- > 0;)
    writer.u16(words[i]);
}

struct Slot {
  std::uint16_t frequency;
  std::uint16_t offset; // of this slot within its symbol's share
  std::uint8_t symbol;
};

std::vector<Slot>
makeSlots(const FrequencyTable& table)
{
  std::vector<Slot> slots(std::size_t{1} << table.scale_bits);
  for (unsigned int symbol = 0; symbol < alphabet_size; ++symbol)
    for (std::uint32_t i = 0; i < table.frequency[symbol]; ++i)
      slots[table.start[symbol] + i] = {
          static_cast<std::uint16_t>(table.frequency[symbol]),
          static_cast<std::uint16_t>(i),
          static_cast<std::uint8_t>(symbol)};
  return slots;
}

bool
decodeRans(const std::uint8_t*& cursor,
           const std::uint8_t* end,
           const FrequencyTable& table,
           std::vector<std::uint8_t>& symbols)
{
  const unsigned int states = stateCount(symbols.size());
  if (end - cursor < static_cast<std::ptrdiff_t>(4 * states))
    return false;
  std::array<std::uint32_t, largest_state_count> state{};
  for (unsigned int i = 0; i < states; ++i, cursor += 4)
    state[i] = static_cast<std::uint32_t>(cursor[0]) |
               static_cast<std::uint32_t>(cursor[1]) << 8 |
               static_cast<std::uint32_t>(cursor[2]) << 16 |
               static_cast<std::uint32_t>(cursor[3]) << 24;
  const std::vector<Slot> slots = makeSlots(table);
  const std::uint32_t mask = (std::uint32_t{1} << table.scale_bits) - 1;
  bool is_complete = true;
  const auto next = [&](std::uint32_t& x) {
    const Slot slot = slots[x & mask];
    x = slot.frequency * (x >> table.scale_bits) + slot.offset;
    if (x < lowest_state) {
      if (end - cursor < 2) {
        is_complete = false;
        x = lowest_state; // whatever follows is not used
      }
      else {
        x = x << 16 | static_cast<std::uint32_t>(cursor[0]) |
            static_cast<std::uint32_t>(cursor[1]) << 8;
        cursor += 2;
      }
    }
    return slot.symbol;
  };
  std::size_t i = 0;
  if (states == largest_state_count) {
    // In turns and in registers, so that the machine works on both at once.
    std::uint32_t even = state[0];
    std::uint32_t odd = state[1];
    for (; i + 1 < symbols.size() && is_complete; i += 2) {
      symbols[i] = next(even);
      symbols[i + 1] = next(odd);
    }
    state = {even, odd};
  }
  for (; i < symbols.size() && is_complete; ++i)
    symbols[i] = next(state[i & (states - 1)]);
  if (!is_complete)
    return false;
  // The encoder began with these states; any others are not its work.
  return std::all_of(state.begin(), state.begin() + states, [](std::uint32_t x) {
    return x == lowest_state;
  });
}

} // namespace

void
encodeSymbols(const std::vector<std::uint8_t>& symbols,
              std::vector<std::uint8_t>& bytes)
{
  if (symbols.empty())
    return;
  const std::size_t begin = bytes.size();
  const Histogram histogram = countSymbols(symbols);
  if (histogram[symbols[0]] == symbols.size()) {
    bytes.push_back(static_cast<std::uint8_t>(RowCoding::Constant));
    bytes.push_back(symbols[0]);
    return;
  }
  const FrequencyTable table = normalise(histogram, symbols.size());
  bytes.push_back(static_cast<std::uint8_t>(RowCoding::Rans));
  writeTable(table, bytes);
  encodeRans(symbols, table, bytes);
  if (bytes.size() - begin <= 1 + symbols.size())
    return;
  bytes.resize(begin);
  bytes.push_back(static_cast<std::uint8_t>(RowCoding::Raw));
  bytes.insert(bytes.end(), symbols.begin(), symbols.end());
}

bool
decodeSymbols(const std::uint8_t*& cursor,
              const std::uint8_t* end,
              std::size_t count,
              std::vector<std::uint8_t>& symbols)
{
  symbols.clear();
  if (count == 0)
    return true;
  if (cursor == end)
    return false;
  const std::uint8_t coding = *cursor++;
  const auto available = static_cast<std::size_t>(end - cursor);
  switch (static_cast<RowCoding>(coding)) {
  case RowCoding::Raw:
    if (available < count)
      return false;
    symbols.assign(cursor, cursor + count);
    cursor += count;
    return true;
  case RowCoding::Constant:
    if (available < 1)
      return false;
    symbols.assign(count, *cursor++);
    return true;
  case RowCoding::Rans: {
    FrequencyTable table;
    table.scale_bits = scaleBits(count);
    if (!readTable(cursor, end, table))
      return false;
    symbols.resize(count);
    return decodeRans(cursor, end, table, symbols);
  }
  }
  return false;
}

double
orderZeroBits(const std::vector<std::uint8_t>& symbols)
{
  double bits = 0.0;
  const double total = static_cast<double>(symbols.size());
  for (const std::uint32_t count : countSymbols(symbols))
    if (count > 0)
      bits += count * std::log2(total / count);
  return bits;
}

} // namespace io
} // namespace pcl_ext
