// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/point_blocks.h"

#include "bytes/reserve_ahead.h"
#include "simd/bit_operations.h"
#include "simd/lanes.h"
#include "voxels/radix_sort.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::uint64_t no_block = ~std::uint64_t{0};
constexpr std::size_t no_slot = ~std::size_t{0};

/** \brief Slots of the table per block, so that the first probe mostly succeeds. */
constexpr std::size_t slots_per_block = 8;
constexpr std::size_t smallest_table = 1024;
constexpr std::size_t largest_table = std::size_t{1} << 26;
constexpr std::size_t tries = 8;

/** \brief Runs of dense clouds that are kept in the order of the points. Few more fit
 * the caches. */
constexpr std::size_t runs_in_cache = std::size_t{1} << 16;

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
  slot_intensities_.clear();
  slot_colours_.clear();
  fillTable();
}

void
PointBlocks::begin(const SummedFields& fields)
{
  constexpr std::size_t blocks_that_cost_little = 256;
  if (blocks_.size() > 3 * occupied_count_ / 2 + blocks_that_cost_little)
    dropEmptyBlocks();
  counts_.resize(64 * blocks_.size());
  std::fill(counts_.begin(), counts_.end(), std::uint8_t{0});
  fields_ = fields;
  full_slots_.clear();
  run_count_ = 0;
  has_slot_sums_ = false;
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
    table_[findSlot(blocks_[i])] = static_cast<std::uint32_t>(i);
}

std::size_t
PointBlocks::findSlot(std::uint64_t block) const
{
  const std::size_t mask = table_.size() - 1;
  const std::size_t first_try = tableOf().firstTry(block);
  std::size_t slot = first_try;
  for (std::size_t i = 1;
       i < tries && table_[slot] != 0 && blocks_[table_[slot]] != block;
       ++i)
    slot = (first_try + i) & mask;
  return slot;
}

void
PointBlocks::add(const LocatedPoints& located)
{
  if (fields_.intensities || fields_.colours)
    makeRoomForRuns(located.count);
  if (fields_.intensities && fields_.colours)
    addFields<true, true>(located);
  else if (fields_.intensities)
    addFields<true, false>(located);
  else if (fields_.colours)
    addFields<false, true>(located);
  else
    addFields<false, false>(located);
}

template <bool has_intensities, bool has_colours>
void
PointBlocks::addFields(const LocatedPoints& located)
{
  // Local variables, as stores may alias the members.
  Table table = tableOf();
  const std::uint64_t* blocks = blocks_.data();
  std::uint8_t* counts = counts_.data();
  Run run{no_slot, 0.0, 0};
  Run* next = runs_.data() + run_count_;
  for (std::size_t i = 0; i < located.count; ++i) {
    std::size_t block = table.entries[table.firstTry(located.blocks[i])];
    if (blocks[block] != located.blocks[i]) {
      block = findOrInsert(located.blocks[i]);
      table = tableOf();
      blocks = blocks_.data();
      counts = counts_.data();
    }
    const std::size_t slot = 64 * block + morton_order[located.voxels[i]];
    if (counts[slot] == most_in_a_slot) {
      full_slots_.push_back(slot);
      counts[slot] = 0;
    }
    ++counts[slot];
    if constexpr (has_intensities || has_colours) {
      // Without a branch, which would be mispredicted: the run is stored at each point
      // and overwritten while it continues.
      const std::uint64_t goes_on = slot == run.slot ? 1 : 0;
      next += run.slot == no_slot ? 0 : 1 - goes_on;
      run.slot = slot;
      if constexpr (has_intensities)
        run.intensity = static_cast<double>(goes_on) * run.intensity +
                        static_cast<double>(located.intensities[i]);
      if constexpr (has_colours)
        run.colours = (run.colours & (0 - goes_on)) + packColour(located.colours[i]);
      *next = run;
    }
  }
  if ((has_intensities || has_colours) && located.count > 0)
    run_count_ = static_cast<std::size_t>(next + 1 - runs_.data());
}

/** \brief Makes room for some runs, of which there is one a point at most. */
void
PointBlocks::makeRoomForRuns(std::size_t count)
{
  if (run_count_ + count <= runs_.size())
    return;
  const std::size_t bytes_per_slot = (fields_.intensities ? sizeof(double) : 0) +
                                     (fields_.colours ? sizeof(ColourSum) : 0);
  // Where there are few points in a block, slots would take more memory than runs.
  const bool is_dense = counts_.size() * bytes_per_slot <= runs_.size() * sizeof(Run);
  if (runs_.size() >= runs_in_cache && (has_slot_sums_ || is_dense))
    sumRunsBySlot();
  else
    runs_.resize(std::max(2 * runs_.size(), run_count_ + count));
}

void
PointBlocks::sumRunsBySlot()
{
  has_slot_sums_ = true;
  if (fields_.intensities) {
    slot_intensities_.resize(counts_.size());
    for (std::size_t i = 0; i < run_count_; ++i)
      slot_intensities_[runs_[i].slot] += runs_[i].intensity;
  }
  if (fields_.colours) {
    slot_colours_.resize(counts_.size());
    for (std::size_t i = 0; i < run_count_; ++i)
      slot_colours_[runs_[i].slot].addPacked(runs_[i].colours);
  }
  run_count_ = 0;
}

std::size_t
PointBlocks::findOrInsert(std::uint64_t block)
{
  if (slots_per_block * blocks_.size() > table_.size() && table_.size() < largest_table)
    fillTable();
  std::uint32_t& entry = table_[findSlot(block)];
  if (blocks_[entry] != block) {
    entry = static_cast<std::uint32_t>(blocks_.size());
    blocks_.push_back(block);
    counts_.resize(64 * blocks_.size());
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
  reserveAhead(spare_blocks_, blocks_.size());
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
  uniteParts();
  const std::size_t voxels = findOccupied();
  keys.resize(voxels);
  sums.resize(voxels, fields_);
  for (std::size_t i = 0; i < occupied_count_; ++i)
    writeBlock(occupied_[i], keys, sums);
  for (const auto& [part, united] : parts_) {
    written_[part] = written_[united];
    std::copy_n(
        &counts_[64 * std::size_t{united}], 64, &counts_[64 * std::size_t{part}]);
  }
  for (const std::size_t slot : full_slots_)
    sums.counts[voxelOf(slot)] += most_in_a_slot;
  writeSums(sums);
}

/** \brief Voxel of a slot, in their order, once its counts are ranks. */
inline std::size_t
PointBlocks::voxelOf(std::size_t slot) const
{
  return written_[slot / 64].first_voxel + counts_[slot];
}

std::size_t
PointBlocks::findOccupied()
{
  written_.resize(blocks_.size());
  if (occupied_.size() < order_.size())
    occupied_.resize(order_.size());
  occupied_count_ = 0;
  std::size_t voxels = 0;
  for (const KeyedBlock& block : order_) {
    const std::uint64_t occupied =
        nonZeroBytes(&counts_[64 * std::size_t{block.block}]);
    written_[block.block] = {occupied, voxels};
    voxels += bitCount(occupied);
    // Without a branch, which would be mispredicted: always written, counted if
    // occupied.
    occupied_[occupied_count_] = block;
    occupied_count_ += occupied != 0 ? 1 : 0;
  }
  return voxels;
}

/** \brief Writes keys and counts; the counts become the ranks of voxels in their
 * block. */
void
PointBlocks::writeBlock(const KeyedBlock& block,
                        std::vector<std::uint64_t>& keys,
                        VoxelSums& sums)
{
  std::uint8_t* const counts = &counts_[64 * std::size_t{block.block}];
  std::size_t voxel = written_[block.block].first_voxel;
  std::uint8_t rank = 0;
  for (std::uint64_t left = written_[block.block].occupied; left != 0;
       left &= left - 1) {
    const unsigned int cell = lowestBit(left);
    keys[voxel] = block.key << 6 | cell;
    sums.counts[voxel++] = counts[cell];
    counts[cell] = rank++;
  }
}

/** \brief Writes the sums of the runs, in the order of their points, as the order
 * affects rounding. */
void
PointBlocks::writeSums(VoxelSums& sums)
{
  std::fill(sums.intensities.begin(), sums.intensities.end(), 0.0);
  std::fill(sums.colours.begin(), sums.colours.end(), ColourSum());
  for (std::size_t i = 1; has_slot_sums_ && i < blocks_.size(); ++i)
    takeSlotSums(i, sums);
  if (fields_.intensities)
    for (std::size_t i = 0; i < run_count_; ++i)
      sums.intensities[voxelOf(runs_[i].slot)] += runs_[i].intensity;
  if (fields_.colours)
    for (std::size_t i = 0; i < run_count_; ++i)
      sums.colours[voxelOf(runs_[i].slot)].addPacked(runs_[i].colours);
}

/** \brief Adds the sums in the slots of a block to those of its voxels, and clears
 * them. */
void
PointBlocks::takeSlotSums(std::size_t block, VoxelSums& sums)
{
  const WrittenBlock& written = written_[block];
  std::size_t voxel = written.first_voxel;
  for (std::uint64_t left = written.occupied; left != 0; left &= left - 1, ++voxel) {
    const std::size_t slot = 64 * block + lowestBit(left);
    if (fields_.intensities && slot < slot_intensities_.size())
      sums.intensities[voxel] += std::exchange(slot_intensities_[slot], 0.0);
    if (fields_.colours && slot < slot_colours_.size())
      sums.colours[voxel].add(std::exchange(slot_colours_[slot], ColourSum()));
  }
}

void
PointBlocks::uniteParts()
{
  parts_.clear();
  std::size_t first = 0; // of the parts
  for (std::size_t i = 1; i < order_.size(); ++i)
    if (order_[i].key != order_[first].key)
      first = i;
    else
      unite(order_[first].block, order_[i].block);
}

/** \brief Moves the counts of a block to another one. */
void
PointBlocks::unite(std::size_t block, std::size_t part)
{
  parts_.emplace_back(static_cast<std::uint32_t>(part),
                      static_cast<std::uint32_t>(block));
  for (std::size_t voxel = 0; voxel < 64; ++voxel) {
    std::uint8_t& count = counts_[64 * block + voxel];
    const std::uint8_t in_part = std::exchange(counts_[64 * part + voxel], 0);
    const unsigned int sum = count + unsigned{in_part};
    if (sum > most_in_a_slot)
      full_slots_.push_back(64 * block + voxel);
    count =
        static_cast<std::uint8_t>(sum > most_in_a_slot ? sum - most_in_a_slot : sum);
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io
