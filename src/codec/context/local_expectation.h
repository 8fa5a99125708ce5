// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/reserve_ahead.h"
#include "codec/context/intensity_neighbours.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace context {

/** \brief Units of logarithms in an octave. */
constexpr int octave = 64;

/** \brief Logarithm to base 2, in units of 1/64, linear within an octave.
 * \param[in] number not 0
 */
inline int
logarithmOf(std::uint32_t number)
{
  const unsigned int octaves = highestBit(number);
  const std::uint64_t scaled = std::uint64_t{number} * octave >> octaves;
  return (static_cast<int>(octaves) - 1) * octave + static_cast<int>(scaled);
}

/** \brief The number, rounded down, that has a logarithm of 0 or more. */
inline std::uint32_t
numberOf(int logarithm)
{
  const auto scaled = static_cast<std::uint64_t>(octave + logarithm % octave);
  return static_cast<std::uint32_t>((scaled << logarithm / octave) / octave);
}

/** \brief What is learnt about symbols on surfaces (doc/bitstream_context.md, "Local
 * expectation"). */
struct LocalModels {
  /** \brief Masks of faces with a neighbour. */
  static constexpr std::size_t shapes = 64;

  LocalModels() { errors.fill(64 << 8); }

  // Logarithms, in units of 2^-8 of those above.
  std::array<std::int32_t, shapes> shares{}; ///< of the surface that a voxel has
  std::array<std::int32_t, shapes> errors;   ///< mean error of what was expected
  /** \brief Mean of by how much the error of the other expectation was larger, of voxels
   * without and with a record. */
  std::array<std::int32_t, 2> gains{};
  /** \brief Encoder only: frames that are coded without before it is tried again. */
  std::uint32_t frames_without = 0;
};

/** \brief Expects a voxel's symbol from those of its lower neighbours, smoothed along
 * the surface, and from the faces that have a neighbour: these tell how much of the
 * surface the voxel has. */
class LocalExpectation {
public:
  /** \brief Least logarithm of what is expected: that of 0. */
  static constexpr int least = 3 * octave;

  /** \brief Begins a frame.
   * \param[in,out] memory for a number for each voxel
   * \param[in] voxels number of voxels
   */
  LocalExpectation(LocalModels& models,
                   std::vector<std::uint32_t>& memory,
                   std::size_t voxels)
  : models_(models), smoothed_(memory)
  {
    reserveAhead(smoothed_, voxels);
    smoothed_.resize(voxels);
  }

  /** \brief Expects the symbol of a cell of the selected block. */
  void
  expect(const IntensityNeighbours& neighbours, unsigned int cell)
  {
    faces_ = neighbours.facesOf(cell);
    std::uint32_t sum = 0;
    std::uint32_t count = 0;
    neighbours.visitEachSide(cell, [&](std::size_t voxel, std::uint32_t is_there) {
      sum += smoothed_[voxel] * is_there;
      count += is_there;
    });
    around_ = count == 0 ? running_ : count == 3 ? sum / 3 : sum >> (count - 1);
    constexpr int most = 21 * octave - 1;
    logarithm_ = std::clamp(logarithmOf(around_) - fraction_octaves * octave +
                                (models_.shares[faces_] >> 8),
                            least,
                            most);
  }

  /** \brief Logarithm of what is expected, in sixteenths of a symbol, and 8. */
  int
  logarithm() const
  {
    return logarithm_;
  }

  /** \brief The same in sixteenths of a symbol. */
  std::uint32_t
  sixteenths() const
  {
    return numberOf(logarithm_) - 8;
  }

  /** \brief Which faces of the cell have a neighbour, a mask. */
  std::uint32_t
  faces() const
  {
    return faces_;
  }

  /** \brief Mean error of the logarithm at such cells. */
  std::uint32_t
  error() const
  {
    return static_cast<std::uint32_t>(models_.errors[faces_] >> 8);
  }

  /** \brief Whether it has been closer lately than what is expected otherwise. */
  bool
  isCloser(bool is_tracked) const
  {
    return models_.gains[is_tracked ? 1 : 0] >= 0;
  }

  /** \brief Adapts to a symbol.
   * \param[in] voxel its index
   * \param[in] other what was expected otherwise, in sixteenths
   * \param[in] is_tracked whether that is of a record
   */
  void
  learn(std::size_t voxel, std::uint32_t symbol, std::uint32_t other, bool is_tracked)
  {
    constexpr int longest = 4 * octave;
    constexpr std::int32_t largest_share = 8 * octave << 8;
    const int exact = logarithmOf(16 * symbol + 8);
    const int error = std::clamp(exact - logarithm_, -longest, longest);
    const int size = std::abs(error);
    const int other_size = std::abs(exact - logarithmOf(other + 8));
    std::int32_t& gain = models_.gains[is_tracked ? 1 : 0];
    gain += ((other_size - size) * 256 - gain) >> 7;
    models_.errors[faces_] += (size * 256 - models_.errors[faces_]) >> 6;
    std::int32_t& share = models_.shares[faces_];
    share = std::clamp(share + 8 * error, -largest_share, largest_share);
    const auto closer = [exact_symbol = (16 * symbol + 8)
                                        << fraction_octaves](std::uint32_t smoothed) {
      return smoothed - smoothed / 4 + exact_symbol / 4;
    };
    smoothed_[voxel] = closer(around_);
    running_ = closer(running_);
  }

private:
  /** \brief Smoothed symbols are in units of 2^-4 sixteenths. */
  static constexpr int fraction_octaves = 4;

  LocalModels& models_;
  std::vector<std::uint32_t>& smoothed_;           ///< of each voxel before
  std::uint32_t running_ = 40 << fraction_octaves; ///< that of the voxels before
  // Of the voxel that is coded.
  std::uint32_t around_ = 0;
  std::uint32_t faces_ = 0;
  int logarithm_ = 0;
};

} // namespace context
} // namespace pcl_ext::PCL_EXT_ABI::io
