/** \file
 * \brief Writes payloads of the effort fast choice by choice, as doc/bitstream_fast.md
 * has them: also such as no encoder makes.
 */
#pragma once

#include "codec/fast/byte_table.h"
#include "codec/fast/entropy_coder.h"
#include "codec/fast/models.h"
#include "codec/fast/symbol_statistics.h"
#include "support/voxel_frames.h"
#include "voxels/voxel_block.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext {
namespace io {
namespace test {

using namespace fast;

constexpr std::uint32_t lowest_rans_state = 1u << 15;

/** \brief How a rANS stream is written: as encoders do unless said otherwise. */
struct RansChoices {
  std::size_t states = 1;
  /** \brief What the states are behind the last symbol. */
  std::array<std::uint32_t, 4> ends = {
      lowest_rans_state, lowest_rans_state, lowest_rans_state, lowest_rans_state};
  /** \brief The state that starts outside of its range, 0..3: with its first symbol a word
   * is read where none is due, or none where one is. */
  std::size_t wrong_start = static_cast<std::size_t>(-1);
};

/** \brief What came of it. */
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

  /** \param[in] before models as they are before the frame */
  explicit FastScript(const Models& before) : models(before) {}

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

  template <std::size_t contexts>
  void
  byte(ByteModels<contexts>& byte_models, unsigned int context, unsigned int number)
  {
    coder_.reserve(2);
    codeByte(coder_, byte_models, context, number);
  }

  /** \brief The voxels of a past, all of them in one bucket; bit k is voxel k. */
  void
  knownVoxels(unsigned int past, unsigned int count, std::uint64_t occupied)
  {
    for (; count >= 8; count -= 8, occupied >>= 8)
      code(occupancyTable(models.known_probability[past]),
           static_cast<unsigned int>(occupied & 0xff));
    BitModel rest(models.known_probability[past]);
    for (; count > 0; --count, occupied >>= 1)
      code(rest, static_cast<unsigned int>(occupied & 1));
  }

  /** \brief Where the new voxels of a block without activity are. */
  void
  octants(bool is_empty, unsigned int symbol)
  {
    code(models.octant[is_empty ? 1 : 0], symbol);
  }

  /** \brief Where the new voxels of an octant are.
   * \param[in] near number of near cells
   * \param[in] open number of open cells
   */
  void
  cells(unsigned int near, unsigned int open, unsigned int symbol)
  {
    code(models.cell[3 * std::min(near, 7u) + (open == 8  ? 0u
                                               : open > 4 ? 1u
                                                          : 2u)],
         symbol);
  }

  void
  noNewBlocks()
  {
    code(models.has_new_blocks, 0);
  }

  /** \brief A new block's voxels.
   * \param[in] octants those that are said to have voxels
   */
  void
  newBlock(bool is_i_frame, unsigned int octants, std::uint64_t voxels)
  {
    const std::size_t kind = is_i_frame ? 1 : 0;
    byte(models.new_block_octants[kind], 0, octants);
    std::uint64_t coded = 0;
    for (unsigned int octant = 0; octant < 8; ++octant) {
      if ((octants >> octant & 1) == 0)
        continue;
      const std::uint64_t here = voxels & std::uint64_t{0xff} << 8 * octant;
      byte(models.new_block_cells[kind],
           static_cast<unsigned int>(cellsBeside(coded) >> 8 * octant & 15),
           static_cast<unsigned int>(here >> 8 * octant));
      coded |= here;
    }
  }

  void
  newBlock(bool is_i_frame, std::uint64_t voxels)
  {
    newBlock(is_i_frame, occupiedOctants(voxels), voxels);
  }

  /** \brief Plain symbols of up to eight bits. */
  void
  plainSymbols(std::size_t count, unsigned int symbol)
  {
    bits(1, 1);
    for (std::size_t i = 0; i < count; ++i)
      byte(models.plain, 0, symbol);
  }

  /** \brief What comes in front of symbols that are not plain. */
  void
  beginSteps(unsigned int origin)
  {
    bits(1, 0);
    bits(1, origin);
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
    code(models.new_symbol[1][symbol_statistics::contextOf(running_)], symbol);
    running_ = symbol_statistics::next(running_, step);
  }

  void
  newStep(unsigned int step)
  {
    newStep(step - symbol_statistics::lowestBin(running_), step);
  }

  /** \brief The same as an encoder does, but for the bits within the step. */
  void
  newStepOrWhole(unsigned int step)
  {
    const unsigned int nibble =
        std::min(step - symbol_statistics::lowestBin(running_), 15u);
    newStep(nibble, step);
    if (nibble == 15)
      wholeStep(step);
  }

  /** \brief The step of a known voxel that had one step before, as a nibble. */
  void
  knownStep(unsigned int step_before, unsigned int symbol)
  {
    code(models.known_symbol[symbol_statistics::contextOf(
             symbol_statistics::first(step_before))],
         symbol);
  }

  void
  wholeStep(unsigned int step)
  {
    code(models.escape_high, step / 16);
    code(models.escape_low[step / 16 % 8], step % 16);
  }

  RansBytes
  rans(const RansChoices& choices = RansChoices()) const
  {
    return ransBytes(
        {steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(coder_.mark())},
        choices);
  }

  Models models;

private:
  std::vector<std::uint32_t> steps_;
  NibbleEncoder coder_{steps_};
  std::uint16_t running_ = 0;
};

} // namespace test
} // namespace io
} // namespace pcl_ext
