// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "nodes/summed_voxels.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace pcl_ext {
namespace nodes {

void
SummedVoxels::clear() noexcept
{
  parts_ = std::vector<Part>();
  order_ = std::vector<Place>();
  added_ = std::vector<Place>();
  spare_ = std::vector<Place>();
}

std::uint32_t
SummedVoxels::findOrInsert(Part& part, std::uint64_t octant_key)
{
  const std::uint32_t found = part.directory.find(octant_key);
  if (found != io::BlockDirectory::not_found)
    return found;
  part.octants.emplace_back();
  part.occupied.push_back(0);
  part.are_in_order.push_back(0);
  part.keys.push_back(octant_key);
  part.directory.insert(octant_key);
  return static_cast<std::uint32_t>(part.keys.size() - 1);
}

void
SummedVoxels::add(std::size_t part_index, const std::vector<VoxelUpdate>& updates)
{
  Part& part = parts_[part_index];
  std::uint64_t last_key = ~std::uint64_t{0};
  std::uint32_t index = 0;
  bool is_here = false;
  for (const VoxelUpdate& update : updates) {
    const std::uint64_t octant_key = update.key / cells;
    if (octant_key != last_key) {
      last_key = octant_key;
      is_here = partOf(octant_key) == part_index;
      if (!is_here)
        continue;
      index = findOrInsert(part, octant_key);
      if (part.are_in_order[index] == 0) {
        part.added.push_back(index);
        part.are_in_order[index] = 1;
      }
    }
    else if (!is_here)
      continue;
    const std::size_t cell = update.key % cells;
    SummedVoxel& voxel = part.octants[index][cell];
    // Without overflow, which would be undefined; of unsigned numbers it is not.
    const auto amount = static_cast<std::uint64_t>(update.intensity);
    const auto sum = static_cast<std::uint64_t>(voxel.intensity);
    voxel.intensity = static_cast<std::int64_t>(sum + amount);
    if (update.summands == 0)
      continue;
    const std::uint32_t one = update.summands > 0 ? 1u : ~0u;
    voxel.summands += one;
    const auto bit = static_cast<std::uint8_t>(1u << cell);
    std::uint8_t& occupied = part.occupied[index];
    if (voxel.summands == 0) {
      occupied = static_cast<std::uint8_t>(occupied & ~bit);
      --part.voxels;
      if (occupied == 0)
        part.emptied.push_back(index);
    }
    else if ((occupied & bit) == 0) {
      occupied = static_cast<std::uint8_t>(occupied | bit);
      ++part.voxels;
    }
    if (!update.has_colour)
      continue;
    if (part.colours.size() <= index)
      part.colours.resize(part.octants.size());
    SummedColour& colour = part.colours[index][cell];
    colour.summands += one;
    colour.channels[0] += one * update.colour.r;
    colour.channels[1] += one * update.colour.g;
    colour.channels[2] += one * update.colour.b;
  }
}

void
SummedVoxels::settle()
{
  dropEmptied();
  mergeAdded();
  std::vector<std::size_t> in_order(parts_.size());
  for (const Place& place : order_)
    ++in_order[place.part];
  bool is_any_removed = false;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    constexpr std::size_t few = 64;
    if (parts_[i].keys.size() <= 2 * in_order[i] + few)
      continue;
    removeEmpty(parts_[i]);
    is_any_removed = true;
  }
  if (!is_any_removed)
    return;
  for (Place& place : order_)
    place.index = parts_[place.part].directory.find(place.key);
}

/** \brief Takes octants that are without a voxel now out of the order, or does not put
 * them into it. */
void
SummedVoxels::dropEmptied()
{
  bool is_any_empty = false;
  for (Part& part : parts_) {
    for (const std::uint32_t index : part.emptied)
      if (part.occupied[index] == 0) {
        part.are_in_order[index] = 0;
        is_any_empty = true;
      }
    part.emptied.clear();
  }
  if (!is_any_empty)
    return;
  const auto is_out = [&](const Place& place) {
    return parts_[place.part].are_in_order[place.index] == 0;
  };
  order_.erase(std::remove_if(order_.begin(), order_.end(), is_out), order_.end());
  for (Part& part : parts_) {
    const auto is_empty = [&](std::uint32_t i) { return part.are_in_order[i] == 0; };
    part.added.erase(std::remove_if(part.added.begin(), part.added.end(), is_empty),
                     part.added.end());
  }
}

/** \brief Puts octants with their first voxel into the order. */
void
SummedVoxels::mergeAdded()
{
  added_.clear();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    for (const std::uint32_t index : part.added)
      added_.push_back({part.keys[index], static_cast<std::uint32_t>(i), index});
    part.added.clear();
  }
  if (added_.empty())
    return;
  const auto is_before = [](const Place& one, const Place& other) {
    return one.key < other.key;
  };
  std::sort(added_.begin(), added_.end(), is_before);
  spare_.clear();
  spare_.reserve(order_.size() + added_.size());
  std::merge(order_.begin(),
             order_.end(),
             added_.begin(),
             added_.end(),
             std::back_inserter(spare_),
             is_before);
  order_.swap(spare_);
}

/** \brief Removes the octants of a part that are not in the order, which changes the
 * index of others. */
void
SummedVoxels::removeEmpty(Part& part) const
{
  Part kept;
  std::size_t count = 0;
  for (const std::uint8_t is_in_order : part.are_in_order)
    count += is_in_order;
  kept.keys.reserve(count);
  kept.octants.reserve(count);
  kept.directory.clear(count);
  for (std::size_t i = 0; i < part.keys.size(); ++i) {
    if (part.are_in_order[i] == 0)
      continue;
    kept.keys.push_back(part.keys[i]);
    kept.octants.push_back(part.octants[i]);
    kept.occupied.push_back(part.occupied[i]);
    kept.directory.insert(part.keys[i]);
    if (i < part.colours.size())
      kept.colours.push_back(part.colours[i]);
  }
  kept.are_in_order.assign(count, 1);
  kept.voxels = part.voxels;
  part = std::move(kept);
}

std::size_t
SummedVoxels::size() const
{
  std::size_t count = 0;
  for (const Part& part : parts_)
    count += part.voxels;
  return count;
}

bool
SummedVoxels::hasAnyBetween(std::uint64_t begin, std::uint64_t end) const
{
  const auto first = std::lower_bound(
      order_.begin(), order_.end(), begin / cells, [](const Place& place, auto key) {
        return place.key < key;
      });
  return first != order_.end() && first->key * cells < end;
}

} // namespace nodes
} // namespace pcl_ext
