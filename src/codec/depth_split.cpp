#include "codec/depth_split.h"

#include <algorithm>
#include <array>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::uint64_t one_symbol = std::uint64_t{1} << 16;
// Depth offsets are shares of the point's intensity, in 2^-14.
constexpr std::int64_t one_offset = std::int64_t{1} << 14;
constexpr std::int64_t largest_offset = one_offset / 2;

std::uint32_t
bitLength(std::uint32_t number)
{
  std::uint32_t bits = 0;
  for (; number != 0; number >>= 1)
    ++bits;
  return bits;
}

/** \brief Bit length of half a symbol, 0..7.
 * \param[in] exact the symbol, in 2^-16
 */
std::uint32_t
sizeOf(std::uint64_t exact)
{
  return bitLength(
      static_cast<std::uint32_t>(std::min<std::uint64_t>(exact >> 17, 127)));
}

/** \brief Class of a rest by what it depends on: the symbol's size, where in the
 * predicted symbol the exact number is, and how rough the voxel's rests were.
 * \param[in] exact predicted symbol, in 2^-16
 * \param[in] roughness 0..5
 */
std::uint8_t
restClass(std::uint64_t exact, std::uint32_t roughness)
{
  const auto fraction = static_cast<std::uint32_t>(exact >> 14 & 3);
  return static_cast<std::uint8_t>((sizeOf(exact) * 4 + fraction) * 6 + roughness);
}

/** \brief Class of a record's roughness, 1..5. */
std::uint8_t
roughnessClass(std::uint32_t roughness)
{
  return roughness < 6    ? 1
         : roughness < 14 ? 2
         : roughness < 24 ? 3
         : roughness < 48 ? 4
                          : 5;
}

} // namespace

void
DepthSplit::begin(const DepthModel& model,
                  const BlockList& frame,
                  const context::History& history,
                  std::uint32_t max_symbol)
{
  max_symbol_ = max_symbol;
  std::array<std::int64_t, block_cells> cell_depth;
  for (unsigned int cell = 0; cell < block_cells; ++cell) {
    const VoxelPosition position = voxelPosition(cell);
    cell_depth[cell] = std::int64_t{model.step[0]} * position.x +
                       std::int64_t{model.step[1]} * position.y +
                       std::int64_t{model.step[2]} * position.z;
  }
  centre_symbols_.clear();
  point_symbols_.clear();
  roughness_.clear();
  const std::vector<context::HistoryBlock>& known = history.blocks();
  const context::VoxelRecord* const records = history.records();
  std::size_t old = 0;
  for (std::size_t block = 0; block < frame.size(); ++block) {
    while (old < known.size() && known[old].key < frame.keys[block])
      ++old;
    const bool is_known = old < known.size() && known[old].key == frame.keys[block];
    const std::uint64_t known_cells = is_known ? known[old].known : 0;
    const VoxelPosition position = voxelPosition(frame.keys[block] << block_key_bits);
    const std::int64_t depth = model.origin + std::int64_t{model.step[0]} * position.x +
                               std::int64_t{model.step[1]} * position.y +
                               std::int64_t{model.step[2]} * position.z;
    for (std::uint64_t cells = frame.masks[block]; cells != 0; cells &= cells - 1) {
      const std::uint64_t cell = cells & (~cells + 1);
      const std::uint64_t centre =
          model.pointSymbolAt(depth + cell_depth[lowestCell(cells)]);
      std::uint64_t point = centre;
      std::uint8_t roughness = 0;
      if ((known_cells & cell) != 0) {
        const std::size_t record =
            known[old].first_record + cellCount(known_cells & (cell - 1));
        const std::int64_t factor = one_offset + records[record].depth_offset;
        point = centre * static_cast<std::uint64_t>(factor) >> 14;
        roughness = roughnessClass(records[record].roughness);
      }
      centre_symbols_.push_back(centre);
      point_symbols_.push_back(point);
      roughness_.push_back(roughness);
    }
  }
}

void
DepthSplit::numbersOf(const std::vector<std::uint16_t>& symbols,
                      std::vector<std::uint16_t>& numbers) const
{
  numbers.resize(symbols.size());
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    const std::uint64_t point_symbol = point_symbols_[i];
    numbers[i] =
        point_symbol < one_symbol
            ? symbols[i]
            : static_cast<std::uint16_t>(
                  ((static_cast<std::uint64_t>(symbols[i]) << 16) + point_symbol / 2) /
                  point_symbol);
  }
}

void
DepthSplit::predict(const std::vector<std::uint16_t>& numbers)
{
  predicted_.resize(numbers.size());
  classes_.resize(numbers.size());
  places_.resize(numbers.size());
  point_classes_.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::uint64_t exact = numbers[i] * point_symbols_[i];
    const auto predicted = static_cast<std::uint32_t>(
        std::min<std::uint64_t>((exact + one_symbol / 2) >> 16, max_symbol_));
    predicted_[i] = static_cast<std::uint16_t>(predicted);
    places_[i] = static_cast<std::uint8_t>(sizeOf(exact) * 16 + (exact >> 12 & 15));
    const unsigned int number = numbers[i];
    point_classes_[i] = number < 2 ? 0 : number < 3 ? 1 : number < 6 ? 2 : 3;
    classes_[i] =
        point_symbols_[i] < one_symbol ? no_rest : restClass(exact, roughness_[i]);
  }
}

bool
DepthSplit::symbol(std::size_t voxel, std::uint32_t rest, std::uint16_t& symbol) const
{
  if (rest > 2 * max_symbol_)
    return false;
  const auto half = static_cast<std::int32_t>(rest >> 1);
  const std::int32_t distance = (rest & 1) != 0 ? -half - 1 : half;
  const std::int32_t value = static_cast<std::int32_t>(predicted_[voxel]) + distance;
  if (value < 0 || value > static_cast<std::int32_t>(max_symbol_))
    return false;
  symbol = static_cast<std::uint16_t>(value);
  return true;
}

void
DepthSplit::observe(const std::vector<std::uint16_t>& numbers,
                    const std::vector<std::uint16_t>& symbols,
                    context::DepthObservations& depths) const
{
  depths.offsets.resize(numbers.size());
  depths.rests.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    depths.offsets[i] = 0;
    depths.rests[i] =
        classes_[i] == no_rest
            ? std::uint8_t{0}
            : static_cast<std::uint8_t>(std::min(rest(i, symbols[i]), 15u));
    // A symbol at the end of the scale says nothing about where its points are.
    if (classes_[i] == no_rest || numbers[i] == 0 || symbols[i] == max_symbol_)
      continue;
    const auto centred = static_cast<std::int64_t>(numbers[i] * centre_symbols_[i]);
    const std::int64_t distance = (std::int64_t{symbols[i]} << 16) - centred;
    depths.offsets[i] = static_cast<std::int16_t>(
        std::clamp(distance * one_offset / centred, -largest_offset, largest_offset));
  }
}

} // namespace io
} // namespace pcl_ext
