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
    mergeBlocks(presence.surfaces().occupied(0).blocks());
    io::ensureSize(hits_, frame.size() + ahead);
    Counts counts;
    tracked_.clear();
    std::uint32_t* hit = hits_.data();
    for (std::size_t i = 0; i + 1 < merged_.blocks.size(); ++i) {
      TrackedBlock block = merged_.blocks[i];
      presence.countShown(block, records_.voxels);
      fadeSeldom(presence, block);
      takeMisses(presence, holds, block, counts);
      allocateRecords(merged_.blocks[i], frame, block);
      hit = takeHits(i, presence, hit, block, counts);
      if ((block.shown | block.seldom) != 0)
        tracked_.push_back(block);
    }
    learnValues(frame);
    return counts;
  }

  /** \brief Gives a frame the voxels that are shown, instead of its own.
   * \param[in] count of them */
  void
  show(io::VoxelFrame& frame, std::size_t count)
  {
    keys_.resize(count);
    io::ensureSize(shown_, count + ahead);
    intensities_.resize(frame.hasIntensities() ? count : 0);
    colours_.resize(frame.colour_bits > 0 ? count : 0);
    std::size_t number = 0;
    for (const TrackedBlock& block : tracked_)
      for (std::uint64_t left = block.shown; left != 0; left &= left - 1) {
        const unsigned int cell = lowestBit(left);
        keys_[number] = block.key << io::block_key_bits | cell;
        shown_[number++] = block.recordOf(cell);
      }
    for (std::size_t i = 0; i < intensities_.size(); ++i) {
      prefetch(records_.intensities.data() + shown_[i + ahead]);
      intensities_[i] =
          symbolOf(frame, keys_[i], records_.intensities[shown_[i]].shown());
    }
    for (std::size_t i = 0; i < colours_.size(); ++i) {
      HeldColour& colour = records_.colours[shown_[i]];
      colours_[i] = {static_cast<std::uint8_t>(colour[0].shown()),
                     static_cast<std::uint8_t>(colour[1].shown()),
                     static_cast<std::uint8_t>(colour[2].shown())};
    }
    frame.keys.swap(keys_);
    frame.intensities.swap(intensities_);
    frame.colours.swap(colours_);
  }

  /** \brief Changes the keys of the voxels to those of another grid of the same lattice,
   * and drops those that are not in it. Releases memory that they do not need. */
  void
  moveTo(const io::VoxelGrid& grid, const io::VoxelGrid& from)
  {
    struct Moved {
      std::uint64_t key;
      std::size_t record;
      bool is_shown;
    };
    std::vector<Moved> order;
    order.reserve(count_);
    for (const TrackedBlock& block : tracked_)
      for (std::uint64_t left = block.shown | block.seldom; left != 0;
           left &= left - 1) {
        const unsigned int cell = lowestBit(left);
        const std::uint64_t key = block.key << io::block_key_bits | cell;
        if (const std::optional<std::uint64_t> moved = keyInGrid(grid, from, key))
          order.push_back(
              {*moved, block.recordOf(cell), (block.shown >> cell & 1) != 0});
      }
    std::sort(order.begin(), order.end(), [](const Moved& a, const Moved& b) {
      return a.key < b.key;
    });
    VoxelHistory moved;
    moved.usual_intensities_ = usual_intensities_;
    moved.usual_colours_ = usual_colours_;
    for (const Moved& voxel : order)
      moved.add(voxel.key, voxel.is_shown, records_, voxel.record);
    *this = std::move(moved);
  }

  /** \brief Changes the shown symbols to those of another scale, and learns values anew.
   */
  void
  changeScale(const io::IntensityScale& scale, const io::IntensityScale& from)
  {
    for (HeldValue& value : records_.intensities) {
      const std::uint32_t symbol = io::lowestSymbol(scale, from.value(value.shown()));
      value.restart(static_cast<std::uint16_t>(std::min(symbol, scale.maxSymbol())));
    }
    usual_intensities_ = UsualDeviations();
  }

  /** \brief Number of voxels. */
  std::size_t
  size() const
  {
    return count_;
  }

  void
  forget()
  {
    tracked_.clear();
    records_ = VoxelRecords();
    count_ = 0;
  }

private:
  static constexpr std::size_t ahead = 12; // record that is prefetched

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

  /** \brief Sets merged_ to the blocks of what is tracked and of the frame. */
  void
  mergeBlocks(const io::BlockList& hits)
  {
    merged_.blocks.clear();
    merged_.around.clear();
    auto tracked = tracked_.begin();
    std::size_t j = 0;
    while (tracked != tracked_.end() || j < hits.size()) {
      TrackedBlock block{~std::uint64_t{0}, 0, 0, 0, {}};
      if (tracked != tracked_.end() &&
          (j == hits.size() || tracked->key <= hits.keys[j])) {
        block = *tracked++;
        block.hits = 0;
      }
      if (j < hits.size() && hits.keys[j] <= block.key) {
        block.key = hits.keys[j];
        block.hits = hits.masks[j++];
      }
      merged_.around.append(block.key, merged_.blocks.size());
      merged_.blocks.push_back(block);
    }
    merged_.blocks.push_back({});
  }

  /** \brief Takes the voxels that are not shown and that the frame has not. */
  void
  fadeSeldom(const VoxelPresence& presence, TrackedBlock& block)
  {
    TrackedVoxel* const voxels = records_.voxels.data();
    for (std::uint64_t left = block.seldom & ~block.hits; left != 0; left &= left - 1) {
      const unsigned int cell = lowestBit(left);
      const std::uint64_t is_forgotten =
          presence.fade(voxels[block.recordOf(cell)].occupancy);
      block.seldom ^= is_forgotten << cell;
      count_ -= static_cast<std::size_t>(is_forgotten);
    }
  }

  /** \brief Decides which of the shown voxels that the frame has not stay shown. */
  void
  takeMisses(const VoxelPresence& presence,
             bool holds,
             TrackedBlock& block,
             Counts& counts)
  {
    std::uint64_t left = block.shown & ~block.hits;
    if (left == 0)
      return;
    const std::uint64_t near = cellsAround(block.hits);
    for (; left != 0; left &= left - 1) {
      const unsigned int cell = lowestBit(left);
      TrackedVoxel& voxel = records_.voxels[block.recordOf(cell)];
      const Miss miss = presence.countMiss(merged_,
                                           block.key << io::block_key_bits | cell,
                                           (near >> cell & 1) != 0,
                                           voxel);
      counts.left += miss == Miss::Left ? 1 : 0;
      if (miss == Miss::Held || (miss == Miss::Left && holds)) {
        ++counts.held;
        ++counts.shown;
        continue;
      }
      const std::uint64_t is_forgotten = presence.isForgotten(voxel.occupancy);
      block.shown ^= left & (0 - left);
      block.seldom |= (1 ^ is_forgotten) << cell;
      count_ -= static_cast<std::size_t>(is_forgotten);
    }
  }

  /** \brief Gives records to the octants that have cells now, and takes them from those
   * that have none any more. */
  void
  allocateRecords(const TrackedBlock& before,
                  const io::VoxelFrame& frame,
                  TrackedBlock& block)
  {
    const unsigned int had = io::occupiedOctants(before.shown | before.seldom);
    const unsigned int has =
        io::occupiedOctants(block.shown | block.seldom | block.hits);
    for (unsigned int left = had & ~has; left != 0; left &= left - 1)
      records_.unused.push_back(block.records[lowestBit(left)]);
    for (unsigned int left = has & ~had; left != 0; left &= left - 1)
      block.records[lowestBit(left)] =
          records_.allocate(frame.hasIntensities(), frame.colour_bits > 0);
  }

  /** \brief Takes the voxels of the frame, and decides which become shown.
   * \param[in] index of the block
   * \param[out] hit of hits_
   * \return the end of those of the block */
  std::uint32_t*
  takeHits(std::size_t index,
           const VoxelPresence& presence,
           std::uint32_t* hit,
           TrackedBlock& block,
           Counts& counts)
  {
    if (block.hits == 0)
      return hit;
    const std::uint64_t was_shown = merged_.blocks[index].shown;
    const std::uint64_t tracked = was_shown | merged_.blocks[index].seldom;
    std::uint64_t unclear = ~cellsAround(was_shown);
    TrackedVoxel* const voxels = records_.voxels.data();
    for (std::uint64_t left = block.hits; left != 0; left &= left - 1) {
      const unsigned int cell = lowestBit(left);
      const std::uint32_t record = block.recordOf(cell);
      const auto is_tracked = static_cast<std::uint32_t>(tracked >> cell & 1);
      *hit++ = record << 1 | is_tracked;
      unclear |= presence.countHit(is_tracked != 0, voxels[record]) << cell;
    }
    for (std::uint64_t left = unclear & block.hits & ~was_shown; left != 0;
         left &= left - 1) {
      const unsigned int cell = lowestBit(left);
      if (presence.becomesShown(merged_, index, cell, voxels[block.recordOf(cell)]))
        block.shown |= left & (0 - left);
    }
    count_ += bitCount(block.hits & ~tracked);
    counts.hit += bitCount(was_shown & block.hits);
    counts.shown += bitCount(block.shown & block.hits);
    block.seldom = (block.seldom | block.hits) & ~block.shown;
    return hit;
  }

  /** \brief Takes the intensities and the colours of the frame's voxels. */
  void
  learnValues(const io::VoxelFrame& frame)
  {
    for (std::size_t i = 0; frame.hasIntensities() && i < frame.size(); ++i) {
      prefetch(records_.intensities.data() + (hits_[i + ahead] >> 1));
      records_.intensities[hits_[i] >> 1].add(
          valueOf(frame, i), (hits_[i] & 1) == 0, usual_intensities_);
    }
    for (std::size_t i = 0; frame.colour_bits > 0 && i < frame.size(); ++i) {
      HeldColour& colour = records_.colours[hits_[i] >> 1];
      const bool is_first = (hits_[i] & 1) == 0;
      colour[0].add(frame.colours[i].r, is_first, usual_colours_);
      colour[1].add(frame.colours[i].g, is_first, usual_colours_);
      colour[2].add(frame.colours[i].b, is_first, usual_colours_);
    }
  }

  /** \brief Appends a voxel that has a record in another history. */
  void
  add(std::uint64_t key, bool is_shown, const VoxelRecords& from, std::size_t record)
  {
    const std::uint64_t block = key >> io::block_key_bits;
    const auto cell = static_cast<unsigned int>(key % io::block_cells);
    if (tracked_.empty() || tracked_.back().key != block)
      tracked_.push_back({block, 0, 0, 0, {}});
    TrackedBlock& last = tracked_.back();
    if (((last.shown | last.seldom) >> (cell & ~7u) & 0xff) == 0)
      last.records[cell >> 3] =
          records_.allocate(!from.intensities.empty(), !from.colours.empty());
    (is_shown ? last.shown : last.seldom) |= std::uint64_t{1} << cell;
    const std::size_t to = last.recordOf(cell);
    records_.voxels[to] = from.voxels[record];
    if (!from.intensities.empty())
      records_.intensities[to] = from.intensities[record];
    if (!from.colours.empty())
      records_.colours[to] = from.colours[record];
    ++count_;
  }

  std::vector<TrackedBlock> tracked_; // ascending
  VoxelRecords records_;              // of their voxels
  std::size_t count_ = 0;             // of these
  UsualDeviations usual_intensities_;
  UsualDeviations usual_colours_;
  // Of the current frame; members so that their memory is reused.
  MergedBlocks merged_;
  std::vector<std::uint32_t>
      hits_; // records of the frame's voxels, twice, plus 1 if old
  std::vector<std::uint32_t> shown_; // records of the shown ones
  std::vector<std::uint64_t> keys_;  // of these
  std::vector<std::uint16_t> intensities_;
  std::vector<io::VoxelColour> colours_;
};

} // namespace pcl_ext::PCL_EXT_ABI
