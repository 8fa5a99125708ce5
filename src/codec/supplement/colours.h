// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "codec/supplement/colour_history.h"
#include "codec/supplement/residuals.h"
#include "simd/bit_operations.h"
#include "voxels/ascending_keys.h"
#include "voxels/lower_neighbours.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Models of colours: green, red, blue; without and with a past of the voxel. */
struct ColourModels {
  std::array<std::array<ResidualModels, 3>, 2> residuals;
};

/** \brief Codes the colours of a frame's voxels, for either direction: green as a
 * residual of its prediction, red and blue with that of green added to theirs. */
class ColourPass {
public:
  /** \brief A pass over one frame.
   * \param[in] bits of a channel, 1..8
   * \param[in] history before the frame
   */
  ColourPass(ColourModels& models, unsigned int bits, const ColourHistory& history)
  : highest_((1 << bits) - 1)
  , codings_{makeCodings(models.residuals[0]), makeCodings(models.residuals[1])}
  , history_(history)
  , lookup_(history.keys())
  {
    const auto middle = static_cast<std::uint16_t>(8 << bits);
    last_.fill(middle);
  }

  /** \brief Codes the colours of voxels that have few neighbours: each is predicted
   * from the voxel before.
   * \param[in,out] coding a NumberCoding
   * \param[in,out] colours one for each voxel; the decoder fills them
   * \return false if what was decoded are no colours
   */
  template <typename CodingT, class ColoursT>
  bool
  runSparse(CodingT& coding, ColoursT& colours)
  {
    CodingT local = coding; // in registers
    Codings residuals = codings_[0];
    FineColour last = last_;
    for (auto& colour : colours)
      if (!codeColour(local, residuals, last, colour, last))
        return false;
    coding = local;
    return true;
  }

  /** \brief Codes the colours of voxels that have neighbours.
   * \param[in,out] coding a NumberCoding
   * \param[in] blocks of the frame
   * \param[in,out] neighbours begun with these blocks
   * \param[in] keys of the frame
   * \param[in,out] colours one for each voxel; the decoder fills them
   * \return false if what was decoded are no colours
   */
  template <typename CodingT, class ColoursT>
  bool
  runDense(CodingT& coding,
           const BlockList& blocks,
           LowerNeighbours& neighbours,
           const std::vector<std::uint64_t>& keys,
           ColoursT& colours)
  {
    CodingT local = coding; // in registers
    std::size_t voxel = 0;
    for (std::size_t block = 0; block < blocks.size(); ++block) {
      neighbours.moveTo(block);
      for (std::uint64_t cells = blocks.masks[block]; cells != 0;
           cells &= cells - 1, ++voxel) {
        const FineColour near =
            predictFromNeighbours(neighbours, lowestBit(cells), colours);
        if (!codeVoxel(local, keys[voxel], near, colours[voxel]))
          return false;
      }
    }
    coding = local;
    return true;
  }

private:
  struct Codings {
    ResidualCoding green;
    ResidualCoding red;
    ResidualCoding blue;
  };

  Codings
  makeCodings(std::array<ResidualModels, 3>& models) const
  {
    return {ResidualCoding(models[0], highest_),
            ResidualCoding(models[1], highest_),
            ResidualCoding(models[2], highest_)};
  }

  static FineColour
  fine(const std::array<std::int32_t, 3>& channels)
  {
    return {static_cast<std::uint16_t>(16 * channels[0]),
            static_cast<std::uint16_t>(16 * channels[1]),
            static_cast<std::uint16_t>(16 * channels[2])};
  }

  /** \brief The mean colour of the lower neighbours; without any that of the voxel
   * before. */
  FineColour
  predictFromNeighbours(const LowerNeighbours& neighbours,
                        unsigned int cell,
                        const std::vector<VoxelColour>& colours) const
  {
    std::array<unsigned int, 3> sum{};
    unsigned int count = 0;
    neighbours.visit(cell, [&](std::size_t voxel) {
      sum[0] += colours[voxel].r;
      sum[1] += colours[voxel].g;
      sum[2] += colours[voxel].b;
      ++count;
    });
    // Divisors that the compiler knows.
    switch (count) {
    case 0:
      return last_;
    case 1:
      return sixteenths<1>(sum);
    case 2:
      return sixteenths<2>(sum);
    default:
      return sixteenths<3>(sum);
    }
  }

  template <unsigned int count>
  static FineColour
  sixteenths(const std::array<unsigned int, 3>& sum)
  {
    return {static_cast<std::uint16_t>(16 * sum[0] / count),
            static_cast<std::uint16_t>(16 * sum[1] / count),
            static_cast<std::uint16_t>(16 * sum[2] / count)};
  }

  template <typename CodingT, class ColourT>
  PCL_EXT_ALWAYS_INLINE bool
  codeVoxel(CodingT& coding, std::uint64_t key, const FineColour& near, ColourT& colour)
  {
    const std::size_t record = lookup_.find(key);
    if (record == not_in_list)
      return codeColour(coding, codings_[0], near, colour, last_);
    const FineColour& past = history_.records()[record].mean;
    FineColour prediction;
    for (std::size_t channel = 0; channel < 3; ++channel)
      prediction[channel] = static_cast<std::uint16_t>(
          (past[channel] * weight_of_past_ + near[channel] * (16 - weight_of_past_)) /
          16);
    if (!codeColour(coding, codings_[1], prediction, colour, last_))
      return false;
    error_of_near_ += distance(near) - error_of_near_ / 16;
    error_of_past_ += distance(past) - error_of_past_ / 16;
    if (++tracked_voxels_ % 32 == 0)
      weight_of_past_ = 16 * error_of_near_ / (error_of_near_ + error_of_past_);
    return true;
  }

  /** \brief Codes a colour.
   * \param[out] coded the same
   */
  template <typename CodingT, class ColourT>
  PCL_EXT_ALWAYS_INLINE bool
  codeColour(CodingT& coding,
             Codings& codings,
             const FineColour& prediction,
             ColourT& colour,
             FineColour& coded) const
  {
    const auto predicted = [&](std::size_t channel, std::int32_t of_green) {
      return std::clamp((prediction[channel] + 8) / 16 + of_green, 0, highest_);
    };
    coding.reserve(3 * ResidualCoding::most_symbols);
    // One after the other, not in a loop, so that all state is in registers.
    std::array<std::int32_t, 3> channels = {colour.r, colour.g, colour.b};
    const std::int32_t predicted_green = predicted(1, 0);
    if (!codings.green.code(coding, predicted_green, channels[1]))
      return false;
    const std::int32_t of_green = channels[1] - predicted_green;
    if (!codings.red.code(coding, predicted(0, of_green), channels[0]) ||
        !codings.blue.code(coding, predicted(2, of_green), channels[2]))
      return false;
    if constexpr (CodingT::is_decoder)
      colour = {static_cast<std::uint8_t>(channels[0]),
                static_cast<std::uint8_t>(channels[1]),
                static_cast<std::uint8_t>(channels[2])};
    coded = fine(channels);
    return true;
  }

  /** \brief How far a prediction was from the last colour, and 1. */
  std::uint32_t
  distance(const FineColour& prediction) const
  {
    std::uint32_t sum = 1;
    for (std::size_t channel = 0; channel < 3; ++channel)
      sum += static_cast<std::uint32_t>(std::abs(prediction[channel] - last_[channel]));
    return sum;
  }

  std::int32_t highest_;
  std::array<Codings, 2> codings_; // without and with a past
  const ColourHistory& history_;
  AscendingLookup<std::uint64_t> lookup_;
  FineColour last_{};
  // How the past and the neighbours weigh: as the other one was wrong lately.
  std::uint32_t error_of_near_ = 256;
  std::uint32_t error_of_past_ = 256;
  std::uint32_t weight_of_past_ = 8; // of 16
  std::uint32_t tracked_voxels_ = 0;
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
