#include "voxelizing/point_blocks.h"

#include "bytes/reserve_ahead.h"
#include "simd/bit_operations.h"
#include "simd/lanes.h"
#include "voxelizing/radix_sort.h"

#include <algorithm>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::uint64_t no_block = ~std::uint64_t{0};

/** \brief Slots of the table per block, so that the first probe mostly succeeds. */
constexpr std::size_t slots_per_block = 8;
constexpr std::size_t smallest_table = 1024;
constexpr std::size_t largest_table = std::size_t{1} << 26;
constexpr std::size_t tries = 8;

/** \brief Bit i is set if byte i of 64 is not 0. */
std::uint64_t
nonZeroBytes(const std::uint8_t* bytes)
{
  std::uint64_t bits = 0;
  for (unsigned int i = 0; i < 64; i += 16)
    bits |= std::uint64_t{NativeLanes::nonZeroBytes(bytes + i)} << i;
  return bits;
}

} // namespace

PointBlocks::PointBlocks() { reset(); }

void
PointBlocks::reset()
{
  blocks_.assign(1, no_block);
  order_.clear();
  occupied_count_ = 0;
  fillTable();
  clear();
}

void
PointBlocks::clear(std::size_t expected, bool /*keeps_handles*/, bool keeps_colours)
{
  coloured_points_.clear();
  if (keeps_colours)
    reserveAhead(coloured_points_, expected);
  constexpr std::size_t blocks_that_cost_little = 256;
  if (blocks_.size() > 3 * occupied_count_ / 2 + blocks_that_cost_little)
    dropEmptyBlocks();
  else if (slots_per_block * blocks_.size() > 2 * table_.size())
    fillTable();
  voxels_.resize(64 * blocks_.size());
  std::fill(voxels_.begin(), voxels_.end(), std::uint8_t{0});
  further_points_.clear();
}

bool
PointBlocks::areTooSparse(std::size_t points) const
{
  constexpr std::size_t blocks_that_cost_little = 1024;
  const std::size_t new_blocks = blocks_.size() - 1 - order_.size();
  return new_blocks > points / 2 + blocks_that_cost_little;
}

void
PointBlocks::dropEmptyBlocks()
{
  order_.clear();
  kept_blocks_.assign(1, no_block);
  for (std::size_t i = 0; i < occupied_count_; ++i) {
    const auto kept = static_cast<std::uint32_t>(i + 1);
    order_.push_back({occupied_[i].key, kept});
    kept_blocks_.push_back(blocks_[occupied_[i].block]);
    occupied_[i].block = kept;
  }
  blocks_.swap(kept_blocks_);
  fillTable();
}

void
PointBlocks::fillTable()
{
  std::size_t size = smallest_table;
  unsigned int bits = 10;
  for (; size < largest_table && size < slots_per_block * blocks_.size(); size *= 2)
    ++bits;
  table_.assign(size, 0);
  hash_shift_ = 64 - bits;
  for (std::size_t i = 1; i < blocks_.size(); ++i)
    table_[findPlace(blocks_[i], firstTry(blocks_[i]))] = static_cast<std::uint32_t>(i);
}

std::size_t
PointBlocks::findPlace(std::uint64_t block, std::size_t first_try) const
{
  const std::size_t mask = table_.size() - 1;
  std::size_t place = first_try;
  for (std::size_t i = 1;
       i < tries && table_[place] != 0 && blocks_[table_[place]] != block;
       ++i)
    place = (first_try + i) & mask;
  return place;
}

void
PointBlocks::add(const PlacedPoints& placed, std::size_t* added)
{
  // Local variables, as stores to bytes may alias the members.
  const std::uint32_t* table = table_.data();
  const std::uint64_t* blocks = blocks_.data();
  std::uint8_t* voxels = voxels_.data();
  for (std::size_t i = 0; i < placed.count; ++i) {
    const std::size_t first_try = firstTry(placed.blocks[i]);
    std::size_t block = table[first_try];
    if (blocks[block] != placed.blocks[i]) {
      block = findOrInsert(placed.blocks[i], first_try);
      blocks = blocks_.data();
      voxels = voxels_.data();
    }
    const std::size_t voxel = 64 * block + morton_order[placed.voxels[i]];
    added[i] = voxel;
    if (voxels[voxel] != most_in_a_byte)
      ++voxels[voxel];
    else
      further_points_.push_back(voxel);
  }
}

void
PointBlocks::addColours(const std::uint32_t* colours,
                        const std::size_t* added,
                        std::size_t count)
{
  const std::size_t first = coloured_points_.size();
  coloured_points_.resize(first + count);
  for (std::size_t i = 0; i < count; ++i)
    coloured_points_[first + i] = {added[i], colours[i]};
}

std::size_t
PointBlocks::findOrInsert(std::uint64_t block, std::size_t first_try)
{
  std::uint32_t& entry = table_[findPlace(block, first_try)];
  if (blocks_[entry] != block) {
    entry = static_cast<std::uint32_t>(blocks_.size());
    blocks_.push_back(block);
    voxels_.resize(voxels_.size() + 64);
  }
  return entry;
}

void
PointBlocks::sortNewBlocks()
{
  new_blocks_.clear();
  for (std::size_t i = order_.size() + 1; i < blocks_.size(); ++i)
    new_blocks_.push_back(
        {mortonKeyOfBlock(blocks_[i]), static_cast<std::uint32_t>(i)});
  if (new_blocks_.empty())
    return;
  radixSort(new_blocks_, spare_blocks_, usedBits(new_blocks_));
  spare_blocks_.resize(blocks_.size() - 1);
  std::merge(order_.begin(),
             order_.end(),
             new_blocks_.begin(),
             new_blocks_.end(),
             spare_blocks_.begin(),
             [](const KeyedBlock& first, const KeyedBlock& second) {
               return first.key < second.key;
             });
  order_.swap(spare_blocks_);
}

void
PointBlocks::writeVoxels(std::vector<std::uint64_t>& keys,
                         std::vector<std::uint32_t>& counts)
{
  sortNewBlocks();
  voxel_count_ = findOccupied();
  keys.resize(voxel_count_);
  counts.resize(voxel_count_);
  for (std::size_t i = 0; i < occupied_count_; ++i) {
    const std::size_t first_voxel = first_voxels_[occupied_[i].block];
    writeBlock(occupied_[i], &keys[first_voxel], &counts[first_voxel]);
  }
  for (const auto& [part, united] : parts_)
    std::copy_n(
        &voxels_[64 * std::size_t{united}], 64, &voxels_[64 * std::size_t{part}]);
  for (const std::size_t point : further_points_)
    ++counts[voxelOf(point)];
}

std::size_t
PointBlocks::findOccupied()
{
  uniteParts();
  first_voxels_.resize(blocks_.size());
  if (occupied_.size() < order_.size())
    occupied_.resize(order_.size());
  occupied_count_ = 0;
  std::size_t voxels = 0;
  for (const KeyedBlock& keyed : order_) {
    const std::uint64_t occupied =
        nonZeroBytes(&voxels_[64 * std::size_t{keyed.block}]);
    first_voxels_[keyed.block] = voxels;
    voxels += bitCount(occupied);
    // Without a branch, which would be mispredicted: always written, counted if occupied.
    occupied_[occupied_count_] = {keyed.key, occupied, keyed.block};
    occupied_count_ += occupied != 0 ? 1 : 0;
  }
  for (const auto& [part, united] : parts_)
    first_voxels_[part] = first_voxels_[united];
  return voxels;
}

void
PointBlocks::uniteParts()
{
  parts_.clear();
  for (std::size_t i = 1; i < order_.size(); ++i) {
    if (order_[i].key != order_[i - 1].key)
      continue;
    // Third and further parts are united with the first one, too.
    const bool goes_on = !parts_.empty() && parts_.back().first == order_[i - 1].block;
    const std::uint32_t first = goes_on ? parts_.back().second : order_[i - 1].block;
    parts_.emplace_back(order_[i].block, first);
    std::uint8_t* const united = &voxels_[64 * std::size_t{first}];
    std::uint8_t* const part = &voxels_[64 * std::size_t{order_[i].block}];
    for (std::size_t voxel = 0; voxel < 64; ++voxel) {
      const unsigned int sum = united[voxel] + unsigned{part[voxel]};
      united[voxel] =
          static_cast<std::uint8_t>(std::min(sum, unsigned{most_in_a_byte}));
      part[voxel] = 0;
      for (unsigned int further = united[voxel]; further < sum; ++further)
        further_points_.push_back(64 * std::size_t{first} + voxel);
    }
  }
}

void
PointBlocks::writeBlock(const OccupiedBlock& block,
                        std::uint64_t* keys,
                        std::uint32_t* counts)
{
  std::uint8_t* const voxels = &voxels_[64 * std::size_t{block.block}];
  std::uint8_t rank = 0;
  for (std::uint64_t occupied = block.occupied; occupied != 0;
       occupied &= occupied - 1) {
    const unsigned int voxel = lowestBit(occupied);
    *keys++ = block.key << 6 | voxel;
    *counts++ = voxels[voxel];
    voxels[voxel] = rank++;
  }
}

} // namespace io
} // namespace pcl_ext
