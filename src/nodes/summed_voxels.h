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

/** \brief Updates of a stream. */
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

/** \brief Sum of colours. */
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

/** \brief Sums of voxels in a grid, in ascending order of their Morton keys.
 *
 * Of integers, so that the order of summands does not matter, and so that each can be
 * taken away again. Blocks with updates are summed in the cache, others are copied.
 *
 * Memory: 40 to 160 bytes for a voxel, with colours, which stay until all is removed, 1.8
 * times that; 50 kB for each thread, with colours 115.
 */
class SummedVoxels {
public:
  /** \param[in] threads that sum, 1 or more; the result does not depend on it */
  explicit SummedVoxels(std::size_t threads) : threads_(threads) {}

  /** \brief Removes all voxels and all memory. */
  void
  clear() noexcept;

  /** \brief Sums the updates of some streams. */
  void
  add(const std::vector<const VoxelUpdates*>& of_streams);

  /** \brief Number of voxels. */
  std::size_t
  size() const
  {
    return sums_.size;
  }

  /** \brief Morton keys of the voxels. */
  const std::uint64_t*
  keys() const
  {
    return sums_.keys.data();
  }

  /** \brief Sums of the intensities of each voxel. */
  const std::int64_t*
  intensities() const
  {
    return sums_.intensities.data();
  }

  /** \brief Sums of the colours of each voxel; null if there are none. */
  const SummedColour*
  colours() const
  {
    return has_colours_ ? sums_.colours.data() : nullptr;
  }

  /** \brief Whether a voxel's key is in a range, the end not included. */
  bool
  hasAnyBetween(std::uint64_t begin, std::uint64_t end) const;

private:
  using Runs = std::vector<VoxelUpdates::Run>;

  /** \brief Sums, by ascending keys. */
  struct Sums {
    std::size_t size = 0; ///< of what follows, which has room for more
    std::vector<std::uint64_t> keys;
    std::vector<std::int64_t> intensities;
    std::vector<std::uint32_t> summands; ///< voxels of streams
    std::vector<SummedColour> colours;   ///< empty if there are none

    /** \brief Makes room for further voxels. */
    void
    reserve(std::size_t further, bool has_colours);

    void
    append(const Sums& other, std::size_t begin, std::size_t end, bool has_colours);

    /** \brief Appends a voxel of others; there has to be room. */
    void
    copy(const Sums& other, std::size_t voxel, bool has_colours);
  };

  /** \brief What is added to the voxels of a block, by their cells. Of nothing between two
   * blocks. */
  class BlockSums {
  public:
    /** \brief From now on voxels have colours. */
    void
    addColours()
    {
      colours_.resize(cells);
    }

    void
    add(const VoxelUpdate& update);

    /** \brief Appends the voxels that a block had, with what is added to them, to others,
     * and goes on to another block.
     * \param[in] before voxels, of which those of the block are from begin to before end
     * \param[in,out] sums has room for these, those that come, and one more
     */
    void
    moveTo(std::uint64_t block_key,
           const Sums& before,
           std::size_t begin,
           std::size_t end,
           Sums& sums);

  private:
    static constexpr std::size_t cells = VoxelUpdates::block_cells;

    std::array<std::int64_t, cells> intensities_{};
    std::array<std::uint32_t, cells> summands_{};
    std::array<std::uint64_t, cells / 64> touched_{}; // a bit for each cell
    std::vector<SummedColour> colours_;               // empty, or of each cell
  };

  /** \brief What a thread sums. */
  struct Part {
    BlockSums block;
    Sums sums;
  };

  /** \brief Where a part begins, or the one before ends. */
  struct Place {
    std::size_t run;
    std::size_t voxel;
  };

  void
  gatherRuns(const std::vector<const VoxelUpdates*>& of_streams);

  void
  addPart(const std::vector<const VoxelUpdates*>& of_streams,
          const Place& begin,
          const Place& end,
          Part& part) const;

  Place
  beginOf(std::size_t part, std::size_t count) const;

  std::size_t
  firstOfBlock(std::uint64_t block_key) const;

  void
  joinParts(std::size_t count);

  const std::size_t threads_;
  Sums sums_;
  bool has_colours_ = false;
  Runs runs_; // keep their memory
  Runs spare_runs_;
  std::vector<Part> parts_;
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
