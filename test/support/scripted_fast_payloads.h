// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Writes payloads of the effort fast choice by choice, as doc/bitstream_fast.md
 * has them: also such as no encoder makes.
 */
#pragma once

#include "codec/fast/models.h"
#include "codec/fast/symbol_statistics.h"
#include "codec/rans/byte_table.h"
#include "codec/rans/entropy_coder.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::test {

using namespace fast;
using namespace rans;

constexpr std::uint32_t lowest_rans_state = 1u << 15;

/** \brief How a rANS stream is written: as encoders do unless said otherwise. */
struct RansChoices {
  std::size_t states = 1;
  std::array<std::uint32_t, 4> ends = {
      lowest_rans_state, lowest_rans_state, lowest_rans_state, lowest_rans_state};
  /** \brief The state that starts outside of its range, 0..3: with its first symbol a
   * word is read where none is due, or none where one is. */
  std::size_t wrong_start = static_cast<std::size_t>(-1);
};

struct RansBytes {
  Bytes bytes;
  std::array<std::uint32_t, 4> starts{};
};

/** \brief The bytes of a row of symbols.
 * \param[in] steps each symbol's start + 2^16 * width
 */
inline RansBytes
ransBytes(const std::vector<std::uint32_t>& steps, const RansChoices& choices)
{
  RansBytes rans;
  rans.starts = choices.ends;
  std::vector<std::uint32_t> words; // the last one first
  for (std::size_t i = steps.size(); i-- > 0;) {
    std::uint32_t& state = rans.starts[i % choices.states];
    const std::uint32_t width = steps[i] >> 16;
    const bool is_due = state >= width << 19;
    if (is_due != (i == choices.wrong_start)) {
      words.push_back(state & 0xffff);
      state >>= 16;
    }
    state = (state / width << 12) + state % width + (steps[i] & 0xffff);
  }
  for (std::size_t k = 0; k < choices.states; ++k)
    for (unsigned int shift = 0; shift < 32; shift += 8)
      rans.bytes.push_back(static_cast<std::uint8_t>(rans.starts[k] >> shift));
  for (; !words.empty(); words.pop_back())
    for (unsigned int shift = 0; shift < 16; shift += 8)
      rans.bytes.push_back(static_cast<std::uint8_t>(words.back() >> shift));
  return rans;
}

/** \brief A payload that is written choice by choice. What is said of blocks and voxels
 * must be said in the order of the bitstream. */
class FastScript {
public:
  FastScript() = default;

  /** \brief A P-frame with the history.
   * \param[in] before models as they are before the frame
   */
  explicit FastScript(const Models& before) : models(before) { bits(1, 1); }

  FastScript(const FastScript&) = delete;
  FastScript&
  operator=(const FastScript&) = delete;

  void
  bits(unsigned int count, unsigned int number)
  {
    coder_.reserve(1);
    coder_.codeBits(count, number);
  }

  template <class Model>
  void
  code(Model& model, unsigned int symbol)
  {
    coder_.reserve(1);
    coder_.code(model, symbol);
  }

  void
  mask(MaskModels& mask_models, unsigned int likely, unsigned int children)
  {
    coder_.reserve(2);
    codeMask(coder_, mask_models, likely, children);
  }

  /** \brief The voxels of a past, all of them in one bucket; bit k is voxel k. */
  void
  trackedVoxels(unsigned int past, unsigned int count, std::uint64_t occupied)
  {
    for (; count >= 8; count -= 8, occupied >>= 8)
      code(occupancyTable(models.tracked_probability[past]),
           static_cast<unsigned int>(occupied & 0xff));
    BitModel rest(models.tracked_probability[past]);
    for (; count > 0; --count, occupied >>= 1)
      code(rest, static_cast<unsigned int>(occupied & 1));
  }

  /** \brief Where the new voxels of a block are that the frame before brought. */
  void
  octants(bool is_empty, unsigned int symbol)
  {
    code(models.octant[is_empty ? 3 : 2], symbol);
  }

  /** \brief Where the new voxels of an octant are.
   * \param[in] near number of near cells
   * \param[in] open number of open cells
   */
  void
  cells(unsigned int near, unsigned int open, unsigned int symbol)
  {
    code(models.cell[3 * std::min(near, 3u) + (open == 8  ? 0u
                                               : open > 4 ? 1u
                                                          : 2u)],
         symbol);
  }

  /** \brief The mask of a node's children. */
  void
  node(unsigned int children, unsigned int likely = 0, unsigned int upper = 0)
  {
    coder_.reserve(2);
    codeNode(coder_, models.node, likely, upper, children);
  }

  void
  noNewBlocks()
  {
    node(0);
  }

  /** \brief The octree of new voxels.
   * \param[in] levels of the octree, two at least
   * \param[in] keys Morton keys of the voxels
   */
  void
  newVoxels(unsigned int levels, const std::set<std::uint64_t>& keys)
  {
    for (unsigned int level = levels; level-- > 0;) {
      std::map<std::uint64_t, unsigned int> masks;
      for (const std::uint64_t key : keys)
        masks[key >> 3 * (level + 1)] |= 1u << (key >> 3 * level & 7);
      for (const auto& [node_key, children] : masks)
        node(children,
             likelyChildren(node_key, masks),
             upperNeighbours(node_key, masks));
    }
  }

  void
  beginSteps()
  {
    running_ = symbol_statistics::first(2);
  }

  /** \brief The step of an I-frame's voxel, as a nibble; a 15 is followed by
   * wholeStep.
   * \param[in] symbol the nibble
   * \param[in] step the step that it comes to
   */
  void
  newStep(unsigned int symbol, unsigned int step)
  {
    code(models.symbols.running_symbol[symbol_statistics::contextOf(running_)], symbol);
    running_ = symbol_statistics::next(running_, step);
  }

  void
  newStep(unsigned int step)
  {
    newStep(step - symbol_statistics::lowestBin(running_), step);
  }

  /** \brief The same as an encoder does, except for the bits within the step. */
  void
  newStepOrWhole(unsigned int step)
  {
    const unsigned int nibble =
        std::min(step - symbol_statistics::lowestBin(running_), 15u);
    newStep(nibble, step);
    if (nibble == 15)
      wholeStep(step);
  }

  /** \brief The step of a tracked voxel that had one step before, as a nibble. */
  void
  trackedStep(unsigned int step_before, unsigned int symbol)
  {
    code(models.symbols.symbol[symbol_statistics::contextOf(
             symbol_statistics::first(step_before))],
         symbol);
  }

  /** \brief The step of a P-frame's voxel without statistics, as a nibble. */
  void
  broughtStep(unsigned int symbol)
  {
    code(models.symbols.symbol[125], symbol);
  }

  void
  wholeStep(unsigned int step)
  {
    code(models.symbols.escape_high, step / 16);
    code(models.symbols.escape_low[step / 16 % 8], step % 16);
  }

  RansBytes
  rans(const RansChoices& choices = RansChoices()) const
  {
    return ransBytes(
        {steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(coder_.size())},
        choices);
  }

  Models models;

private:
  /** \brief The children of a node that share a face with children of the nodes below
   * it on each axis. */
  static unsigned int
  likelyChildren(std::uint64_t node_key,
                 const std::map<std::uint64_t, unsigned int>& masks)
  {
    const VoxelPosition index = voxelPosition(node_key);
    unsigned int likely = 0;
    for (unsigned int axis = 0; axis < 3; ++axis) {
      VoxelPosition below = index;
      std::uint32_t& coordinate = axis == 0 ? below.x : axis == 1 ? below.y : below.z;
      if (coordinate == 0)
        continue;
      --coordinate;
      const auto neighbour = masks.find(mortonKey(below));
      for (unsigned int child = 0; neighbour != masks.end() && child < 8; ++child)
        if ((child & 4u >> axis) != 0 && (neighbour->second >> child & 1) != 0)
          likely |= 1u << (child ^ 4u >> axis);
    }
    return likely;
  }

  /** \brief 4, 2 and 1 for the nodes above a node on each axis. */
  static unsigned int
  upperNeighbours(std::uint64_t node_key,
                  const std::map<std::uint64_t, unsigned int>& masks)
  {
    const VoxelPosition index = voxelPosition(node_key);
    const auto isThere = [&](const VoxelPosition& above) {
      return masks.count(mortonKey(above)) > 0 ? 1u : 0u;
    };
    return 4 * isThere({index.x + 1, index.y, index.z}) +
           2 * isThere({index.x, index.y + 1, index.z}) +
           isThere({index.x, index.y, index.z + 1});
  }

  std::vector<std::uint32_t> steps_;
  NibbleEncoder coder_{steps_};
  std::uint16_t running_ = 0;
};

} // namespace pcl_ext::PCL_EXT_ABI::io::test
