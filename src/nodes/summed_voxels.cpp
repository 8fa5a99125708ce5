// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/summed_voxels.h"

#include "platforms/run_at_once.h"
#include "simd/bit_operations.h"
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

} // namespace

void
SummedVoxels::Sums::reserve(std::size_t further, bool has_colours)
{
  const std::size_t needed = size + further;
  // Doubled, as vectors are, but with elements that can be written.
  const auto reserve_in = [needed](auto& values) {
    if (values.size() < needed)
      values.resize(std::max(needed, 2 * values.size()));
  };
  reserve_in(keys);
  reserve_in(intensities);
  reserve_in(summands);
  if (has_colours)
    reserve_in(colours);
}

void
SummedVoxels::Sums::append(const Sums& other,
                           std::size_t begin,
                           std::size_t end,
                           bool has_colours)
{
  if (begin == end)
    return;
  reserve(end - begin, has_colours);
  const auto append_to = [&](auto& values, const auto& from) {
    std::copy(from.data() + begin, from.data() + end, values.data() + size);
  };
  append_to(keys, other.keys);
  append_to(intensities, other.intensities);
  append_to(summands, other.summands);
  if (has_colours)
    append_to(colours, other.colours);
  size += end - begin;
}

void
SummedVoxels::Sums::copy(const Sums& other, std::size_t voxel, bool has_colours)
{
  keys[size] = other.keys[voxel];
  intensities[size] = other.intensities[voxel];
  summands[size] = other.summands[voxel];
  if (has_colours)
    colours[size] = other.colours[voxel];
  ++size;
}

void
SummedVoxels::BlockSums::add(const VoxelUpdate& update)
{
  const std::size_t cell = update.cell;
  intensities_[cell] = sumOf(intensities_[cell], update.intensity);
  // An integer of two's complement: less than nothing is added as well.
  const auto summands = static_cast<std::uint32_t>(update.summands);
  summands_[cell] += summands;
  touched_[cell / 64] |= std::uint64_t{1} << cell % 64;
  if (!update.has_colour)
    return;
  SummedColour& colour = colours_[cell];
  colour.summands += summands;
  colour.channels[0] += summands * update.colour.r;
  colour.channels[1] += summands * update.colour.g;
  colour.channels[2] += summands * update.colour.b;
}

void
SummedVoxels::BlockSums::moveTo(std::uint64_t block_key,
                                const Sums& before,
                                std::size_t begin,
                                std::size_t end,
                                Sums& sums)
{
  const bool has_colours = !colours_.empty();
  const std::uint64_t first_key = block_key << VoxelUpdates::block_bits;
  std::size_t voxel = begin;
  for (std::size_t i = 0; i < touched_.size(); ++i)
    for (std::uint64_t left = std::exchange(touched_[i], 0); left != 0;
         left &= left - 1) {
      const std::size_t cell = 64 * i + lowestBit(left);
      const std::uint64_t key = first_key + cell;
      while (voxel < end && before.keys[voxel] < key)
        sums.copy(before, voxel++, has_colours);
      std::int64_t intensity = std::exchange(intensities_[cell], 0);
      std::uint32_t summands = std::exchange(summands_[cell], 0);
      if (has_colours)
        sums.colours[sums.size] = std::exchange(colours_[cell], SummedColour());
      if (voxel < end && before.keys[voxel] == key) {
        intensity = sumOf(intensity, before.intensities[voxel]);
        summands += before.summands[voxel];
        if (has_colours)
          sums.colours[sums.size].add(before.colours[voxel]);
        ++voxel;
      }
      // Written in any case: a voxel without summands is overwritten by the next one.
      sums.keys[sums.size] = key;
      sums.intensities[sums.size] = intensity;
      sums.summands[sums.size] = summands;
      sums.size += summands != 0 ? 1 : 0;
    }
  while (voxel < end)
    sums.copy(before, voxel++, has_colours);
}

void
SummedVoxels::clear() noexcept
{
  sums_ = Sums();
  has_colours_ = false;
  runs_ = Runs();
  spare_runs_ = Runs();
  parts_ = std::vector<Part>();
}

void
SummedVoxels::add(const std::vector<const VoxelUpdates*>& of_streams)
{
  gatherRuns(of_streams);
  sums_.reserve(0, has_colours_);
  constexpr std::size_t few = 1024; // hardly worth a thread
  const std::size_t count = std::min(threads_, 1 + runs_.size() / few);
  parts_.resize(std::max(parts_.size(), count));
  std::vector<Place> begins;
  for (std::size_t i = 0; i <= count; ++i)
    begins.push_back(beginOf(i, count));
  io::runAtOnce(count, [&](std::size_t i) {
    addPart(of_streams, begins[i], begins[i + 1], parts_[i]);
  });
  joinParts(count);
}

/** \brief Lists the runs of all updates by their blocks. */
void
SummedVoxels::gatherRuns(const std::vector<const VoxelUpdates*>& of_streams)
{
  runs_.clear();
  for (std::size_t stream = 0; stream < of_streams.size(); ++stream) {
    const VoxelUpdates& updates = *of_streams[stream];
    has_colours_ |= updates.has_colours;
    for (VoxelUpdates::Run run : updates.runs) {
      run.stream = static_cast<std::uint32_t>(stream);
      runs_.push_back(run);
    }
  }
  io::radixSort(runs_, spare_runs_, io::usedBits(runs_));
}

/** \brief Where a part begins: at the first run of a block, and the voxels of that. Parts
 * have about the same sum of runs and of voxels, each as a share of all. */
SummedVoxels::Place
SummedVoxels::beginOf(std::size_t part, std::size_t count) const
{
  if (part == 0)
    return {0, 0};
  const double runs = static_cast<double>(runs_.size());
  const double voxels = static_cast<double>(std::max<std::size_t>(size(), 1));
  const double before = 2.0 * static_cast<double>(part) / static_cast<double>(count);
  std::size_t run = part == count ? runs_.size() : 0;
  std::size_t end = runs_.size();
  while (run < end) {
    const std::size_t middle = run + (end - run) / 2;
    const auto voxel = static_cast<double>(firstOfBlock(runs_[middle].key));
    if (static_cast<double>(middle) / runs + voxel / voxels < before)
      run = middle + 1;
    else
      end = middle;
  }
  while (run > 0 && run < runs_.size() && runs_[run].key == runs_[run - 1].key)
    ++run;
  return {run, run == runs_.size() ? size() : firstOfBlock(runs_[run].key)};
}

std::size_t
SummedVoxels::firstOfBlock(std::uint64_t block_key) const
{
  const std::uint64_t* const first =
      std::lower_bound(keys(), keys() + size(), block_key << VoxelUpdates::block_bits);
  return static_cast<std::size_t>(first - keys());
}

/** \brief Sums the updates of some runs, and copies all other voxels of a part. */
void
SummedVoxels::addPart(const std::vector<const VoxelUpdates*>& of_streams,
                      const Place& begin,
                      const Place& end,
                      Part& part) const
{
  part.sums.size = 0;
  if (has_colours_)
    part.block.addColours();
  std::size_t next = begin.voxel;
  for (std::size_t i = begin.run; i < end.run;) {
    const std::uint64_t block_key = runs_[i].key;
    const std::size_t first_of_block = firstOfBlock(block_key);
    const std::size_t end_of_block = firstOfBlock(block_key + 1);
    part.sums.append(sums_, next, first_of_block, has_colours_);
    std::size_t most = end_of_block - first_of_block;
    next = end_of_block;
    for (; i < end.run && runs_[i].key == block_key; ++i) {
      const std::vector<VoxelUpdate>& updates = of_streams[runs_[i].stream]->updates;
      for (std::size_t j = runs_[i].begin; j < runs_[i].end; ++j)
        part.block.add(updates[j]);
      most += runs_[i].end - runs_[i].begin;
    }
    part.sums.reserve(std::min(most, VoxelUpdates::block_cells) + 1, has_colours_);
    part.block.moveTo(block_key, sums_, first_of_block, end_of_block, part.sums);
  }
  part.sums.append(sums_, next, end.voxel, has_colours_);
}

/** \brief Makes the sums of those of parts. */
void
SummedVoxels::joinParts(std::size_t count)
{
  std::swap(sums_, parts_[0].sums);
  for (std::size_t i = 1; i < count; ++i)
    sums_.append(parts_[i].sums, 0, parts_[i].sums.size, has_colours_);
}

bool
SummedVoxels::hasAnyBetween(std::uint64_t begin, std::uint64_t end) const
{
  const std::uint64_t* const first = std::lower_bound(keys(), keys() + size(), begin);
  return first != keys() + size() && *first < end;
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes
