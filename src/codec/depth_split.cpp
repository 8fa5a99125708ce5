// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/depth_split.h"

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr std::uint64_t one_symbol = std::uint64_t{1} << 16;
// Depth offsets are fractions of the point's symbol, in units of 2^-14.
constexpr std::int64_t one_offset = std::int64_t{1} << 14;
constexpr std::int64_t largest_offset = one_offset / 2;

/** \brief Bit length of half a symbol, 0..7.
 * \param[in] exact the symbol, in units of 2^-16
 */
std::uint32_t
sizeOf(std::uint64_t exact)
{
  const auto half =
      static_cast<std::uint32_t>(std::min<std::uint64_t>(exact >> 17, 127));
  return half == 0 ? 0 : highestBit(half) + 1;
}

/** \brief Class of a residual: by size and fraction of the prediction, and the
 * roughness.
 * \param[in] exact prediction of the symbol, in units of 2^-16
 * \param[in] roughness 0..5
 */
std::uint8_t
residualClass(std::uint64_t exact, std::uint32_t roughness)
{
  const auto fraction = static_cast<std::uint32_t>(exact >> 14 & 3);
  return static_cast<std::uint8_t>((sizeOf(exact) * 4 + fraction) * 6 + roughness);
}

/** \brief Class of the roughness of a tracked voxel, 1..5. */
std::uint8_t
roughnessClass(std::uint32_t roughness)
{
  return roughness < 6    ? 1
         : roughness < 14 ? 2
         : roughness < 24 ? 3
         : roughness < 48 ? 4
                          : 5;
}

} // namespace

void
DepthSplit::begin(const DepthModel& model,
                  const BlockList& frame,
                  const std::vector<DepthPrediction>& predictions,
                  std::uint32_t max_symbol)
{
  max_symbol_ = max_symbol;
  const auto depthOf = [&](std::uint64_t key) {
    const VoxelPosition position = voxelPosition(key);
    return std::int64_t{model.step[0]} * position.x +
           std::int64_t{model.step[1]} * position.y +
           std::int64_t{model.step[2]} * position.z;
  };
  std::array<std::int64_t, block_cells> cell_depth;
  for (unsigned int cell = 0; cell < block_cells; ++cell)
    cell_depth[cell] = depthOf(cell);
  centre_symbols_.clear();
  for (std::size_t block = 0; block < frame.size(); ++block) {
    const std::int64_t depth =
        model.origin + depthOf(frame.keys[block] << block_key_bits);
    for (std::uint64_t cells = frame.masks[block]; cells != 0; cells &= cells - 1)
      centre_symbols_.push_back(
          model.pointSymbolAt(depth + cell_depth[lowestBit(cells)]));
  }
  point_symbols_.assign(centre_symbols_.begin(), centre_symbols_.end());
  roughness_.assign(centre_symbols_.size(), 0);
  for (std::size_t i = 0; i < predictions.size(); ++i)
    if (predictions[i].is_tracked) {
      const std::int64_t factor = one_offset + predictions[i].offset;
      point_symbols_[i] = centre_symbols_[i] * static_cast<std::uint64_t>(factor) >> 14;
      roughness_[i] = roughnessClass(predictions[i].roughness);
    }
}

void
DepthSplit::baseSymbolsOf(const std::vector<std::uint16_t>& symbols,
                          std::vector<std::uint16_t>& base_symbols) const
{
  base_symbols.resize(symbols.size());
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    const std::uint64_t point_symbol = point_symbols_[i];
    base_symbols[i] =
        point_symbol < one_symbol
            ? symbols[i]
            : static_cast<std::uint16_t>(
                  ((static_cast<std::uint64_t>(symbols[i]) << 16) + point_symbol / 2) /
                  point_symbol);
  }
}

void
DepthSplit::predict(const std::vector<std::uint16_t>& base_symbols)
{
  predicted_.resize(base_symbols.size());
  classes_.resize(base_symbols.size());
  contexts_.resize(base_symbols.size());
  point_classes_.resize(base_symbols.size());
  for (std::size_t i = 0; i < base_symbols.size(); ++i) {
    const std::uint64_t exact = base_symbols[i] * point_symbols_[i];
    const auto predicted = static_cast<std::uint32_t>(
        std::min<std::uint64_t>((exact + one_symbol / 2) >> 16, max_symbol_));
    predicted_[i] = static_cast<std::uint16_t>(predicted);
    contexts_[i] = static_cast<std::uint8_t>(sizeOf(exact) * 16 + (exact >> 12 & 15));
    const unsigned int base_symbol = base_symbols[i];
    point_classes_[i] = base_symbol < 2   ? 0
                        : base_symbol < 3 ? 1
                        : base_symbol < 6 ? 2
                                          : 3;
    classes_[i] = point_symbols_[i] < one_symbol ? no_residual
                                                 : residualClass(exact, roughness_[i]);
  }
}

bool
DepthSplit::symbol(std::size_t voxel,
                   std::uint32_t residual,
                   std::uint16_t& symbol) const
{
  if (residual > 2 * max_symbol_)
    return false;
  const auto half = static_cast<std::int32_t>(residual >> 1);
  const std::int32_t distance = (residual & 1) != 0 ? -half - 1 : half;
  const std::int32_t value = static_cast<std::int32_t>(predicted_[voxel]) + distance;
  if (value < 0 || value > static_cast<std::int32_t>(max_symbol_))
    return false;
  symbol = static_cast<std::uint16_t>(value);
  return true;
}

void
DepthSplit::observe(const std::vector<std::uint16_t>& base_symbols,
                    const std::vector<std::uint16_t>& symbols,
                    DepthObservations& depths) const
{
  depths.offsets.resize(base_symbols.size());
  depths.residuals.resize(base_symbols.size());
  for (std::size_t i = 0; i < base_symbols.size(); ++i) {
    depths.offsets[i] = 0;
    depths.residuals[i] =
        classes_[i] == no_residual
            ? std::uint8_t{0}
            : static_cast<std::uint8_t>(std::min(residual(i, symbols[i]), 15u));
    // The depth of the points cannot be derived from a saturated symbol.
    if (classes_[i] == no_residual || base_symbols[i] == 0 || symbols[i] == max_symbol_)
      continue;
    const auto centred =
        static_cast<std::int64_t>(base_symbols[i] * centre_symbols_[i]);
    const std::int64_t distance = (std::int64_t{symbols[i]} << 16) - centred;
    depths.offsets[i] = static_cast<std::int16_t>(
        std::clamp(distance * one_offset / centred, -largest_offset, largest_offset));
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::io
