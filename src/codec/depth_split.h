// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/voxel_frame.h>

#include "voxels/voxel_block.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Prediction for a voxel with a depth model, from previous frames. */
struct DepthPrediction {
  bool is_tracked = false;    ///< if not, the members below are not used
  std::uint8_t roughness = 0; ///< running mean of the residual, in sixteenths
  std::int16_t offset = 0;    ///< depth offset, in units of 2^-14 of a point's symbol
};

/** \brief Observations of a frame with a depth model, one element for each voxel. */
struct DepthObservations {
  std::vector<std::int16_t> offsets;   ///< as DepthPrediction::offset
  std::vector<std::uint8_t> residuals; ///< clamped to 15
};

/** \brief Splits intensity symbols that depend on depth into a number of points, which
 * is coded like a count, and a small residual (doc/bitstream.md, "Depth model").
 *
 * A voxel of n points at depth z has an intensity of about n I_p(z). It differs by the
 * depth offset of the points from the voxel's centre, which varies little from frame to
 * frame. Integers only.
 */
class DepthSplit {
public:
  /** \brief Class of a voxel whose base symbol is its symbol: a point adds less than
   * one to the symbol there, so that the number of points cannot be derived. */
  static constexpr std::uint8_t no_residual = 0xff;

  /** \brief Classes of residuals are below this. */
  static constexpr std::uint8_t class_count = 192;

  /** \brief Begins a frame.
   * \param[in] model symbol of a point by its depth
   * \param[in] frame the frame's blocks
   * \param[in] predictions one for each voxel, or none at all
   * \param[in] max_symbol the highest symbol
   */
  void
  begin(const DepthModel& model,
        const BlockList& frame,
        const std::vector<DepthPrediction>& predictions,
        std::uint32_t max_symbol);

  /** \brief Encoder only: derives the base symbols from the symbols. */
  void
  baseSymbolsOf(const std::vector<std::uint16_t>& symbols,
                std::vector<std::uint16_t>& base_symbols) const;

  /** \brief Predicts the symbols from the base symbols; to be called before the
   * functions below. */
  void
  predict(const std::vector<std::uint16_t>& base_symbols);

  /** \brief The class of each voxel's residual, or no_residual. */
  const std::vector<std::uint8_t>&
  classes() const
  {
    return classes_;
  }

  /** \brief Context of the residual by the prediction: its fraction in sixteenths,
   * 0..15, plus 16 times the bit length of half the symbol, 0..7. */
  std::uint32_t
  predictionContext(std::size_t voxel) const
  {
    return contexts_[voxel];
  }

  /** \brief Class of a voxel's number of points, 0..3. */
  std::uint32_t
  pointClass(std::size_t voxel) const
  {
    return point_classes_[voxel];
  }

  /** \brief The residual of a voxel: 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ... */
  std::uint32_t
  residual(std::size_t voxel, std::uint16_t symbol) const
  {
    const std::int32_t distance = static_cast<std::int32_t>(symbol) -
                                  static_cast<std::int32_t>(predicted_[voxel]);
    return distance < 0 ? static_cast<std::uint32_t>(-2 * distance - 1)
                        : static_cast<std::uint32_t>(2 * distance);
  }

  /** \brief The symbol of a residual.
   * \param[in] voxel index of the voxel
   * \param[in] residual as returned by residual()
   * \param[out] symbol the symbol
   * \return false if there is no such symbol
   */
  bool
  symbol(std::size_t voxel, std::uint32_t residual, std::uint16_t& symbol) const;

  /** \brief Computes the observations of a frame whose symbols are known. */
  void
  observe(const std::vector<std::uint16_t>& base_symbols,
          const std::vector<std::uint16_t>& symbols,
          DepthObservations& depths) const;

private:
  std::uint32_t max_symbol_ = 0;
  // By voxel: what a point adds to the symbol, in units of 2^-16, at the centre, and
  // with the depth offset; and the class of the roughness.
  std::vector<std::uint64_t> centre_symbols_;
  std::vector<std::uint64_t> point_symbols_;
  std::vector<std::uint8_t> roughness_;
  std::vector<std::uint16_t> predicted_; // symbols
  std::vector<std::uint8_t> classes_;
  std::vector<std::uint8_t> contexts_;
  std::vector<std::uint8_t> point_classes_;
};

} // namespace pcl_ext::PCL_EXT_ABI::io
