// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxels/voxel_block.h"

namespace pcl_ext {
namespace io {

std::size_t
countBlocks(const std::vector<std::uint64_t>& voxel_keys)
{
  std::size_t blocks = voxel_keys.empty() ? 0 : 1;
  for (std::size_t i = 1; i < voxel_keys.size(); ++i)
    blocks += (voxel_keys[i] ^ voxel_keys[i - 1]) >> block_key_bits != 0 ? 1 : 0;
  return blocks;
}

void
BlockList::clear()
{
  keys.clear();
  masks.clear();
  first_voxels.clear();
}

void
BlockList::append(std::uint64_t key, std::uint64_t mask, std::uint32_t first_voxel)
{
  keys.push_back(key);
  masks.push_back(mask);
  first_voxels.push_back(first_voxel);
}

void
BlockList::assign(const std::vector<std::uint64_t>& voxel_keys)
{
  clear();
  for (std::size_t i = 0; i < voxel_keys.size();) {
    const std::uint64_t key = voxel_keys[i] >> block_key_bits;
    const auto first = static_cast<std::uint32_t>(i);
    std::uint64_t mask = 0;
    for (; i < voxel_keys.size() && voxel_keys[i] >> block_key_bits == key; ++i)
      mask |= std::uint64_t{1} << (voxel_keys[i] & (block_cells - 1));
    append(key, mask, first);
  }
}

void
BlockList::voxelKeys(std::vector<std::uint64_t>& voxel_keys) const
{
  voxel_keys.resize(voxelCount());
  std::uint64_t* voxel_key = voxel_keys.data();
  for (std::size_t block = 0; block < size(); ++block)
    for (std::uint64_t mask = masks[block]; mask != 0; mask &= mask - 1)
      *voxel_key++ = keys[block] << block_key_bits | lowestBit(mask);
}

NeighbourCounts
countNeighbours(std::uint64_t mask,
                const std::array<std::uint64_t, face_count>& neighbours)
{
  // Three full adders add the bits of six masks for all cells at once.
  const auto across = [&](std::size_t face) {
    return occupiedAcross(mask, neighbours[face], face);
  };
  const auto carry = [](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    return (a & b) | (c & (a ^ b));
  };
  const std::uint64_t a = across(0);
  const std::uint64_t b = across(1);
  const std::uint64_t c = across(2);
  const std::uint64_t d = across(3);
  const std::uint64_t e = across(4);
  const std::uint64_t f = across(5);
  const std::uint64_t low_sum = a ^ b ^ c;
  const std::uint64_t low_carry = carry(a, b, c);
  const std::uint64_t high_sum = d ^ e ^ f;
  const std::uint64_t high_carry = carry(d, e, f);
  const std::uint64_t ones_carry = low_sum & high_sum;
  NeighbourCounts counts;
  counts.bits[0] = low_sum ^ high_sum;
  counts.bits[1] = low_carry ^ high_carry ^ ones_carry;
  counts.bits[2] = carry(low_carry, high_carry, ones_carry);
  return counts;
}

} // namespace io
} // namespace pcl_ext
