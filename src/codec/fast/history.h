// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace fast {

struct FrameBlocks;

/** \brief The past of a voxel: a 1, and below it its occupancy in the last frames, one
 * bit for each of at most seven, the last one lowest.
 *
 * New voxels of an I-frame start as if they had been occupied once before, which
 * distinguishes them from those of P-frames, most of which are noise.
 */
namespace voxel_past {

constexpr std::size_t count = 256;
constexpr unsigned int first_with_history = 1;
constexpr unsigned int first_apart = 3;

/** \brief The initial past of a new voxel. */
constexpr unsigned int
first(bool is_apart)
{
  return is_apart ? first_apart : first_with_history;
}

/** \brief The past after a further frame. */
constexpr unsigned int
next(unsigned int past, unsigned int is_occupied)
{
  const unsigned int longer = past << 1 | is_occupied;
  return past < 128 ? longer : 128 | (longer & 127);
}

/** \brief Whether a voxel is forgotten: it was empty in the first four frames after the
 * P-frame in which it was new, or in the last six frames. */
constexpr bool
isForgotten(unsigned int past)
{
  return (past >= 64 && (past & 63) == 0);
}

/** \brief Initial probability, 2^16 is 1, that a voxel with this past is occupied: a
 * running mean that starts at 0.4 and has a rate of 1/2 for two frames, 1/4 for three,
 * then 1/8. */
std::uint32_t
firstProbability(unsigned int past);

} // namespace voxel_past

/** \brief Index of a voxel: the number of its block times 64 plus its cell. */
using CellIndex = std::uint32_t;

/** \brief Allocates memory aligned to cache lines, so that the statistics of half a
 * block are one line. */
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

/** \brief Intensity statistics of voxels by their index, 64 a block; see
 * symbol_statistics. */
using StatisticsTable = std::vector<std::uint16_t, CacheLineAllocator<std::uint16_t>>;

/** \brief Statistics of the frames since the last I-frame, the same in encoder and
 * decoder (doc/bitstream_fast.md, "History").
 *
 * Tracked voxels are stored in buckets, one for each past, which each frame splits in
 * two (doc/implementation_notes.md, "Buckets"), intensity statistics by block, 64 each.
 * A block keeps its number as long as it has tracked voxels.
 */
struct History {
  /** \brief Statistics of a voxel that has none yet. */
  static constexpr std::uint16_t no_statistics = 0xffff;
  /** \brief Indices that may be read after a bucket. */
  static constexpr std::size_t spare_indices = 1;

  // By block number.
  std::vector<std::uint64_t> tracked; ///< cells that are in a bucket
  StatisticsTable statistics;         ///< 64 a block
  StatisticsTable
      point_statistics; ///< the same of numbers of points beside intensities
  std::vector<std::uint32_t> spare_numbers; ///< free block numbers

  // Blocks with tracked voxels, ascending.
  std::vector<std::uint64_t> keys; ///< Morton keys of the blocks
  std::vector<std::uint32_t> numbers;
  std::vector<std::uint8_t> activity; ///< which of the last 4 frames had new voxels

  // Buckets.
  std::array<std::uint32_t, voxel_past::count> first{}; ///< index in `cell_indices`
  std::array<std::uint32_t, voxel_past::count> size{};
  std::vector<CellIndex> cell_indices; ///< and `spare_indices` after the last bucket

  /** \brief Number of tracked voxels. */
  std::size_t
  voxelCount() const
  {
    std::size_t count = 0;
    for (const std::uint32_t bucket : size)
      count += bucket;
    return count;
  }

  /** \brief Allocates the memory that assign() needs, so that it cannot fail. */
  void
  reserveFor(const History& other);

  /** \brief Copies another history, without gaps between its buckets.
   * \param[in,out] other the history to copy
   * \param[in] with_statistics whether to exchange the statistics with those of `other`
   */
  void
  assign(History& other, bool with_statistics) noexcept;

  /** \brief Removes all voxels; their memory is kept. */
  void
  clear() noexcept;

  /** \brief Releases memory that the tracked voxels do not need. */
  void
  releaseMemory();
};

/** \brief Computes the history after a frame whose occupancy is coded, and the
 * ascending blocks of the frame. */
class HistoryUpdate {
public:
  /** \brief Updates the history with one frame.
   * \param[in] before the history before the frame
   * \param[in,out] after the history after it, with the buckets of tracked voxels
   * \param[in,out] statistics set to no_statistics for new voxels
   * \param[in,out] frame coded voxels; its blocks are set
   * \return false if a new block is in the history
   */
  bool
  run(const History& before,
      History& after,
      StatisticsTable& statistics,
      FrameBlocks& frame);

private:
  static void
  removeForgotten(History& after);

  static void
  reserveNew(const History& before,
             History& after,
             StatisticsTable& statistics,
             const FrameBlocks& frame);

  void
  addNewVoxels(const History& before,
               History& after,
               StatisticsTable& statistics,
               const FrameBlocks& frame);

  void
  numberNewBlocks(const History& before, const FrameBlocks& frame);

  bool
  mergeBlocks(const History& before, History& after, FrameBlocks& frame);

  std::vector<std::uint32_t> new_numbers_;   // of the new blocks
  std::vector<std::uint32_t> freed_numbers_; // of blocks without voxels
};

} // namespace fast
} // namespace pcl_ext::PCL_EXT_ABI::io
