// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Finds blocks by their Morton keys: a hash table with open addressing.
 *
 * The hash depends on a random number of the instance, so that no stream can be
 * constructed whose keys collide. Coded bytes do not depend on it.
 */
class BlockDirectory {
public:
  static constexpr std::uint32_t not_found = 0xffffffff;

  /** \brief Removes all blocks, and reserves slots for a number of blocks. */
  void
  clear(std::size_t expected_blocks)
  {
    // The number may not be known yet: at least as many as in the previous frame.
    const std::size_t blocks = std::max(expected_blocks, keys_.size());
    unsigned int bits = 4;
    while ((std::size_t{1} << bits) < 2 * blocks)
      ++bits;
    // Reduced with hysteresis, as the sizes of frames vary little.
    if (slots_.size() < (std::size_t{1} << bits) ||
        slots_.size() > (std::size_t{64} << bits)) {
      slots_.assign(std::size_t{1} << bits, 0);
      shift_ = 64 - bits;
    }
    else
      std::fill(slots_.begin(), slots_.end(), 0);
    keys_.resize(1);
  }

  /** \brief Allocates memory for the keys of a number of further blocks at once. */
  void
  reserveFor(std::size_t further_blocks)
  {
    reserveAhead(keys_, keys_.size() + further_blocks);
  }

  /** \brief Adds a block that is not there yet; its index is the number of blocks so
   * far.
   * \param[in] key Morton key of the block
   */
  void
  insert(std::uint64_t key)
  {
    keys_.push_back(key);
    if (2 * keys_.size() > slots_.size())
      grow();
    else
      addToSlots(static_cast<std::uint32_t>(keys_.size() - 1));
  }

  /** \brief Replaces all blocks by those with some keys, in this order. */
  void
  assign(const std::vector<std::uint64_t>& keys)
  {
    clear(keys.size());
    for (const std::uint64_t key : keys)
      insert(key);
  }

  /** \brief Index of a block, or not_found. */
  std::uint32_t
  find(std::uint64_t key) const
  {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = slotOf(key);; slot = (slot + 1) & mask) {
      const std::uint32_t index = slots_[slot];
      // One condition, as which of the two ends the search is hard to predict.
      if ((index == 0) | (keys_[index] == key))
        return index - 1;
    }
  }

private:
  std::size_t
  slotOf(std::uint64_t key) const
  {
    std::uint64_t hash = (key ^ seed_) * 0x9e3779b97f4a7c15;
    hash = (hash ^ hash >> 32) * 0xd6e8feb86659fd93;
    return static_cast<std::size_t>(hash >> shift_);
  }

  void
  addToSlots(std::uint32_t index)
  {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = slotOf(keys_[index]);
    while (slots_[slot] != 0)
      slot = (slot + 1) & mask;
    slots_[slot] = index;
  }

  void
  grow()
  {
    slots_.assign(2 * slots_.size(), 0);
    --shift_;
    for (std::size_t index = 1; index < keys_.size(); ++index)
      addToSlots(static_cast<std::uint32_t>(index));
  }

  std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(16); // index + 1, or 0
  std::vector<std::uint64_t> keys_{0};                                // by index + 1
  unsigned int shift_ = 60;
  std::uint64_t seed_ =
      std::uint64_t{std::random_device{}()} << 32 | std::random_device{}();
};

} // namespace pcl_ext::PCL_EXT_ABI::io
