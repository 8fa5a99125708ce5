#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief A voxel's past as the fast coder sees it: a 1 and behind it whether the voxel
 * was occupied in each of the last frames, the last one lowest; at most seven frames.
 *
 * A voxel that an I-frame brings starts as if it had been occupied once before, which
 * keeps it apart from those that turn up between two I-frames, mostly noise.
 */
namespace voxel_past {

constexpr std::size_t count = 256;
constexpr unsigned int born_in_p_frame = 1;
constexpr unsigned int born_in_i_frame = 3;

/** \brief The past one frame on. */
constexpr unsigned int
next(unsigned int past, unsigned int is_occupied)
{
  const unsigned int longer = past << 1 | is_occupied;
  return past < 128 ? longer : 128 | (longer & 127);
}

/** \brief Whether the voxel is forgotten: it was empty in all of the first four frames
 * after the P-frame that brought it, or in the last six. */
constexpr bool
isForgotten(unsigned int past)
{
  return past == 16 || (past >= 64 && (past & 63) == 0);
}

/** \brief Probability, 2^16 is 1, that a voxel with this past is occupied, as far as it
 * can be told without having seen any: a running mean that starts at 0.4 and moves 1/2
 * of the way for two frames, 1/4 for three, then 1/8. */
std::uint32_t
firstProbability(unsigned int past);

} // namespace voxel_past

/** \brief Where a voxel is: the number of its block times 64 plus its cell. */
using VoxelPlace = std::uint32_t;

/** \brief Memory that begins with a cache line: half a block's moments are a whole one
 * then. */
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t line{64};

  CacheLineAllocator() = default;
  template <class Other>
  explicit CacheLineAllocator(const CacheLineAllocator<Other>&)
  {}

  T*
  allocate(std::size_t count)
  {
    return static_cast<T*>(::operator new(count * sizeof(T), line));
  }

  void
  deallocate(T* memory, std::size_t)
  {
    ::operator delete(memory, line);
  }

  friend bool
  operator==(const CacheLineAllocator&, const CacheLineAllocator&)
  {
    return true;
  }

  friend bool
  operator!=(const CacheLineAllocator&, const CacheLineAllocator&)
  {
    return false;
  }
};

/** \brief Moments of voxels by their place, 64 a block. */
using Moments = std::vector<std::uint16_t, CacheLineAllocator<std::uint16_t>>;

/** \brief Makes a vector at least this long, with room to grow. */
template <class Vector>
void
ensureSize(Vector& vector, std::size_t size)
{
  if (vector.size() < size)
    vector.resize(size + size / 4);
}

/** \brief What the fast coder's both ends remember since the last I-frame.
 *
 * Known voxels lie in buckets, one for each past. A frame splits every bucket in two,
 * which costs a small part of what moving records in the order of their keys costs. Moments lie
 * in rows of 64 a block. A block keeps its number as long as it has known voxels.
 */
struct History {
  /** \brief The moment of a voxel none of whose symbols was seen. */
  static constexpr std::uint16_t no_moment = 0xffff;

  // By block number.
  std::vector<std::uint64_t> known; ///< cells that lie in a bucket
  Moments moments;                  ///< 64 a block: mean and deviation of symbols
  std::vector<std::uint32_t> spare_numbers; ///< numbers that are free again

  // Blocks with known voxels, ascending.
  std::vector<std::uint64_t> keys; ///< Morton keys of the blocks
  std::vector<std::uint32_t> numbers;
  std::vector<std::uint8_t> activity; ///< which of the last 4 frames brought new voxels

  // Buckets.
  std::array<std::uint32_t, voxel_past::count> first{}; ///< in `places`
  std::array<std::uint32_t, voxel_past::count> size{};
  std::vector<VoxelPlace> places;

  /** \brief Number of known voxels. */
  std::size_t
  voxelCount() const
  {
    std::size_t count = 0;
    for (const std::uint32_t bucket : size)
      count += bucket;
    return count;
  }

  /** \brief Takes the memory that learn() will need, so that it cannot fail then. */
  void
  makeRoomFor(const History& other);

  /** \brief Becomes another history, without the room between its buckets: what is read in
   * a row comes faster.
   * \param[in,out] other its moments are exchanged with these if they are taken
   * \param[in] with_moments whether the other one's moments are taken, too
   */
  void
  learn(History& other, bool with_moments) noexcept;

  /** \brief Forgets all voxels; their memory is kept. */
  void
  clear() noexcept;

  /** \brief Gives back the memory that the known voxels do not need. */
  void
  giveBackMemory();
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
