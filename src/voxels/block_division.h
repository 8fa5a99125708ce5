// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "bytes/reserve_ahead.h"
#include "voxels/ascending_keys.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Divides the blocks of a frame into known ones, as those of a history, and new
 * ones. Without branches on whether a known block is in the frame, which would be
 * mispredicted.
 * \param[in] known blocks, ascending
 * \param[in] keys,masks,count blocks of the frame, ascending
 * \param[in] visit_known called with the index of each known block, its cells that are
 * occupied in the frame, and, unless these are 0, its index in the frame
 * \param[out] new_keys,new_masks of the blocks that are not known, ascending
 */
template <class Known, class VisitKnown>
void
divideBlocks(const std::vector<Known>& known,
             const std::uint64_t* keys,
             const std::uint64_t* masks,
             std::size_t count,
             const VisitKnown& visit_known,
             std::vector<std::uint64_t>& new_keys,
             std::vector<std::uint64_t>& new_masks)
{
  for (auto* vector : {&new_keys, &new_masks}) {
    reserveAhead(*vector, count);
    vector->resize(count);
  }
  std::size_t now = 0;
  std::size_t new_count = 0;
  const auto append_new = [&] {
    new_keys[new_count] = keys[now];
    new_masks[new_count++] = masks[now++];
  };
  // Blocks above the last one of the frame are visited in a loop of their own, so that
  // this one needs no check for the end of the frame.
  const auto is_above = [](std::uint64_t key, const Known& block) {
    return key < keyOf(block);
  };
  const auto above =
      count == 0
          ? known.begin()
          : std::upper_bound(known.begin(), known.end(), keys[count - 1], is_above);
  const auto known_count = static_cast<std::size_t>(above - known.begin());
  const Known* const blocks = known.data();
  for (std::size_t i = 0; i < known_count; ++i) {
    const std::uint64_t key = keyOf(blocks[i]);
    while (keys[now] < key)
      append_new();
    const std::uint64_t is_same = keys[now] == key ? 1 : 0;
    visit_known(i, masks[now] & (0 - is_same), now);
    now += is_same;
  }
  for (std::size_t i = known_count; i < known.size(); ++i)
    visit_known(i, std::uint64_t{0}, std::size_t{0});
  while (now < count)
    append_new();
  new_keys.resize(new_count);
  new_masks.resize(new_count);
}

} // namespace pcl_ext::PCL_EXT_ABI::io
