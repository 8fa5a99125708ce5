#include "codec/fast/new_blocks.h"

#include "codec/fast/entropy_coder.h"
#include "simd/bit_operations.h"
#include "voxels/child_masks.h"
#include "voxels/voxel_block.h"

#include <algorithm>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief For an encoder: collects the masks of all nodes above the new blocks. */
void
NewBlocks::collectNodes(const Frame& frame)
{
  const unsigned int levels = levelsAboveBlocks(frame.depth);
  if (node_masks_.size() < levels)
    node_masks_.resize(levels);
  node_keys_.assign(frame.new_keys.begin(), frame.new_keys.end());
  for (unsigned int level = 0; level < levels; ++level) {
    std::vector<std::uint8_t>& masks = node_masks_[level];
    masks.clear();
    std::size_t count = 0;
    for (const std::uint64_t key : node_keys_) {
      // In place: parents overwrite children that were read.
      if (count == 0 || node_keys_[count - 1] != key >> 3) {
        node_keys_[count++] = key >> 3;
        masks.push_back(0);
      }
      masks.back() = static_cast<std::uint8_t>(masks.back() | 1u << (key & 7));
    }
    node_keys_.resize(count);
  }
}

template <class Coder>
bool
NewBlocks::codeNodes(Coder& coder_now, Models& models, unsigned int level, Frame& frame)
{
  ByteModels<1>& node = models.node[std::min(level, 3u)];
  coder_now.reserve(Coder::is_decoder ? 0 : 2 * node_masks_[level].size());
  Coder coder = coder_now;
  if (!Coder::is_decoder) {
    for (const std::uint8_t mask : node_masks_[level])
      codeByte(coder, node, 0, mask);
    coder_now = coder;
    return true;
  }
  // A block has at least one voxel, and a node at least one block.
  const std::size_t max_nodes = frame.voxel_count - frame.found_voxels;
  child_keys_.clear();
  for (const std::uint64_t key : node_keys_) {
    unsigned int mask = codeByte(coder, node, 0, 0);
    if (mask == 0 || coder.isOverrun() || child_keys_.size() > max_nodes)
      return false;
    for (; mask != 0; mask &= mask - 1)
      child_keys_.push_back(key << 3 | lowestBit(mask));
  }
  node_keys_.swap(child_keys_);
  coder_now = coder;
  return node_keys_.size() <= max_nodes;
}

template <class Coder>
bool
NewBlocks::code(Coder& coder, Models& models, Frame& frame)
{
  coder.reserve(1);
  const unsigned int has_blocks = Coder::is_decoder || frame.new_keys.empty() ? 0 : 1;
  if (coder.code(models.has_new_blocks, has_blocks) == 0) {
    frame.new_keys.clear();
    frame.new_masks.clear();
    return true;
  }
  if (!Coder::is_decoder)
    collectNodes(frame);
  else
    node_keys_.assign(1, 0);
  for (unsigned int level = levelsAboveBlocks(frame.depth); level-- > 0;)
    if (!codeNodes(coder, models, level, frame))
      return false;
  if (Coder::is_decoder) {
    frame.new_keys.assign(node_keys_.begin(), node_keys_.end());
    frame.new_masks.assign(node_keys_.size(), 0);
  }
  return codeBlockCells(coder, models, frame);
}

template <class Coder>
bool
NewBlocks::codeBlockCells(Coder& coder_now, Models& models, Frame& frame)
{
  const std::size_t count = frame.new_keys.size();
  coder_now.reserve(18 * count);
  Coder coder = coder_now;
  const std::uint64_t outside = ~cellsInGrid(frame.depth);
  ByteModels<1>& octants_models = models.new_block_octants[frame.is_i_frame ? 1 : 0];
  ByteModels<16>& cells_models = models.new_block_cells[frame.is_i_frame ? 1 : 0];
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t mask = frame.new_masks[i];
    unsigned int octants = codeByte(
        coder, octants_models, 0, Coder::is_decoder ? 0 : occupiedOctants(mask));
    if (octants == 0)
      return false;
    std::uint64_t coded = 0;
    for (; octants != 0; octants &= octants - 1) {
      const unsigned int shift = 8 * lowestBit(octants);
      const auto near = static_cast<unsigned int>(cellsBeside(coded) >> shift & 15);
      const unsigned int cells = codeByte(
          coder, cells_models, near, static_cast<unsigned int>(mask >> shift & 0xff));
      if (cells == 0)
        return false;
      coded |= std::uint64_t{cells} << shift;
      frame.found_voxels += child_masks.count[cells];
    }
    frame.new_masks[i] = coded;
    if (Coder::is_decoder && (coder.isOverrun() || (coded & outside) != 0 ||
                              frame.found_voxels > frame.voxel_count))
      return false;
  }
  coder_now = coder;
  return true;
}

template bool
NewBlocks::code(NibbleEncoder&, Models&, Frame&);
template bool
NewBlocks::code(NibbleDecoder&, Models&, Frame&);

} // namespace fast
} // namespace io
} // namespace pcl_ext
