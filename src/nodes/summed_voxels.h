// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief A voxel of a stream that is added to the voxel of the merged grid that contains
 * it, is taken away again, or has another intensity. */
struct VoxelUpdate {
  std::int64_t intensity; ///< to be added
  std::uint16_t cell;     ///< Morton key in the block
  std::int8_t summands;   ///< 1: it is added, -1: taken away, 0: it stays
  bool has_colour;
  io::VoxelColour colour; ///< in channels of 0 to 255
};

class VoxelUpdates {
public:
  /** \brief Blocks have 16 x 16 x 16 voxels, so that the sums of one fit the
   * second-level cache. */
  static constexpr unsigned int block_bits = 12;
  static constexpr std::size_t block_cells = std::size_t{1} << block_bits;

  /** \brief Updates in a row of one block. */
  struct Run {
    std::uint64_t key; ///< Morton key of the block
    std::uint32_t begin;
    std::uint32_t end;
    std::uint32_t stream; ///< set by SummedVoxels
  };

  /** \brief Appends an update.
   * \param[in] key Morton key of its voxel in the merged grid
   * \param[in] update its cell is set
   */
  void
  append(std::uint64_t key, const VoxelUpdate& update)
  {
    // Members are set where they are, as processors are slow to read what was just
    // written with other widths.
    const std::uint64_t block_key = key >> block_bits;
    if (runs.empty() || runs.back().key != block_key) {
      Run& run = runs.emplace_back();
      run.key = block_key;
      run.begin = static_cast<std::uint32_t>(updates.size());
    }
    VoxelUpdate& appended = updates.emplace_back();
    appended.intensity = update.intensity;
    appended.cell = static_cast<std::uint16_t>(key % block_cells);
    appended.summands = update.summands;
    appended.has_colour = update.has_colour;
    appended.colour = update.colour;
    runs.back().end = static_cast<std::uint32_t>(updates.size());
    has_colours |= update.has_colour;
  }

  void
  clear()
  {
    updates.clear();
    runs.clear();
    has_colours = false;
  }

  std::vector<VoxelUpdate> updates;
  std::vector<Run> runs;
  bool has_colours = false; ///< any of them
};

struct SummedColour {
  std::uint32_t summands = 0;
  std::array<std::uint32_t, 3> channels{};

  void
  add(const SummedColour& other)
  {
    summands += other.summands;
    for (std::size_t i = 0; i < channels.size(); ++i)
      channels[i] += other.channels[i];
  }
};

/** \brief A voxel whose sum of intensities is another one than before, that came or that
 * went. */
struct ChangedSum {
  std::uint64_t key; ///< Morton key
  std::int64_t before;
  std::int64_t after;
  bool was_there;
  bool is_there;
};

/** \brief Changed voxels, ascending. */
struct ChangedSums {
  std::vector<ChangedSum> sums;
  std::size_t were_there = 0; ///< how many of them
  std::size_t are_there = 0;

  void
  append(const ChangedSum& sum)
  {
    sums.push_back(sum);
    were_there += sum.was_there ? 1 : 0;
    are_there += sum.is_there ? 1 : 0;
  }

  void
  clear()
  {
    sums.clear();
    were_there = 0;
    are_there = 0;
  }
};

/** \brief Sums of voxels in a grid, in ascending order of their Morton keys.
 *
 * Of integers, so that the order of summands does not matter, and so that each can be
 * taken away again. They are kept by blocks; those without updates are not touched.
 *
 * Memory: 16 to 64 bytes for a voxel, for a block up to 350, and 32 for a voxel that
 * changes; with colours, which stay until all is removed, twice that; 150 kB for each
 * thread, with colours 300.
 */
class SummedVoxels {
public:
  /** \param[in] threads that sum, 1 or more; the result does not depend on it */
  explicit SummedVoxels(std::size_t threads) : threads_(threads) {}

  /** \brief Removes all voxels and all memory. */
  void
  clear() noexcept;

  /** \brief Sums the updates of some streams.
   * \param[in] lists_changes whether changes() will be asked for
   */
  void
  add(const std::vector<const VoxelUpdates*>& of_streams, bool lists_changes);

  /** \brief The voxels that the last updates changed, but for colours, in lists each of
   * which is behind the one before it: one list for each thread that made them. */
  const std::vector<ChangedSums>&
  changes() const
  {
    return changes_;
  }

  /** \brief Number of voxels. */
  std::size_t
  size() const
  {
    return size_;
  }

  /** \brief Whether there may be colours. */
  bool
  hasColours() const
  {
    return has_colours_;
  }

  /** \brief Visits all voxels, ascending.
   * \param[in] visit called with the Morton key, the sum of the intensities, and that of
   * the colours
   */
  template <typename VisitT>
  void
  forEach(const VisitT& visit) const
  {
    static const SummedColour none;
    for (const Block& block : blocks_) {
      const std::uint64_t first_key = block.key << VoxelUpdates::block_bits;
      for (std::size_t i = 0; i < block.sums.size(); ++i)
        visit(first_key + block.sums[i].cell,
              block.sums[i].intensity,
              block.colours.empty() ? none : block.colours[i]);
    }
  }

  /** \brief Whether a voxel's key is in a range, the end not included. */
  bool
  hasAnyBetween(std::uint64_t begin, std::uint64_t end) const;

private:
  using Runs = std::vector<VoxelUpdates::Run>;

  struct Sum {
    std::int64_t intensity;
    std::uint32_t summands; ///< voxels of streams
    std::uint16_t cell;     ///< Morton key in the block
  };

  struct Block {
    std::uint64_t key;                 ///< Morton key
    std::vector<Sum> sums;             ///< ascending
    std::vector<SummedColour> colours; ///< of each, or empty if there are none

    void
    prefetch() const;
  };

  /** \brief What is added to the voxels of a block, by their cells. Of nothing between two
   * blocks. */
  class Additions {
  public:
    /** \brief From now on voxels have colours. */
    void
    addColours()
    {
      colours_.resize(cells);
    }

    void
    add(const VoxelUpdate& update);

    /** \brief Adds all to the voxels of a block, and goes on to another one.
     * \param[in,out] changes where voxels that change are appended; may be null
     */
    void
    moveTo(Block& block, ChangedSums* changes);

  private:
    static constexpr std::size_t cells = VoxelUpdates::block_cells;

    struct Addition {
      std::int64_t intensity = 0;
      std::uint32_t summands = 0;
    };

    void
    makeRoom(Block& block);

    void
    copy(const Block& block, std::size_t voxel, std::size_t& count);

    std::array<Addition, cells> additions_{};
    std::array<std::uint64_t, cells / 64> touched_{}; // a bit for each cell
    std::uint64_t touched_words_ = 0;                 // a bit for each of these
    std::vector<SummedColour> colours_;               // empty, or of each cell
    std::size_t updates_ = 0;
    // The block's, with room for one more.
    std::vector<Sum> sums_after_;
    std::vector<SummedColour> colours_after_;
  };

  /** \brief What a thread sums. */
  struct Part {
    Runs runs; // these two keep their memory
    Runs spare_runs;
    Additions additions;
    std::vector<Block> new_blocks; ///< ascending
    ChangedSums changes;
    std::size_t came = 0; ///< voxels
    std::size_t went = 0;
    bool has_empty_blocks = false;
  };

  /** \brief Keys of blocks, the end not included. */
  struct KeyRange {
    std::uint64_t begin;
    std::uint64_t end;
  };

  static void
  gatherRuns(const std::vector<const VoxelUpdates*>& of_streams,
             const KeyRange& range,
             Part& part);

  void
  addPart(const std::vector<const VoxelUpdates*>& of_streams,
          const KeyRange& range,
          bool lists_changes,
          Part& part);

  void
  joinParts(std::size_t count);

  void
  updateBlocks(std::size_t parts);

  const std::size_t threads_;
  std::vector<Block> blocks_; // ascending, none without voxels
  std::vector<Block> spare_blocks_;
  std::size_t size_ = 0;
  bool has_colours_ = false;
  std::vector<Part> parts_;
  std::vector<ChangedSums> changes_; // of each part
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
