// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "voxelizing/intensity_quantiser.h"

#include <pcl_ext/compression/impl/saturated_float.h>

#include "voxelizing/held_range.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

constexpr unsigned int default_bits = 8;
constexpr unsigned int most_bits = 16;
constexpr unsigned int default_companded_bits = 4;
constexpr double smallest_step = std::numeric_limits<float>::min();

/** \brief Number of bits for the integers up to a value, at least 8; above most_bits if
 * there is no such number. */
unsigned int
bitsOfWholeNumbers(double highest)
{
  unsigned int bits = default_bits;
  while (bits <= most_bits && std::exp2(bits) - 1.0 < highest)
    ++bits;
  return bits;
}

/** \brief True if the scale depends on the values. */
bool
followsValues(const EncoderSettings& settings, IntensityUnit unit)
{
  if (settings.format == StreamFormat::Published)
    return false;
  const bool has_fixed_counts = settings.intensity_range > 0.0f ||
                                (settings.intensity_bits != 0 &&
                                 settings.intensity_curve == IntensityCurve::Linear);
  return unit == IntensityUnit::Native ||
         (unit == IntensityUnit::Points && !has_fixed_counts);
}

} // namespace

IntensityQuantiser::IntensityQuantiser(const EncoderSettings& settings,
                                       IntensityUnit unit,
                                       bool spans_all)
: follows_values_(followsValues(settings, unit))
, spans_all_(spans_all)
, truncates_(settings.format == StreamFormat::Published)
, is_companded_(settings.intensity_curve == IntensityCurve::Companded)
, is_unit_points_(unit == IntensityUnit::Points)
, are_counts_(unit == IntensityUnit::Points || settings.aggregation == Aggregation::Sum)
, unit_factor_(unit == IntensityUnit::Share ? 255.0 : 1.0)
, fixed_bits_(settings.intensity_bits)
, fixed_range_(static_cast<double>(settings.intensity_range))
{
  if (truncates_ || unit == IntensityUnit::Native)
    return;
  if (is_companded_) {
    compandFirstScale(unit);
    return;
  }
  const unsigned int bits = fixed_bits_ != 0 ? fixed_bits_ : default_bits;
  const double full_scale = unit == IntensityUnit::Points ? std::exp2(bits) - 1.0 : 1.0;
  spanScale(0.0, fixed_range_ > 0.0 ? fixed_range_ : full_scale, default_bits);
}

std::size_t
IntensityQuantiser::quantise(const std::vector<double>& values,
                             const CommonStep& step_of_points,
                             bool may_refit,
                             VoxelFrame& frame,
                             std::size_t& vanished)
{
  if (follows_values_)
    followValues(values, step_of_points, may_refit);
  frame.intensity_scale = scale_;
  frame.intensities.resize(values.size());
  const auto offset = static_cast<double>(scale_.offset);
  const auto step = static_cast<double>(scale_.step);
  const auto max_number = static_cast<double>(scale_.maxNumber());
  const double rounding = truncates_ ? 0.0 : 0.5;
  std::size_t out_of_range = 0;
  const double least = truncates_ ? step : 0.5 * step;
  vanished = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = values[i] * unit_factor_;
    const double number = (value - offset) / step + rounding;
    out_of_range += number < 0.0 || number >= max_number + 1.0 ? 1 : 0;
    vanished += std::abs(value) < least && value != 0.0 ? 1 : 0;
    // Not negative when clamped, so that a cast rounds down.
    frame.intensities[i] =
        static_cast<std::uint16_t>(std::clamp(number, 0.0, max_number));
  }
  compandNumbers(frame.intensities);
  return out_of_range;
}

bool
IntensityQuantiser::takesCounts(const std::vector<std::uint32_t>& counts,
                                bool may_refit) const
{
  if (unit_factor_ != 1.0 || scale_.step != 1.0f ||
      (scale_.offset != 0.0f && scale_.offset != 1.0f))
    return false;
  if (!follows_values_)
    return true;
  if (!is_unit_points_ || (may_refit && highest_ > highest_of_default_bits))
    return false;
  const auto highest = std::max_element(counts.begin(), counts.end());
  return highest == counts.end() ||
         *highest - static_cast<std::uint32_t>(scale_.offset) <= scale_.maxNumber();
}

std::size_t
IntensityQuantiser::quantiseCounts(const std::vector<std::uint32_t>& counts,
                                   VoxelFrame& frame) const
{
  frame.intensity_scale = scale_;
  frame.intensities.resize(counts.size());
  // A voxel has at least one point.
  const auto offset = static_cast<std::uint32_t>(scale_.offset);
  const std::uint32_t max_number = scale_.maxNumber();
  std::size_t out_of_range = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::uint32_t number = counts[i] - offset;
    out_of_range += number > max_number ? 1 : 0;
    frame.intensities[i] = static_cast<std::uint16_t>(std::min(number, max_number));
  }
  compandNumbers(frame.intensities);
  return out_of_range;
}

void
IntensityQuantiser::releaseMemory()
{
  sorted_values_ = std::vector<double>();
}

/** \brief Adapts the scale to the values of a frame. After far larger values it is fitted
 * anew, before an I-frame is due: a change of scale makes one. */
void
IntensityQuantiser::followValues(const std::vector<double>& values,
                                 const CommonStep& step,
                                 bool may_refit)
{
  fitScale(values, step, may_refit);
  if (!may_refit && !values.empty() && isTooWide(held_))
    fitScale(values, step, true);
}

/** \brief True if values use hardly any of the scale's numbers, and a scale of their own
 * would be finer. It takes an I-frame each time, so that it is not for values that are
 * only much smaller. */
bool
IntensityQuantiser::isTooWide(const ValueRange& held) const
{
  if (is_exact_ || fixed_range_ > 0.0)
    return false;
  const double few = std::min(8.0, std::sqrt(scale_.maxNumber()) / 2.0);
  const double range = held.highest - automaticOffset(held.lowest, 0);
  return range > 0.0 && range < few * static_cast<double>(scale_.step);
}

void
IntensityQuantiser::fitScale(const std::vector<double>& values,
                             const CommonStep& step,
                             bool may_refit)
{
  const double highest_before = highest_;
  if (may_refit) {
    step_ = CommonStep();
    lowest_ = 0.0;
    highest_ = 0.0;
  }
  step_.add(step);
  // Companded scales divide the range of fractions by themselves.
  const unsigned int divisor =
      is_companded_ && step_.divisor() != 1 ? 0 : step_.divisor();
  if (!values.empty()) {
    const bool keeps_step = !is_companded_ && fixed_bits_ == 0;
    held_ = fixed_range_ > 0.0 || spans_all_
                ? rangeOf(values)
                : heldRange(values, keeps_step ? divisor : 0, lowest_, sorted_values_);
    lowest_ = std::min(lowest_, held_.lowest);
    highest_ = std::max(highest_, held_.highest);
    // The largest count varies around a power of two without another scale each time.
    if (is_unit_points_)
      highest_ = std::max(highest_, std::min(highest_before, 2.0 * held_.highest));
    are_counts_ &= held_.lowest >= 1.0;
  }
  // A change of scale requires an I-frame: the range grows in powers of two, and
  // shrinks only where may_refit allows it.
  const double highest = fixed_range_ > 0.0 ? fixed_range_ : highest_;
  is_exact_ = setExactScale(divisor, highest);
  if (is_exact_)
    return;
  const double offset = automaticOffset(lowest_, 0);
  const double range =
      fixed_range_ > 0.0 ? highest - offset : powerOfTwoAbove(highest - offset);
  if (is_companded_) {
    // Companding halves the number of bits, as a square root does.
    const unsigned int number_bits =
        std::clamp(2 * compandedBits(), default_bits, most_bits);
    spanNumbers(offset, range, range / (std::exp2(number_bits) - 1.0));
  }
  else
    spanScale(offset, range, most_bits);
}

/** \brief Sets a scale of multiples of 1 / divisor up to a value.
 * \param[in] divisor 0: the values are no such multiples
 * \return false if there is none */
bool
IntensityQuantiser::setExactScale(unsigned int divisor, double highest)
{
  if (divisor == 0)
    return false;
  // In steps, which are whole numbers.
  const double offset = automaticOffset(lowest_, divisor);
  const double whole_range = highest * divisor - offset * divisor;
  const unsigned int bits = bitsOfWholeNumbers(whole_range);
  if (bits > most_bits)
    return false;
  // Symbols beyond those that the values need stay unused.
  const unsigned int held_bits = is_companded_ ? bits : std::max(bits, fixed_bits_);
  const double range = fixed_range_ > 0.0 ? whole_range : std::exp2(held_bits) - 1.0;
  if (is_companded_ && are_counts_)
    spanNumbers(1.0, range - 1.0, 1.0);
  else if (is_companded_)
    spanNumbers(offset, range, 1.0);
  else
    spanScale(offset, range / divisor, bits);
  return true;
}

void
IntensityQuantiser::compandFirstScale(IntensityUnit unit)
{
  if (unit == IntensityUnit::Points) {
    const double highest = fixed_range_ > 0.0 ? fixed_range_ : highest_of_default_bits;
    const double range = std::max(highest - 1.0, 1.0);
    spanNumbers(1.0, range, std::max(range / highest_number, 1.0));
  }
  else {
    const double range = unit_factor_ * (fixed_range_ > 0.0 ? fixed_range_ : 1.0);
    spanNumbers(0.0, range, range / highest_of_default_bits);
  }
}

void
IntensityQuantiser::spanNumbers(double offset, double range, double step)
{
  IntensityScale scale;
  scale.bits = compandedBits();
  scale.offset = pcl_ext::detail::saturatedFloat(offset);
  scale.step = pcl_ext::detail::saturatedFloat(std::max(step, smallest_step));
  // Minus a tolerance for rounding errors.
  const double highest = std::ceil(range / step - 1e-6);
  const auto max_number =
      static_cast<std::uint32_t>(std::clamp(highest, 1.0, highest_number));
  if (max_number > scale.maxSymbol())
    scale.companded_range = max_number;
  if (scale == scale_)
    return;
  // Cleared first, so that scale and levels agree if memory runs out.
  scale_ = IntensityScale();
  levels_.clear();
  if (scale.companded_range != 0)
    for (std::uint32_t level = 0; level <= scale.maxSymbol(); ++level)
      levels_.resize(compandedEdge(scale.bits, max_number, level + 1),
                     static_cast<std::uint16_t>(level));
  scale_ = scale;
}

unsigned int
IntensityQuantiser::compandedBits() const
{
  return fixed_bits_ != 0 ? fixed_bits_ : default_companded_bits;
}

void
IntensityQuantiser::compandNumbers(std::vector<std::uint16_t>& numbers) const
{
  if (levels_.empty())
    return;
  for (std::uint16_t& number : numbers)
    number = levels_[number];
}

void
IntensityQuantiser::spanScale(double offset, double range, unsigned int automatic_bits)
{
  scale_.bits = fixed_bits_ != 0 ? fixed_bits_ : automatic_bits;
  scale_.offset = pcl_ext::detail::saturatedFloat(offset);
  const double step = range * unit_factor_ / static_cast<double>(scale_.maxSymbol());
  scale_.step = pcl_ext::detail::saturatedFloat(std::max(step, smallest_step));
}

} // namespace pcl_ext::PCL_EXT_ABI::io
