// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxels/voxel_block.h"

#include "bytes/reserve_ahead.h"
#include "voxels/octant_list.h"

namespace pcl_ext::PCL_EXT_ABI::io {

std::size_t
countBlocks(const std::vector<std::uint64_t>& voxel_keys)
{
  std::size_t blocks = voxel_keys.empty() ? 0 : 1;
  for (std::size_t i = 1; i < voxel_keys.size(); ++i)
    blocks += isNotZero((voxel_keys[i] ^ voxel_keys[i - 1]) >> block_key_bits);
  return blocks;
}

std::size_t
collectBlocks(const std::vector<std::uint64_t>& voxel_keys,
              std::uint64_t* keys,
              std::uint64_t* masks)
{
  if (voxel_keys.empty())
    return 0;
  std::uint64_t last = voxel_keys.front() >> block_key_bits;
  std::uint64_t mask = 0;
  std::size_t block = 0;
  for (const std::uint64_t voxel : voxel_keys) {
    // Without a branch: a block is written again for each of its voxels.
    const std::uint64_t key = voxel >> block_key_bits;
    const std::uint64_t is_other = key != last ? 1 : 0;
    block += is_other;
    mask = (mask & (is_other - 1)) | std::uint64_t{1} << (voxel % block_cells);
    keys[block] = key;
    masks[block] = mask;
    last = key;
  }
  return block + 1;
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
  const std::size_t count = countBlocks(voxel_keys);
  reserveAhead(keys, count);
  reserveAhead(masks, count);
  reserveAhead(first_voxels, count);
  keys.resize(count);
  masks.resize(count);
  first_voxels.resize(count);
  collectBlocks(voxel_keys, keys.data(), masks.data());
  std::uint32_t voxel = 0;
  for (std::size_t i = 0; i < count; ++i) {
    first_voxels[i] = voxel;
    voxel += bitCount(masks[i]);
  }
}

void
BlockList::voxelKeys(OctantList& octants, std::vector<std::uint64_t>& voxel_keys) const
{
  const auto cells_of = [all_masks = masks.data()](std::size_t i) {
    return all_masks[i];
  };
  const auto key_of = [all_keys = keys.data()](std::size_t i) { return all_keys[i]; };
  octants.assign(size(), voxelCount(), cells_of);
  octants.listKeys(voxelCount(), cells_of, key_of, voxel_keys);
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

} // namespace pcl_ext::PCL_EXT_ABI::io
