#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace pcl_ext {
namespace io {

/** \brief Finds blocks by their Morton keys: a hash table with open addressing.
 *
 * Where a key comes to lie depends on a random number of this instance, so that no
 * stream can be made whose keys collide. Nothing that is coded depends on it.
 */
class BlockDirectory {
public:
  static constexpr std::uint32_t not_found = 0xffffffff;

  /** \brief Removes all blocks, and makes room for some without growing. */
  void
  clear(std::size_t expected_blocks)
  {
    unsigned int bits = 4;
    while ((std::size_t{1} << bits) < 2 * expected_blocks)
      ++bits;
    // Smaller again once in a while only: a stream's frames are about as large.
    if (slots_.size() < (std::size_t{1} << bits) ||
        slots_.size() > (std::size_t{64} << bits)) {
      slots_.assign(std::size_t{1} << bits, Slot{0, not_found});
      shift_ = 64 - bits;
    }
    else
      std::fill(slots_.begin(), slots_.end(), Slot{0, not_found});
    count_ = 0;
  }

  /** \brief Adds a block that is not there yet.
   * \param[in] key Morton key of the block
   * \param[in] index what find() answers, below not_found
   */
  void
  insert(std::uint64_t key, std::uint32_t index)
  {
    if (2 * ++count_ > slots_.size())
      grow();
    place({key, index});
  }

  /** \brief Index of a block, or not_found. */
  std::uint32_t
  find(std::uint64_t key) const
  {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t slot = slotOf(key);; slot = (slot + 1) & mask)
      if (slots_[slot].index == not_found || slots_[slot].key == key)
        return slots_[slot].index;
  }

private:
  struct Slot {
    std::uint64_t key;
    std::uint32_t index;
  };

  std::size_t
  slotOf(std::uint64_t key) const
  {
    std::uint64_t hash = (key ^ seed_) * 0x9e3779b97f4a7c15;
    hash = (hash ^ hash >> 32) * 0xd6e8feb86659fd93;
    return static_cast<std::size_t>(hash >> shift_);
  }

  void
  place(const Slot& block)
  {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = slotOf(block.key);
    while (slots_[slot].index != not_found)
      slot = (slot + 1) & mask;
    slots_[slot] = block;
  }

  void
  grow()
  {
    std::vector<Slot> old(2 * slots_.size(), Slot{0, not_found});
    old.swap(slots_);
    --shift_;
    for (const Slot& block : old)
      if (block.index != not_found)
        place(block);
  }

  std::vector<Slot> slots_ = std::vector<Slot>(16, Slot{0, not_found});
  unsigned int shift_ = 60;
  std::size_t count_ = 0;
  std::uint64_t seed_ =
      std::uint64_t{std::random_device{}()} << 32 | std::random_device{}();
};

} // namespace io
} // namespace pcl_ext
