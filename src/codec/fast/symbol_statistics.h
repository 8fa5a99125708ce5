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

/** \brief Statistics of a voxel without symbols; no others have this mean. */
constexpr std::uint16_t none = 0xffff;

/** \brief The statistics after a further symbol; both adapt at a rate of 1/4. */
constexpr std::uint16_t
next(std::uint16_t statistics, unsigned int bin)
{
  const int old_mean = static_cast<int>(mean(statistics));
  const int old_deviation = static_cast<int>(deviation(statistics));
  const int difference = static_cast<int>(bin * fraction) - old_mean;
  const int distance = difference < 0 ? -difference : difference;
  const int clamped = distance < 63 ? distance : 63;
  const auto further =
      static_cast<std::uint16_t>((old_mean + ((difference + 2) >> 2)) * 64 +
                                 old_deviation + ((clamped - old_deviation + 2) >> 2));
  return statistics == none ? first(bin) : further;
}

/** \brief By mean: the bin of symbol 0 in the model of a voxel. The fifteen bins of the model
 * are 0..14 up to a mean of 7, then those around the mean. */
constexpr std::array<std::uint8_t, mean_count>
makeLowestBins()
{
  std::array<std::uint8_t, mean_count> lowest{};
  for (unsigned int mean = 0; mean < mean_count - 1; ++mean) {
    const unsigned int rounded = (mean + fraction / 2) / fraction;
    lowest[mean] = static_cast<std::uint8_t>(rounded > 7 ? rounded - 7 : 0);
  }
  return lowest;
}

inline constexpr auto lowest_bins = makeLowestBins();

inline unsigned int
lowestBin(std::uint16_t statistics)
{
  return lowest_bins[mean(statistics)];
}

constexpr unsigned int spread_count = 5;
constexpr unsigned int last_level = 24;

/** \brief Context of a mean and a deviation below 4. */
constexpr std::array<std::uint8_t, mean_count>
makeMeanContexts()
{
  std::array<std::uint8_t, mean_count> contexts{};
  for (unsigned int mean = 0; mean < mean_count; ++mean)
    contexts[mean] = static_cast<std::uint8_t>(
        spread_count * std::min({mean / 2, mean / 4 + 6, last_level}));
  // Of no statistics, whose deviation is the highest: one more than the others.
  ++contexts[mean_count - 1];
  return contexts;
}

inline constexpr auto mean_contexts = makeMeanContexts();

/** \brief Class of each deviation, 0..4. */
constexpr std::array<std::uint8_t, deviation_count>
makeSpreads()
{
  std::array<std::uint8_t, deviation_count> spreads{};
  for (unsigned int i = 0; i < deviation_count; ++i)
    spreads[i] = i < 4 ? 0 : i < 9 ? 1 : i < 16 ? 2 : i < 28 ? 3 : 4;
  return spreads;
}

inline constexpr auto spreads = makeSpreads();

/** \brief Context of a voxel with these statistics, 0..124, or 125 without. */
inline unsigned int
contextOf(std::uint16_t statistics)
{
  return unsigned{mean_contexts[mean(statistics)]} + spreads[deviation(statistics)];
}

} // namespace symbol_statistics

} // namespace fast
} // namespace io
} // namespace pcl_ext
