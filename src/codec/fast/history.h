#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace pcl_ext {
namespace io {
namespace fast {

struct Frame;

/** \brief A voxel's past: a 1, and below it a bit for each of the last frames, at most
 * seven, the last one lowest, that tells whether the voxel was occupied.
 *
 * A voxel that an I-frame brings starts as if it had been occupied once before. That
 * keeps it apart from those that come with P-frames, most of which are noise.
 */
namespace voxel_past {

constexpr std::size_t count = 256;
constexpr unsigned int first_in_p_frame = 1;
constexpr unsigned int first_in_i_frame = 3;

/** \brief The past of a voxel that a frame brings. */
constexpr unsigned int
first(bool is_i_frame)
{
  return is_i_frame ? first_in_i_frame : first_in_p_frame;
}

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

/** \brief Probability, 2^16 is 1, that a voxel with this past is occupied, before any was
 * coded: a running mean that starts at 0.4 and moves 1/2 of the way for two frames, 1/4
 * for three, then 1/8. */
std::uint32_t
firstProbability(unsigned int past);

} // namespace voxel_past

/** \brief Where a voxel is: the number of its block times 64 plus its cell. */
using VoxelPlace = std::uint32_t;

/** \brief Memory that begins with a cache line, so that the statistics of half a block
 * are one line. */
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

/** \brief Intensity statistics of voxels by their place, 64 a block; see
 * symbol_statistics. */
using StatisticsTable = std::vector<std::uint16_t, CacheLineAllocator<std::uint16_t>>;

/** \brief Makes a vector at least this long, with a quarter more to grow. */
template <class Vector>
void
ensureSize(Vector& vector, std::size_t size)
{
  if (vector.size() < size)
    vector.resize(size + size / 4);
}

/** \brief What encoder and decoder remember of the frames since the last I-frame
 * (doc/bitstream_fast.md, "History").
 *
 * Known voxels lie in buckets, one for each past, which each frame splits in two
 * (doc/implementation_notes.md, "Buckets"). Intensity statistics lie in rows of 64 a
 * block. A block keeps its number as long as it has known voxels.
 */
struct History {
  /** \brief In the place of the statistics of a voxel that has none. */
  static constexpr std::uint16_t no_statistics = 0xffff;

  // By block number.
  std::vector<std::uint64_t> known;         ///< cells that lie in a bucket
  StatisticsTable statistics;               ///< 64 a block
  std::vector<std::uint32_t> spare_numbers; ///< numbers that are free again

  // Blocks with known voxels, ascending.
  std::vector<std::uint64_t> keys; ///< Morton keys of the blocks
  std::vector<std::uint32_t> numbers;
  std::vector<std::uint8_t> activity; ///< which of the last 4 frames brought new voxels

  // Buckets.
  std::array<std::uint32_t, voxel_past::count> first{}; ///< index in `places`
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

  /** \brief Takes the memory that assign() will need, so that it cannot fail. */
  void
  reserveFor(const History& other);

  /** \brief Becomes another history, with its buckets closed up.
   * \param[in,out] other its statistics are exchanged with these if they are taken
   * \param[in] with_statistics whether the other one's statistics are taken, too
   */
  void
  assign(History& other, bool with_statistics) noexcept;

  /** \brief Forgets all voxels; their memory is kept. */
  void
  clear() noexcept;

  /** \brief Gives back the memory that the known voxels do not need. */
  void
  giveBackMemory();
};

/** \brief Makes the history behind a frame, and the ascending blocks of the frame, once
 * its occupancy is coded. */
class HistoryUpdate {
public:
  /** \brief Runs for one frame.
   * \param[in] before the history before the frame
   * \param[in,out] after its buckets are filled with the known voxels
   * \param[in,out] statistics new voxels get none
   * \param[in,out] frame its voxels are coded; gets its blocks
   * \return false if a new block is in the history
   */
  bool
  run(const History& before, History& after, StatisticsTable& statistics, Frame& frame);

private:
  static void
  removeForgotten(History& after);

  static void
  reserveNew(const History& before,
             History& after,
             StatisticsTable& statistics,
             const Frame& frame);

  void
  addNewVoxels(const History& before,
               History& after,
               StatisticsTable& statistics,
               const Frame& frame);

  void
  numberNewBlocks(const History& before, const Frame& frame);

  bool
  mergeBlocks(const History& before, History& after, Frame& frame);

  std::vector<std::uint32_t> new_numbers_;   // of the new blocks
  std::vector<std::uint32_t> freed_numbers_; // of blocks without voxels
};

} // namespace fast
} // namespace io
} // namespace pcl_ext
