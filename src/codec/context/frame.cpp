#include "codec/context/frame.h"

#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"

namespace pcl_ext {
namespace io {
namespace context {

void
Frame::begin(const History& history)
{
  const std::vector<HistoryBlock>& known = history.blocks();
  new_keys.clear();
  target_keys.clear();
  target_masks.clear();
  for (std::vector<std::uint64_t>* cells : {&occupied, &new_cells}) {
    reserveAhead(*cells, known.size());
    cells->assign(known.size(), 0);
  }
  directory.clear(known.size() + known.size() / 8);
  for (const HistoryBlock& block : known)
    directory.insert(block.key);
}

std::size_t
Frame::match(const History& history, const BlockList& blocks)
{
  begin(history);
  const std::vector<HistoryBlock>& known = history.blocks();
  AscendingLookup<HistoryBlock> lookup(known);
  std::size_t known_voxels = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const std::size_t old = lookup.find(blocks.keys[i]);
    if (old != not_in_list) {
      occupied[old] = blocks.masks[i] & known[old].known;
      new_cells[old] = blocks.masks[i] & ~known[old].known;
      known_voxels += bitCount(occupied[old]);
    }
    else {
      target_keys.push_back(blocks.keys[i]);
      target_masks.push_back(blocks.masks[i]);
    }
  }
  return known_voxels;
}

void
Frame::collect(const History& history, BlockList& blocks) const
{
  blocks.clear();
  const std::vector<HistoryBlock>& known = history.blocks();
  std::uint32_t voxels = 0;
  const auto append = [&](std::uint64_t key, std::uint64_t mask) {
    if (mask == 0)
      return;
    blocks.append(key, mask, voxels);
    voxels += bitCount(mask);
  };
  walkSideBySide(
      known,
      new_keys,
      [&](std::size_t old) { append(known[old].key, occupied[old]); },
      [&](std::size_t added, std::size_t) {
        append(new_keys[added], occupied[known.size() + added]);
        return true;
      });
}

} // namespace context
} // namespace io
} // namespace pcl_ext
