#include "voxelizing/point_blocks.h"

#include "simd/bit_operations.h"
#include "voxelizing/radix_sort.h"

#include <algorithm>
#include <array>
#include <utility>

namespace pcl_ext {
namespace io {

namespace {

constexpr std::uint64_t no_block = ~std::uint64_t{0};
constexpr std::size_t no_slot = ~std::size_t{0};

/** \brief Slots of the table per block, so that the first probe mostly succeeds. */
constexpr std::size_t slots_per_block = 8;
constexpr std::size_t smallest_table = 1024;
constexpr std::size_t largest_table = std::size_t{1} << 26;
constexpr std::size_t tries = 8;

} // namespace

PointBlocks::PointBlocks() { reset(); }

void
PointBlocks::reset()
{
  blocks_.assign(1, no_block);
  occupied_voxels_.assign(1, 0);
  slots_.resize(64);
  order_.clear();
  occupied_count_ = 0;
  fillTable();
}

void
PointBlocks::begin(const SummedFields& fields, std::size_t expected)
{
  // Copying while they grow would take most of the time of a stream's first cloud.
  constexpr std::size_t most_reserved_blocks = 16384;
  if (slots_.capacity() < 64 * std::min(expected / 16, most_reserved_blocks))
    slots_.reserve(64 * std::min(expected / 16, most_reserved_blocks));
  constexpr std::size_t blocks_that_cost_little = 256;
  if (blocks_.size() > 3 * occupied_count_ / 2 + blocks_that_cost_little)
    dropEmptyBlocks();
  // Those of a dropped block are all 0, as those of any block between two clouds.
  occupied_voxels_.resize(blocks_.size());
  fields_ = fields;
  entry_count_ = 0;
  entries_.clear();
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
    table_[findPlace(blocks_[i])] = static_cast<std::uint32_t>(i);
}

std::size_t
PointBlocks::findPlace(std::uint64_t block) const
{
  const std::size_t mask = table_.size() - 1;
  const std::size_t first_try = tableOf().firstTry(block);
  std::size_t place = first_try;
  for (std::size_t i = 1;
       i < tries && table_[place] != 0 && blocks_[table_[place]] != block;
       ++i)
    place = (first_try + i) & mask;
  return place;
}

void
PointBlocks::add(const PlacedPoints& placed)
{
  makeRoom(entry_count_ + placed.count);
  if (fields_.intensities && fields_.colours)
    sumRuns<true, true>(placed);
  else if (fields_.intensities)
    sumRuns<true, false>(placed);
  else if (fields_.colours)
    sumRuns<false, true>(placed);
  else
    sumRuns<false, false>(placed);
  addRuns();
}

template <bool has_intensities, bool has_colours>
void
PointBlocks::sumRuns(const PlacedPoints& placed)
{
  // Local variables, as stores may alias the members.
  Table table = tableOf();
  const std::uint64_t* blocks = blocks_.data();
  const std::uint32_t* slots = slots_.data();
  Run run{no_slot, 0, 0.0, 0};
  Run* next = runs_.data() - 1;
  for (std::size_t i = 0; i < placed.count; ++i) {
    std::size_t block = table.entries[table.firstTry(placed.blocks[i])];
    if (blocks[block] != placed.blocks[i]) {
      block = findOrInsert(placed.blocks[i]);
      table = tableOf();
      blocks = blocks_.data();
      slots = slots_.data();
    }
    const std::size_t slot = 64 * block + morton_order[placed.voxels[i]];
    prefetch(slots + slot);
    // Without a branch, which would be mispredicted: the run is stored at each point and
    // overwritten while it continues.
    const std::uint64_t goes_on = slot == run.slot ? 1 : 0;
    next += 1 - goes_on;
    run.slot = slot;
    run.points = (run.points & (0 - goes_on)) + 1;
    if constexpr (has_intensities)
      run.intensity = static_cast<double>(goes_on) * run.intensity +
                      static_cast<double>(placed.intensities[i]);
    if constexpr (has_colours)
      run.colours = (run.colours & (0 - goes_on)) + packColour(placed.colours[i]);
    *next = run;
  }
  run_count_ = static_cast<std::size_t>(next + 1 - runs_.data());
}

void
PointBlocks::addRuns()
{
  std::uint32_t entry_count = entry_count_;
  for (std::size_t i = 0; i < run_count_; ++i) {
    const Run& run = runs_[i];
    // Without a branch, too: a new voxel gets the next entry.
    std::uint64_t& occupied = occupied_voxels_[run.slot / 64];
    const std::uint64_t voxel = std::uint64_t{1} << run.slot % 64;
    std::uint32_t& slot = slots_[run.slot];
    const std::uint32_t is_new = (occupied & voxel) == 0 ? 1 : 0;
    const std::uint32_t entry = slot ^ ((slot ^ entry_count) & (0 - is_new));
    entry_count += is_new;
    slot = entry;
    occupied |= voxel;
    entries_.counts[entry] += static_cast<std::uint32_t>(run.points);
    if (fields_.intensities)
      entries_.intensities[entry] += run.intensity;
    if (fields_.colours)
      entries_.colours[entry].addPacked(run.colours);
  }
  entry_count_ = entry_count;
}

/** \brief Makes room for some entries; new ones are 0. */
void
PointBlocks::makeRoom(std::size_t entries)
{
  if (entries <= entries_.counts.size())
    return;
  constexpr std::size_t further_entries = 4096;
  entries_.resize(entries + further_entries, fields_);
}

std::size_t
PointBlocks::findOrInsert(std::uint64_t block)
{
  if (slots_per_block * blocks_.size() > table_.size() && table_.size() < largest_table)
    fillTable();
  std::uint32_t& entry = table_[findPlace(block)];
  if (blocks_[entry] != block) {
    entry = static_cast<std::uint32_t>(blocks_.size());
    blocks_.push_back(block);
    occupied_voxels_.push_back(0);
    slots_.resize(64 * blocks_.size());
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
PointBlocks::writeVoxels(std::vector<std::uint64_t>& keys, VoxelSums& sums)
{
  sortNewBlocks();
  const std::size_t voxels = entry_count_ - uniteParts();
  keys.resize(voxels);
  sums.resize(voxels, fields_);
  entry_of_.resize(voxels);
  occupied_.resize(std::max(occupied_.size(), order_.size()));
  occupied_count_ = 0;
  std::size_t voxel = 0;
  for (const KeyedBlock& block : order_) {
    // Without a branch, which would be mispredicted: always written, counted if occupied.
    std::uint64_t occupied = std::exchange(occupied_voxels_[block.block], 0);
    occupied_[occupied_count_] = block;
    occupied_count_ += occupied != 0 ? 1 : 0;
    const std::uint32_t* const slots = &slots_[64 * std::size_t{block.block}];
    for (; occupied != 0; occupied &= occupied - 1) {
      const unsigned int in_block = lowestBit(occupied);
      keys[voxel] = block.key << 6 | in_block;
      entry_of_[voxel++] = slots[in_block];
    }
  }
  for (voxel = 0; voxel < voxels; ++voxel)
    sums.counts[voxel] = entries_.counts[entry_of_[voxel]];
  for (voxel = 0; fields_.intensities && voxel < voxels; ++voxel)
    sums.intensities[voxel] = entries_.intensities[entry_of_[voxel]];
  for (voxel = 0; fields_.colours && voxel < voxels; ++voxel)
    sums.colours[voxel] = entries_.colours[entry_of_[voxel]];
}

/** \brief Unites the parts of blocks. Returns how many entries of voxels are united with
 * others. */
std::size_t
PointBlocks::uniteParts()
{
  std::size_t united = 0;
  std::size_t first = 0; // of the parts
  for (std::size_t i = 1; i < order_.size(); ++i)
    if (order_[i].key != order_[first].key)
      first = i;
    else
      united += unite(order_[first].block, order_[i].block);
  return united;
}

/** \brief Moves the points of a block to another one; returns how many voxels are in both. */
std::size_t
PointBlocks::unite(std::size_t block, std::size_t part)
{
  std::uint64_t& occupied = occupied_voxels_[block];
  std::uint64_t occupied_in_part = std::exchange(occupied_voxels_[part], 0);
  const std::uint64_t in_both = occupied & occupied_in_part;
  occupied |= occupied_in_part;
  for (; occupied_in_part != 0; occupied_in_part &= occupied_in_part - 1) {
    const unsigned int voxel = lowestBit(occupied_in_part);
    std::uint32_t& to = slots_[64 * block + voxel];
    const std::uint32_t from = slots_[64 * part + voxel];
    if ((in_both >> voxel & 1) != 0)
      entries_.add(to, from);
    else
      to = from;
  }
  return bitCount(in_both);
}

} // namespace io
} // namespace pcl_ext
