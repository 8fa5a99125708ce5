#pragma once

#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace fast {

/** \brief Bins of intensity values: 0..15 have one each; above there are eight bins an
 * octave, and low bits select the value within the bin. The highest value of all, at which
 * sensors saturate, has a bin of its own. */
namespace intensity_bins {

constexpr unsigned int exact = 16;
constexpr unsigned int highest = 113; ///< the highest bin

/** \brief Number of low bits of a bin, 0..12. */
constexpr unsigned int
lowBits(unsigned int bin)
{
  return bin < exact ? 0 : (bin - exact) / 8 + 1;
}

/** \brief Lowest value in a bin. */
constexpr unsigned int
lowestValue(unsigned int bin)
{
  return bin < exact ? bin : (8 + bin % 8) << lowBits(bin);
}

/** \brief The bin of a value other than the highest value of all. */
inline unsigned int
binOf(unsigned int value)
{
  if (value < exact)
    return value;
  const unsigned int octave = highestBit(value);
  return exact + (octave - 4) * 8 + (value >> (octave - 3) & 7);
}

} // namespace intensity_bins

/** \brief Running mean and mean deviation of the bins of a voxel in 16 bits: the mean in the
 * higher ten, the deviation in the lower six, both in eighths. */
namespace symbol_statistics {

constexpr unsigned int fraction = 8; ///< 1, in eighths
constexpr unsigned int deviation_count = 64;
constexpr unsigned int mean_count = 1024;

constexpr unsigned int
mean(std::uint16_t statistics)
{
  return statistics / deviation_count;
}

constexpr unsigned int
deviation(std::uint16_t statistics)
{
  return statistics % deviation_count;
}

/** \brief The statistics after a voxel's first symbol. */
constexpr std::uint16_t
first(unsigned int bin)
{
  const unsigned int deviation = bin < 32 ? fraction + bin : 40;
  return static_cast<std::uint16_t>(bin * fraction * deviation_count | deviation);
}

/** \brief The statistics after a further symbol; both adapt at a rate of 1/4. */
constexpr std::uint16_t
next(std::uint16_t statistics, unsigned int bin)
{
  const int old_mean = static_cast<int>(mean(statistics));
  const int old_deviation = static_cast<int>(deviation(statistics));
  const int difference = static_cast<int>(bin * fraction) - old_mean;
  const int distance = difference < 0 ? -difference : difference;
  const int clamped = distance < 63 ? distance : 63;
  return static_cast<std::uint16_t>((old_mean + ((difference + 2) >> 2)) * 64 +
                                    old_deviation +
                                    ((clamped - old_deviation + 2) >> 2));
}

/** \brief The bin of symbol 0 in the model of a voxel. The fifteen bins of the model are
 * 0..14 up to a mean of 7, then those around the mean. */
constexpr unsigned int
lowestBin(std::uint16_t statistics)
{
  const unsigned int rounded = (mean(statistics) + fraction / 2) / fraction;
  return rounded > 7 ? rounded - 7 : 0;
}

constexpr unsigned int deviation_class_count = 5;

/** \brief Context of a mean and a deviation below 4. */
constexpr std::array<std::uint8_t, mean_count>
makeMeanContexts()
{
  std::array<std::uint8_t, mean_count> contexts{};
  for (unsigned int mean = 0; mean < mean_count; ++mean) {
    const unsigned int level = mean < 24 ? mean / 2 : 12 + (mean - 24) / 4;
    const bool is_above_models = (mean + fraction / 2) / fraction > 7;
    contexts[mean] = static_cast<std::uint8_t>(
        (is_above_models || level > 24 ? 24 : level) * deviation_class_count);
  }
  return contexts;
}

inline constexpr auto mean_contexts = makeMeanContexts();

/** \brief Class of each deviation, 0..4. */
constexpr std::array<std::uint8_t, deviation_count>
makeDeviationClasses()
{
  std::array<std::uint8_t, deviation_count> classes{};
  for (unsigned int i = 0; i < deviation_count; ++i)
    classes[i] = i < 4 ? 0 : i < 9 ? 1 : i < 16 ? 2 : i < 28 ? 3 : 4;
  return classes;
}

inline constexpr auto deviation_classes = makeDeviationClasses();

/** \brief Context of a voxel with these statistics, 0..124. */
inline unsigned int
contextOf(std::uint16_t statistics)
{
  return unsigned{mean_contexts[mean(statistics)]} +
         deviation_classes[deviation(statistics)];
}

} // namespace symbol_statistics

} // namespace fast
} // namespace io
} // namespace pcl_ext
