// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/summed_voxels.h"

#include "bytes/reserve_ahead.h"
#include "platforms/run_at_once.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/radix_sort.h"

#include <algorithm>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::nodes {

namespace {

/** \brief The sum of two numbers without overflow, which would be undefined. */
std::int64_t
sumOf(std::int64_t one, std::int64_t other)
{
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(one) +
                                   static_cast<std::uint64_t>(other));
}

/** \brief Sets a block's values, with memory for some more, but not for many. */
template <typename ValueT>
void
keep(const ValueT* values, std::size_t count, std::vector<ValueT>& of_block)
{
  constexpr std::size_t most_times = 4;
  constexpr std::size_t few = 4;
  if (of_block.capacity() < count || of_block.capacity() > most_times * count + few) {
    of_block = std::vector<ValueT>();
    of_block.reserve(count + count / 4);
  }
  of_block.assign(values, values + count);
}

/** \brief Divides blocks among threads, so that each has about as many runs.
 * \return for each thread the key of the first block behind its own */
std::vector<std::uint64_t>
dividedBlocks(const std::vector<const VoxelUpdates*>& of_streams, std::size_t threads)
{
  std::size_t runs = 0;
  for (const VoxelUpdates* updates : of_streams)
    runs += updates->runs.size();
  constexpr std::size_t few = 1024; // hardly worth a thread
  const std::size_t count = std::min(threads, 1 + runs / few);
  std::vector<std::uint64_t> ends(count, ~std::uint64_t{0});
  if (count == 1)
    return ends;
  constexpr std::size_t step = 61; // one of as many runs tells where they are
  std::vector<std::uint64_t> sample;
  std::size_t next = 0;
  for (const VoxelUpdates* updates : of_streams) {
    for (; next < updates->runs.size(); next += step)
      sample.push_back(updates->runs[next].key);
    next -= updates->runs.size();
  }
  std::sort(sample.begin(), sample.end());
  for (std::size_t i = 0; i + 1 < count; ++i)
    ends[i] = sample[sample.size() * (i + 1) / count];
  return ends;
}

} // namespace

void
SummedVoxels::Additions::add(const VoxelUpdate& update)
{
  const std::size_t cell = update.cell;
  Addition& addition = additions_[cell];
  addition.intensity = sumOf(addition.intensity, update.intensity);
  // An integer of two's complement: less than nothing is added as well.
  const auto summands = static_cast<std::uint32_t>(update.summands);
  addition.summands += summands;
  ++updates_;
  touched_[cell / 64] |= std::uint64_t{1} << cell % 64;
  touched_words_ |= std::uint64_t{1} << cell / 64;
  if (!update.has_colour)
    return;
  SummedColour& colour = colours_[cell];
  colour.summands += summands;
  colour.channels[0] += summands * update.colour.r;
  colour.channels[1] += summands * update.colour.g;
  colour.channels[2] += summands * update.colour.b;
}

void
SummedVoxels::Block::prefetch() const
{
  constexpr std::size_t sums_of_line = 4;
  for (std::size_t i = 0; i < sums.size(); i += sums_of_line)
    pcl_ext::prefetch(sums.data() + i);
}

/** \brief Makes room for the voxels of a block and for what is added. */
void
SummedVoxels::Additions::makeRoom(Block& block)
{
  const std::size_t most =
      std::min(block.sums.size() + std::exchange(updates_, 0), cells) + 1;
  io::ensureSize(sums_after_, most);
  if (colours_.empty())
    return;
  io::ensureSize(colours_after_, most);
  block.colours.resize(block.sums.size());
}

/** \brief Copies a voxel that does not change. */
void
SummedVoxels::Additions::copy(const Block& block, std::size_t voxel, std::size_t& count)
{
  sums_after_[count] = block.sums[voxel];
  if (!colours_.empty())
    colours_after_[count] = block.colours[voxel];
  ++count;
}

void
SummedVoxels::Additions::moveTo(Block& block, ChangedSums* changes)
{
  makeRoom(block);
  const bool has_colours = !colours_.empty();
  const std::uint64_t first_key = block.key << VoxelUpdates::block_bits;
  const std::size_t end = block.sums.size();
  std::size_t voxel = 0;
  std::size_t count = 0;
  for (; touched_words_ != 0; touched_words_ &= touched_words_ - 1) {
    const std::size_t word = lowestBit(touched_words_);
    for (std::uint64_t left = std::exchange(touched_[word], 0); left != 0;
         left &= left - 1) {
      const std::size_t cell = 64 * word + lowestBit(left);
      while (voxel < end && block.sums[voxel].cell < cell)
        copy(block, voxel++, count);
      const bool was_there = voxel < end && block.sums[voxel].cell == cell;
      const Sum before = was_there ? block.sums[voxel] : Sum{};
      const Addition added = std::exchange(additions_[cell], Addition());
      const Sum after{sumOf(before.intensity, added.intensity),
                      before.summands + added.summands,
                      static_cast<std::uint16_t>(cell)};
      // Written in any case: a voxel without summands is overwritten by the next one.
      sums_after_[count] = after;
      if (has_colours) {
        colours_after_[count] = std::exchange(colours_[cell], SummedColour());
        if (was_there)
          colours_after_[count].add(block.colours[voxel]);
      }
      const bool is_there = after.summands != 0;
      count += is_there ? 1 : 0;
      voxel += was_there ? 1 : 0;
      if (changes != nullptr &&
          (was_there != is_there || after.intensity != before.intensity))
        changes->append(
            {first_key + cell, before.intensity, after.intensity, was_there, is_there});
    }
  }
  while (voxel < end)
    copy(block, voxel++, count);
  keep(sums_after_.data(), count, block.sums);
  if (has_colours)
    keep(colours_after_.data(), count, block.colours);
}

void
SummedVoxels::clear() noexcept
{
  blocks_ = std::vector<Block>();
  spare_blocks_ = std::vector<Block>();
  size_ = 0;
  has_colours_ = false;
  parts_ = std::vector<Part>();
  changes_ = std::vector<ChangedSums>();
}

void
SummedVoxels::add(const std::vector<const VoxelUpdates*>& of_streams,
                  bool lists_changes)
{
  const std::vector<std::uint64_t> ends = dividedBlocks(of_streams, threads_);
  const std::size_t count = ends.size();
  parts_.resize(std::max(parts_.size(), count));
  changes_.resize(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    changes_[i].clear();
    std::swap(changes_[i], parts_[i].changes); // its memory
  }
  for (const VoxelUpdates* updates : of_streams)
    has_colours_ |= updates->has_colours;
  io::runAtOnce(count, [&](std::size_t i) {
    addPart(of_streams, {i == 0 ? 0 : ends[i - 1], ends[i]}, lists_changes, parts_[i]);
  });
  joinParts(count);
}

/** \brief Lists the runs in a range of blocks by their blocks. */
void
SummedVoxels::gatherRuns(const std::vector<const VoxelUpdates*>& of_streams,
                         const KeyRange& range,
                         Part& part)
{
  part.runs.clear();
  for (std::size_t stream = 0; stream < of_streams.size(); ++stream)
    for (const VoxelUpdates::Run& run : of_streams[stream]->runs)
      if (run.key >= range.begin && run.key < range.end)
        part.runs.emplace_back(run).stream = static_cast<std::uint32_t>(stream);
  io::radixSort(part.runs, part.spare_runs, io::usedBits(part.runs));
}

/** \brief Sums the updates of a range of blocks. */
void
SummedVoxels::addPart(const std::vector<const VoxelUpdates*>& of_streams,
                      const KeyRange& range,
                      bool lists_changes,
                      Part& part)
{
  gatherRuns(of_streams, range, part);
  part.new_blocks.clear();
  part.came = 0;
  part.went = 0;
  part.has_empty_blocks = false;
  if (has_colours_)
    part.additions.addColours();
  const Runs& runs = part.runs;
  io::AscendingLookup<Block> known(blocks_);
  for (std::size_t i = 0; i < runs.size();) {
    const std::uint64_t key = runs[i].key;
    const std::size_t number = known.find(key);
    Block& block = number != io::not_in_list
                       ? blocks_[number]
                       : part.new_blocks.emplace_back(Block{key, {}, {}});
    block.prefetch();
    for (; i < runs.size() && runs[i].key == key; ++i) {
      const std::vector<VoxelUpdate>& updates = of_streams[runs[i].stream]->updates;
      for (std::size_t j = runs[i].begin; j < runs[i].end; ++j)
        part.additions.add(updates[j]);
    }
    part.went += block.sums.size();
    part.additions.moveTo(block, lists_changes ? &part.changes : nullptr);
    part.came += block.sums.size();
    part.has_empty_blocks |= block.sums.empty();
  }
}

/** \brief Takes what the parts found. */
void
SummedVoxels::joinParts(std::size_t count)
{
  bool are_other_blocks = false;
  for (std::size_t i = 0; i < count; ++i) {
    Part& part = parts_[i];
    size_ += part.came - part.went;
    are_other_blocks |= part.has_empty_blocks || !part.new_blocks.empty();
  }
  for (std::size_t i = 0; i < parts_.size(); ++i)
    std::swap(changes_[i], parts_[i].changes);
  if (are_other_blocks)
    updateBlocks(count);
}

/** \brief Adds the new blocks of parts, and drops those without voxels. */
void
SummedVoxels::updateBlocks(std::size_t parts)
{
  spare_blocks_.clear();
  const auto append = [&](Block& block) {
    if (!block.sums.empty())
      spare_blocks_.push_back(std::move(block));
  };
  std::size_t old = 0;
  for (std::size_t i = 0; i < parts; ++i)
    for (Block& block : parts_[i].new_blocks) {
      for (; old < blocks_.size() && blocks_[old].key < block.key; ++old)
        append(blocks_[old]);
      append(block);
    }
  for (; old < blocks_.size(); ++old)
    append(blocks_[old]);
  blocks_.swap(spare_blocks_);
  spare_blocks_.clear();
  for (std::size_t i = 0; i < parts; ++i)
    parts_[i].new_blocks.clear();
}

bool
SummedVoxels::hasAnyBetween(std::uint64_t begin, std::uint64_t end) const
{
  const std::uint64_t first_block = begin >> VoxelUpdates::block_bits;
  auto block = std::lower_bound(
      blocks_.begin(),
      blocks_.end(),
      first_block,
      [](const Block& one, std::uint64_t key) { return one.key < key; });
  for (; block != blocks_.end(); ++block) {
    const std::uint64_t first_key = block->key << VoxelUpdates::block_bits;
    for (const Sum& sum : block->sums)
      if (first_key + sum.cell >= begin)
        return first_key + sum.cell < end;
  }
  return false;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
