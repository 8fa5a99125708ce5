#pragma once

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Intensity symbols in steps that grow with them: 0..15 stand for themselves,
 * above that there are eight steps an octave and bits within the step. The highest
 * symbol of all, at which sensors saturate, is a step of its own. */
namespace symbol_steps {

constexpr unsigned int exact = 16;
constexpr unsigned int highest = 113; ///< no step is above

/** \brief Bits within a step, 0..12. */
constexpr unsigned int
bitsWithin(unsigned int step)
{
  return step < exact ? 0 : (step - exact) / 8 + 1;
}

/** \brief Lowest value of a step. */
constexpr unsigned int
lowestValue(unsigned int step)
{
  return step < exact ? step : (8 + step % 8) << bitsWithin(step);
}

/** \brief The step of a value, the highest value of all excepted. */
inline unsigned int
stepOf(unsigned int value)
{
  if (value < exact)
    return value;
  const unsigned int octave = highestBit(value);
  return exact + (octave - 4) * 8 + (value >> (octave - 3) & 7);
}

} // namespace symbol_steps

/** \brief Running mean and mean deviation of a voxel's steps in 16 bits: the mean, in
 * eighths, in the higher ten, the deviation, in eighths, in the lower six. */
namespace symbol_moment {

constexpr unsigned int fraction = 8; ///< an eighth is 1
constexpr unsigned int deviation_count = 64;
constexpr unsigned int mean_count = 1024;

constexpr unsigned int
mean(std::uint16_t moment)
{
  return moment / deviation_count;
}

constexpr unsigned int
deviation(std::uint16_t moment)
{
  return moment % deviation_count;
}

/** \brief The moment after a voxel's first symbol. */
constexpr std::uint16_t
first(unsigned int step)
{
  const unsigned int deviation = step < 32 ? fraction + step : 40;
  return static_cast<std::uint16_t>(step * fraction * deviation_count | deviation);
}

/** \brief The moment after one more symbol; both move a quarter of the way. */
constexpr std::uint16_t
next(std::uint16_t moment, unsigned int step)
{
  const int before = static_cast<int>(mean(moment));
  const int spread = static_cast<int>(deviation(moment));
  const int way = static_cast<int>(step * fraction) - before;
  const int distance = way < 0 ? -way : way;
  const int held = distance < 63 ? distance : 63;
  return static_cast<std::uint16_t>((before + ((way + 2) >> 2)) * 64 + spread +
                                    ((held - spread + 2) >> 2));
}

/** \brief The step of which symbol 0 of a voxel's model stands: up to a mean of 7 the
 * model has the steps 0..14, then those around the mean. */
constexpr unsigned int
lowestStep(std::uint16_t moment)
{
  const unsigned int rounded = (mean(moment) + fraction / 2) / fraction;
  return rounded > 7 ? rounded - 7 : 0;
}

constexpr unsigned int spread_count = 5;

/** \brief The class of a mean and a deviation below 4. */
constexpr std::array<std::uint8_t, mean_count>
makeMeanContexts()
{
  std::array<std::uint8_t, mean_count> contexts{};
  for (unsigned int mean = 0; mean < mean_count; ++mean) {
    const unsigned int level = mean < 24 ? mean / 2 : 12 + (mean - 24) / 4;
    const bool is_above_models = (mean + fraction / 2) / fraction > 7;
    contexts[mean] = static_cast<std::uint8_t>(
        (is_above_models || level > 24 ? 24 : level) * spread_count);
  }
  return contexts;
}

inline constexpr auto mean_contexts = makeMeanContexts();

/** \brief Class of a deviation, 0..4. */
constexpr unsigned int
spread(unsigned int deviation)
{
  return (deviation >= 4 ? 1u : 0u) + (deviation >= 9 ? 1u : 0u) +
         (deviation >= 16 ? 1u : 0u) + (deviation >= 28 ? 1u : 0u);
}

constexpr std::array<std::uint8_t, deviation_count>
makeSpreads()
{
  std::array<std::uint8_t, deviation_count> spreads{};
  for (unsigned int i = 0; i < deviation_count; ++i)
    spreads[i] = static_cast<std::uint8_t>(spread(i));
  return spreads;
}

inline constexpr auto spreads = makeSpreads();

/** \brief Class of a moment, 0..124. */
inline unsigned int
contextOf(std::uint16_t moment)
{
  return unsigned{mean_contexts[mean(moment)]} + spreads[deviation(moment)];
}

} // namespace symbol_moment

} // namespace fast
} // namespace io
} // namespace pcl_ext
