#include "version1_payload.h"

#include "byte_source.h"
#include "byte_writer.h"
#include "memory_buffer.h"
#include "static_rans.h"

#include <algorithm>
#include <string>

namespace pcl_ext {
namespace io {

namespace {

enum class Prediction : std::uint8_t { None = 0, PreviousFrame = 1 };

/** \brief The occupancy bytes of all levels in a row, XOR-ed with a reference if any.
 */
void
collectOccupancy(const OccupancyTree& tree,
                 const OccupancyTree* reference,
                 std::vector<std::uint8_t>& symbols)
{
  symbols.clear();
  for (unsigned int index = 0; index < tree.depth(); ++index) {
    const OccupancyLevel& level = tree.level(index);
    OccupancyCursor cursor = reference != nullptr
                                 ? OccupancyCursor(reference->level(index))
                                 : OccupancyCursor();
    for (std::size_t i = 0; i < level.size(); ++i)
      symbols.push_back(static_cast<std::uint8_t>(level.occupancy[i] ^
                                                  cursor.occupancyOf(level.nodes[i])));
  }
}

/** \brief Fills one level, whose nodes are known, and names the nodes below it.
 * \param[in] symbols one for each node of the level
 * \param[in,out] level its occupancy is filled
 * \param[out] children nodes of the next level
 * \return false if a branch is empty, or the children are more than there are voxels
 */
bool
expandLevel(const std::uint8_t* symbols,
            std::size_t voxel_count,
            OccupancyCursor reference,
            OccupancyLevel& level,
            std::vector<std::uint64_t>& children)
{
  // All eight children are written, of which those that are not there are overwritten
  // by the next branch's.
  constexpr std::size_t spare = 8;
  children.resize(std::min(8 * level.nodes.size(), voxel_count) + spare);
  std::size_t child_count = 0;
  level.occupancy.resize(level.nodes.size());
  for (std::size_t i = 0; i < level.nodes.size(); ++i) {
    const std::uint64_t node = level.nodes[i];
    const auto occupancy =
        static_cast<std::uint8_t>(symbols[i] ^ reference.occupancyOf(node));
    // Every node leads to a voxel, so no level has more nodes than there are voxels.
    if (occupancy == 0 || child_count > voxel_count)
      return false;
    level.occupancy[i] = occupancy;
    const ChildList& list = childrenOf(occupancy);
    for (std::size_t child = 0; child < 8; ++child)
      children[child_count + child] = node << 3 | list.children[child];
    child_count += list.count;
  }
  if (child_count > voxel_count)
    return false;
  children.resize(child_count);
  return true;
}

/** \brief Fills the tree from the top with the symbols that collectOccupancy made. */
bool
expandOccupancy(const std::vector<std::uint8_t>& symbols,
                std::size_t voxel_count,
                const OccupancyTree* reference,
                OccupancyTree& tree,
                std::vector<std::uint64_t>& keys)
{
  std::size_t used_symbols = 0;
  std::vector<std::uint64_t> nodes{0}; // of the level that comes next
  for (unsigned int index = 0; index < tree.depth(); ++index) {
    OccupancyLevel& level = tree.level(index);
    if (nodes.size() > symbols.size() - used_symbols)
      return false;
    level.nodes.swap(nodes);
    if (!expandLevel(symbols.data() + used_symbols,
                     voxel_count,
                     reference != nullptr ? OccupancyCursor(reference->level(index))
                                          : OccupancyCursor(),
                     level,
                     nodes))
      return false;
    used_symbols += level.size();
  }
  keys.swap(nodes);
  return used_symbols == symbols.size() && keys.size() == voxel_count;
}

} // namespace

void
encodeOccupancy(const OccupancyTree& tree,
                const OccupancyTree* reference,
                std::vector<std::uint8_t>& payload)
{
  std::vector<std::uint8_t> symbols;
  collectOccupancy(tree, nullptr, symbols);
  Prediction prediction = Prediction::None;
  if (reference != nullptr) {
    std::vector<std::uint8_t> differences;
    collectOccupancy(tree, reference, differences);
    if (orderZeroBits(differences) <= orderZeroBits(symbols)) {
      prediction = Prediction::PreviousFrame;
      symbols.swap(differences);
    }
  }
  ByteWriter writer(payload);
  writer.u8(static_cast<std::uint8_t>(prediction));
  writer.varint(symbols.size());
  encodeSymbols(symbols, payload);
}

CompressionStatus
decodeOccupancy(const std::uint8_t* begin,
                const std::uint8_t* end,
                std::size_t voxel_count,
                const DecoderLimits& limits,
                const OccupancyTree* reference,
                OccupancyTree& tree,
                std::vector<std::uint64_t>& keys)
{
  const CompressionStatus corrupt{CompressionCode::Corrupt,
                                  "the occupancy bytes are not an octree"};
  const auto size = static_cast<std::size_t>(end - begin);
  MemoryBuffer buffer(begin, size);
  ByteSource source(buffer, size);
  const std::uint8_t prediction = source.u8();
  const std::uint64_t node_count = source.varint();
  if (source.failure() != ByteSource::Failure::None ||
      prediction > static_cast<std::uint8_t>(Prediction::PreviousFrame) ||
      node_count > static_cast<std::uint64_t>(voxel_count) * tree.depth())
    return corrupt;
  if (node_count > maxBranchNodes(limits, tree.depth()))
    return {CompressionCode::LimitExceeded,
            std::to_string(node_count) +
                " branch nodes are more than the limit on voxels allows"};
  const bool is_predicted =
      prediction == static_cast<std::uint8_t>(Prediction::PreviousFrame);
  if (is_predicted && reference == nullptr)
    return corrupt;

  const std::uint8_t* cursor = begin + source.consumed();
  std::vector<std::uint8_t> symbols;
  if (!decodeSymbols(cursor, end, static_cast<std::size_t>(node_count), symbols) ||
      cursor != end ||
      !expandOccupancy(
          symbols, voxel_count, is_predicted ? reference : nullptr, tree, keys))
    return corrupt;
  return {};
}

void
encodeIntensities(const std::vector<std::uint16_t>& intensities,
                  unsigned int bits,
                  std::vector<std::uint8_t>& payload)
{
  std::vector<std::uint8_t> symbols(intensities.size());
  const unsigned int low_bits = bits > 8 ? bits - 8 : 0;
  for (std::size_t i = 0; i < symbols.size(); ++i)
    symbols[i] = static_cast<std::uint8_t>(intensities[i] >> low_bits);
  encodeSymbols(symbols, payload);
  if (low_bits == 0)
    return;
  const auto mask = static_cast<std::uint16_t>((1u << low_bits) - 1);
  for (std::size_t i = 0; i < symbols.size(); ++i)
    symbols[i] = static_cast<std::uint8_t>(intensities[i] & mask);
  encodeSymbols(symbols, payload);
}

CompressionStatus
decodeIntensities(const std::uint8_t* begin,
                  const std::uint8_t* end,
                  std::size_t voxel_count,
                  unsigned int bits,
                  std::vector<std::uint16_t>& intensities)
{
  const CompressionStatus corrupt{CompressionCode::Corrupt,
                                  "the intensities are not symbols of their scale"};
  const unsigned int low_bits = bits > 8 ? bits - 8 : 0;
  std::vector<std::uint8_t> high;
  std::vector<std::uint8_t> low;
  const std::uint8_t* cursor = begin;
  if (!decodeSymbols(cursor, end, voxel_count, high) ||
      (low_bits > 0 && !decodeSymbols(cursor, end, voxel_count, low)) || cursor != end)
    return corrupt;
  intensities.resize(voxel_count);
  std::uint32_t overflow = 0;
  for (std::size_t i = 0; i < voxel_count; ++i) {
    const std::uint32_t low_symbol = low_bits > 0 ? low[i] : 0u;
    const std::uint32_t symbol =
        static_cast<std::uint32_t>(high[i]) << low_bits | low_symbol;
    overflow |= symbol >> bits | low_symbol >> low_bits;
    intensities[i] = static_cast<std::uint16_t>(symbol);
  }
  return overflow == 0 ? CompressionStatus() : corrupt;
}

} // namespace io
} // namespace pcl_ext
