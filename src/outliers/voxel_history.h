// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "bytes/reserve_ahead.h"
#include "outliers/tracked_voxels.h"
#include "outliers/voxel_presence.h"
#include "voxels/intensity_symbols.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI {

/** \brief The voxels of the last frames, with their values: what the temporal filter
 * remembers, and shows. */
class VoxelHistory {
public:
  /** \brief Numbers of voxels in the current frame. */
  struct Counts {
    std::size_t shown = 0;
    std::size_t held = 0; ///< of these, those that the frame does not have
    std::size_t hit = 0;  ///< shown before it, and the frame has them
    std::size_t left = 0; ///< shown before it, and it has nothing near
  };

  /** \brief Merges a frame's voxels with the remembered ones.
   * \param[in] presence that has begun with this frame and these voxels
   * \param[in] holds whether voxels may stay where nothing near is measured */
  Counts
  update(const io::VoxelFrame& frame, VoxelPresence& presence, bool holds)
  {
    Counts counts;
    const std::size_t block_count =
        mergeBlocks(presence.surfaces().occupied(0).blocks(), presence, holds, counts);
    // One more of each: what is not kept is written, too; of tracked_ a new voxel.
    const bool has_colours = frame.colour_bits > 0;
    tracked_.reserve(tracked_.count + 1, 0, has_colours);
    next_.clear();
    next_.reserve(tracked_.count + frame.size() + 1, block_count, has_colours);
    io::ensureSize(hits_, frame.size() + 1);
    keepVoxels(block_count, presence);
    takeHits(frame, presence, counts);
    learnValues(frame);
    std::swap(tracked_, next_);
    return counts;
  }

  /** \brief Gives a frame the voxels that are shown, instead of its own.
   * \param[in] count of them */
  void
  show(io::VoxelFrame& frame, std::size_t count)
  {
    keys_.resize(count);
    intensities_.resize(frame.hasIntensities() ? count : 0);
    colours_.resize(frame.colour_bits > 0 ? count : 0);
    std::size_t first = 0; // voxel of a block
    std::size_t number = 0;
    for (std::size_t i = 0; i < tracked_.blocks.size(); ++i) {
      const std::uint64_t tracked = tracked_.shown[i] | tracked_.seldom[i];
      for (std::uint64_t left = tracked_.shown[i]; left != 0; left &= left - 1) {
        const std::size_t voxel = first + bitCount(tracked & ((left & (0 - left)) - 1));
        const std::uint64_t key =
            tracked_.blocks[i] << io::block_key_bits | lowestBit(left);
        keys_[number] = key;
        if (!intensities_.empty())
          intensities_[number] =
              symbolOf(frame, key, tracked_.voxels[voxel].intensity.shown());
        if (!colours_.empty()) {
          HeldColour& colour = tracked_.colours[voxel];
          colours_[number] = {static_cast<std::uint8_t>(colour[0].shown()),
                              static_cast<std::uint8_t>(colour[1].shown()),
                              static_cast<std::uint8_t>(colour[2].shown())};
        }
        ++number;
      }
      first += bitCount(tracked);
    }
    frame.keys.swap(keys_);
    frame.intensities.swap(intensities_);
    frame.colours.swap(colours_);
  }

  /** \brief Changes the keys of the voxels to those of another grid of the same lattice,
   * and drops those that are not in it. */
  void
  moveTo(const io::VoxelGrid& grid, const io::VoxelGrid& from)
  {
    std::vector<std::pair<std::uint64_t, std::size_t>> order;
    order.reserve(tracked_.count);
    std::size_t voxel = 0;
    for (std::size_t i = 0; i < tracked_.blocks.size(); ++i)
      for (std::uint64_t left = tracked_.shown[i] | tracked_.seldom[i]; left != 0;
           left &= left - 1, ++voxel) {
        const std::uint64_t key =
            tracked_.blocks[i] << io::block_key_bits | lowestBit(left);
        if (const std::optional<std::uint64_t> moved = keyInGrid(grid, from, key))
          order.emplace_back(*moved, voxel);
      }
    std::sort(order.begin(), order.end());
    next_.clear();
    next_.reserve(order.size(), order.size(), !tracked_.colours.empty());
    for (const auto& [key, i] : order) {
      const TrackedVoxel& moved = next_.voxels[next_.count] = tracked_.voxels[i];
      if (!tracked_.colours.empty())
        next_.colours[next_.count] = tracked_.colours[i];
      ++next_.count;
      const std::uint64_t cell = std::uint64_t{1} << key % io::block_cells;
      next_.pushBlock(key >> io::block_key_bits,
                      moved.is_shown ? cell : 0,
                      moved.is_shown ? 0 : cell);
    }
    std::swap(tracked_, next_);
  }

  /** \brief Changes the shown symbols to those of another scale, and learns values anew.
   */
  void
  changeScale(const io::IntensityScale& scale, const io::IntensityScale& from)
  {
    for (std::size_t i = 0; i < tracked_.count; ++i) {
      HeldValue& value = tracked_.voxels[i].intensity;
      const std::uint32_t symbol = io::lowestSymbol(scale, from.value(value.shown()));
      value.restart(static_cast<std::uint16_t>(std::min(symbol, scale.maxSymbol())));
    }
    usual_intensities_ = UsualDeviations();
  }

  /** \brief Releases memory that the voxels do not need. */
  void
  releaseMemory()
  {
    VoxelHistory kept;
    kept.tracked_ = std::move(tracked_);
    kept.tracked_.shrinkToFit();
    kept.usual_intensities_ = usual_intensities_;
    kept.usual_colours_ = usual_colours_;
    *this = std::move(kept);
  }

  const TrackedVoxels&
  voxels() const
  {
    return tracked_;
  }

  void
  forget()
  {
    tracked_.clear();
  }

private:
  /** \brief The cells of a block, of the last frame and of the current one. */
  struct BlockCells {
    std::uint64_t key;
    std::uint64_t tracked;
    std::uint64_t shown;  // that stay so, but for those that the frame makes shown
    std::uint64_t fading; // neither shown before nor hit
    std::uint64_t hits;   // that the frame has
    std::uint64_t near;   // next to shown ones, or to hits, see VoxelPresence::nextTo()
  };

  /** \brief With a depth model values are numbers of points, as the coders derive them
   * (doc/bitstream.md, "Depth model"): a shown symbol is then what they predict. */
  static std::uint16_t
  valueOf(const io::VoxelFrame& frame, std::size_t voxel)
  {
    const std::uint64_t symbol = frame.intensities[voxel];
    const std::uint64_t point =
        frame.depth_model
            ? frame.depth_model->pointSymbol(io::voxelPosition(frame.keys[voxel]))
            : 0;
    return static_cast<std::uint16_t>(
        point < 0x10000 ? symbol : ((symbol << 16) + point / 2) / point);
  }

  /** \brief The symbol of a value at a voxel of the frame's grid. */
  static std::uint16_t
  symbolOf(const io::VoxelFrame& frame, std::uint64_t key, std::uint16_t value)
  {
    const std::uint64_t point =
        frame.depth_model ? frame.depth_model->pointSymbol(io::voxelPosition(key)) : 0;
    const std::uint64_t symbol =
        point < 0x10000 ? value : (value * point + 0x8000) >> 16;
    return static_cast<std::uint16_t>(
        std::min<std::uint64_t>(symbol, frame.intensity_scale.maxSymbol()));
  }

  /** \brief Lists the blocks of the tracked voxels and of the frame, and decides which of
   * the shown voxels that it has not stay shown.
   * \return number of blocks */
  std::size_t
  mergeBlocks(const io::BlockList& hits,
              VoxelPresence& presence,
              bool holds,
              Counts& counts)
  {
    io::ensureSize(blocks_, tracked_.blocks.size() + hits.size());
    TrackedVoxel* voxels = tracked_.voxels.data();
    std::size_t count = 0;
    std::size_t i = 0;
    std::size_t j = 0;
    for (; i < tracked_.blocks.size() || j < hits.size(); ++count) {
      const std::uint64_t tracked =
          i < tracked_.blocks.size() ? tracked_.blocks[i] : ~std::uint64_t{0};
      const std::uint64_t hit = j < hits.size() ? hits.keys[j] : ~std::uint64_t{0};
      BlockCells block{std::min(tracked, hit), 0, 0, 0, 0, 0};
      if (hit <= tracked)
        block.hits = hits.masks[j++];
      if (tracked <= hit) {
        block.shown = tracked_.shown[i];
        block.fading = tracked_.seldom[i] & ~block.hits;
        block.tracked = tracked_.shown[i] | tracked_.seldom[i];
        ++i;
      }
      block.near = presence.nextTo(tracked_, block.key, block.shown, block.hits);
      presence.countShown(block.key, block.shown, block.hits, block.tracked, voxels);
      for (std::uint64_t left = block.shown & ~block.hits; left != 0;
           left &= left - 1) {
        const std::uint64_t bit = left & (0 - left);
        TrackedVoxel& voxel = voxels[bitCount(block.tracked & (bit - 1))];
        const std::uint64_t key = block.key << io::block_key_bits | lowestBit(left);
        const bool is_near = (block.near & bit) != 0;
        counts.left += presence.countMiss(key, is_near, holds, voxel) ? 1 : 0;
        block.shown ^= voxel.is_shown ? 0 : bit;
      }
      counts.held += bitCount(block.shown & ~block.hits);
      counts.hit += bitCount(block.shown & block.hits);
      voxels += bitCount(block.tracked);
      blocks_[count] = block;
    }
    counts.shown = counts.held + counts.hit;
    return count;
  }

  /** \brief Copies the tracked voxels to next_, but for those that are forgotten, and adds
   * new ones. Without branches on the kind of a voxel, which would be mispredicted. */
  void
  keepVoxels(std::size_t block_count, const VoxelPresence& presence)
  {
    const bool has_colours = !next_.colours.empty();
    const std::size_t new_voxel = tracked_.count;
    tracked_.voxels[new_voxel] = TrackedVoxel();
    if (has_colours)
      tracked_.colours[new_voxel] = HeldColour();
    const TrackedVoxel* const from = tracked_.voxels.data();
    TrackedVoxel* const to = next_.voxels.data();
    std::uint64_t* hit = hits_.data();
    std::size_t index = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < block_count; ++i) {
      const BlockCells& block = blocks_[i];
      const std::uint64_t gone = block.tracked & ~(block.shown | block.hits);
      std::uint64_t kept = 0;
      for (std::uint64_t left = block.tracked | block.hits; left != 0;
           left &= left - 1) {
        const unsigned int cell = lowestBit(left);
        const auto is_tracked = static_cast<std::size_t>(block.tracked >> cell & 1);
        const std::size_t voxel = new_voxel + ((index - new_voxel) & (0 - is_tracked));
        const std::uint32_t occupancy =
            presence.fade(from[voxel].occupancy, block.fading >> cell & 1);
        index += is_tracked;
        to[count] = from[voxel];
        to[count].occupancy = static_cast<std::uint16_t>(occupancy);
        if (has_colours)
          next_.colours[count] = tracked_.colours[voxel];
        *hit = count << 1 | (block.near >> cell & 1);
        hit += block.hits >> cell & 1;
        const std::uint64_t is_kept =
            1 ^ (presence.isForgotten(occupancy) & gone >> cell);
        kept |= is_kept << cell;
        count += static_cast<std::size_t>(is_kept);
      }
      next_.pushBlock(block.key, block.shown, kept & ~block.shown);
    }
    next_.count = count;
  }

  /** \brief Decides which of the voxels of the frame are shown. */
  void
  takeHits(const io::VoxelFrame& frame, const VoxelPresence& presence, Counts& counts)
  {
    std::size_t block = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const std::uint64_t key = frame.keys[i];
      TrackedVoxel& voxel = next_.voxels[hits_[i] >> 1];
      if (!presence.countHit(tracked_, key, (hits_[i] & 1) != 0, voxel))
        continue;
      ++counts.shown;
      while (next_.blocks[block] != key >> io::block_key_bits)
        ++block;
      const std::uint64_t bit = std::uint64_t{1} << key % io::block_cells;
      next_.shown[block] |= bit;
      next_.seldom[block] ^= bit;
    }
  }

  /** \brief Takes the intensities and the colours of the frame's voxels. */
  void
  learnValues(const io::VoxelFrame& frame)
  {
    for (std::size_t i = 0; frame.hasIntensities() && i < frame.size(); ++i)
      next_.voxels[hits_[i] >> 1].intensity.add(valueOf(frame, i), usual_intensities_);
    for (std::size_t i = 0; frame.colour_bits > 0 && i < frame.size(); ++i) {
      HeldColour& colour = next_.colours[hits_[i] >> 1];
      colour[0].add(frame.colours[i].r, usual_colours_);
      colour[1].add(frame.colours[i].g, usual_colours_);
      colour[2].add(frame.colours[i].b, usual_colours_);
    }
  }

  TrackedVoxels tracked_;
  UsualDeviations usual_intensities_;
  UsualDeviations usual_colours_;
  // Of the current frame; members so that their memory is reused.
  TrackedVoxels next_;
  std::vector<BlockCells> blocks_;
  std::vector<std::uint64_t> hits_; // voxel of next_, twice, plus 1 for a near one
  std::vector<std::uint64_t> keys_; // of the shown ones
  std::vector<std::uint16_t> intensities_;
  std::vector<io::VoxelColour> colours_;
};

} // namespace pcl_ext::PCL_EXT_ABI
