#include "codec/context/workspace.h"

namespace pcl_ext {
namespace io {
namespace context {

void
Workspace::begin(const History& history, const BlockList* frame)
{
  const std::vector<HistoryBlock>& known = history.blocks();
  new_keys.clear();
  target_keys.clear();
  target_masks.clear();
  // With room to grow, so that a stream soon needs no more memory.
  for (std::vector<std::uint64_t>* cells : {&occupied, &new_cells}) {
    if (cells->capacity() < known.size())
      cells->reserve(known.size() / 4 * 5 + 4);
    cells->assign(known.size(), 0);
  }
  directory.clear(known.size() + known.size() / 8);
  for (const HistoryBlock& block : known)
    directory.insert(block.key);
  if (frame == nullptr)
    return;
  std::size_t old = 0;
  for (std::size_t i = 0; i < frame->size(); ++i) {
    while (old < known.size() && known[old].key < frame->keys[i])
      ++old;
    if (old < known.size() && known[old].key == frame->keys[i]) {
      occupied[old] = frame->masks[i] & known[old].known;
      new_cells[old] = frame->masks[i] & ~known[old].known;
    }
    else {
      target_keys.push_back(frame->keys[i]);
      target_masks.push_back(frame->masks[i]);
    }
  }
}

void
Workspace::collect(const History& history, BlockList& frame) const
{
  frame.clear();
  const std::vector<HistoryBlock>& known = history.blocks();
  std::size_t old = 0;
  std::size_t added = 0;
  std::uint32_t voxels = 0;
  while (old < known.size() || added < new_keys.size()) {
    const bool is_old = added == new_keys.size() ||
                        (old < known.size() && known[old].key < new_keys[added]);
    const std::uint64_t key = is_old ? known[old].key : new_keys[added];
    const std::uint64_t mask = occupied[is_old ? old : known.size() + added];
    (is_old ? old : added) += 1;
    if (mask == 0)
      continue;
    frame.append(key, mask, voxels);
    voxels += cellCount(mask);
  }
}

} // namespace context
} // namespace io
} // namespace pcl_ext
