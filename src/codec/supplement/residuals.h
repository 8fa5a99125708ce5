// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/rans/nibble_model.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace supplement {

/** \brief Models of residuals, by how large those before were
 * (doc/bitstream_supplement.md, "Residuals"). */
struct ResidualModels {
  static constexpr std::size_t class_count = 21;

  std::array<rans::NibbleModel, class_count> folded;
};

/** \brief 0, -1, 1, -2, 2, ... as 0, 1, 2, 3, 4, ...; where the values of one side are
 * used up, those of the other one follow each other.
 * \param[in] residual of the prediction; their sum is within 0..highest
 * \param[in] predicted 0..highest
 * \param[in] highest value, below 2^16
 */
constexpr std::uint32_t
foldResidual(std::int32_t residual, std::int32_t predicted, std::int32_t highest)
{
  const std::int32_t reach = std::min(predicted, highest - predicted);
  const std::int32_t distance = residual < 0 ? -residual : residual;
  if (distance > reach)
    return static_cast<std::uint32_t>(reach + distance);
  return static_cast<std::uint32_t>(2 * distance - (residual < 0 ? 1 : 0));
}

/** \brief Inverse of foldResidual, for 0..highest. */
constexpr std::int32_t
unfoldResidual(std::uint32_t folded, std::int32_t predicted, std::int32_t highest)
{
  const std::int32_t reach = std::min(predicted, highest - predicted);
  const auto number = static_cast<std::int32_t>(folded);
  if (number > 2 * reach)
    return predicted > reach ? reach - number : number - reach;
  return (number & 1) != 0 ? -(number + 1) / 2 : number / 2;
}

/** \brief Codes the residuals of predicted values, one after the other. */
class ResidualCoding {
public:
  /** \brief Symbols to reserve for a value. */
  static constexpr std::size_t most_symbols = 16;

  /** \param[in] highest value, 1..65535 */
  ResidualCoding(ResidualModels& models, std::int32_t highest)
  : models_(&models), highest_(highest)
  {}

  /** \brief Codes a value.
   * \param[in,out] coding a NumberCoding
   * \param[in] predicted value, 0..highest
   * \param[in,out] value 0..highest; the decoder sets it
   * \return false if what was decoded is no value
   */
  template <typename CodingT>
  PCL_EXT_ALWAYS_INLINE bool
  code(CodingT& coding, std::int32_t predicted, std::int32_t& value)
  {
    const std::size_t residual_class = activity_ < 16 ? 0 : highestBit(activity_) - 3;
    // Bits well below the mean residual are noise.
    const auto raw_bits =
        static_cast<unsigned int>(residual_class > 5 ? residual_class - 5 : 0);
    const std::uint32_t target =
        CodingT::is_decoder ? 0 : foldResidual(value - predicted, predicted, highest_);
    const std::uint64_t high =
        coding.code(models_->folded[residual_class], target >> raw_bits);
    if (high > static_cast<std::uint32_t>(highest_) >> raw_bits)
      return false;
    const std::uint32_t folded = static_cast<std::uint32_t>(high) << raw_bits |
                                 static_cast<std::uint32_t>(coding.codeBits(
                                     target & ((1u << raw_bits) - 1), raw_bits));
    if (folded > static_cast<std::uint32_t>(highest_) || coding.isOverrun())
      return false;
    const std::int32_t residual = unfoldResidual(folded, predicted, highest_);
    value = predicted + residual;
    activity_ += 16 * static_cast<std::uint32_t>(std::abs(residual)) - activity_ / 16;
    return true;
  }

private:
  ResidualModels* models_;
  std::int32_t highest_;
  /** \brief 256 times the mean size of the last residuals, sixteen or so. */
  std::uint32_t activity_ = 512;
};

} // namespace supplement
} // namespace pcl_ext::PCL_EXT_ABI::io
