#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {

/** \brief The probability that a bit is 1, learnt from the bits before it: fast at
 * first, then slower (doc/bitstream.md, "Adaptive bits"). */
struct AdaptiveBit {
  std::uint16_t probability = 0x8000; ///< of a 1, 2^16 is 1
  std::uint16_t count = 0;            ///< bits learnt, up to where the rate is constant

  /** \brief Learns a bit.
   * \param[in] bit the bit
   * \param[in] slowest_shift the rate of the long run, 2^-slowest_shift; 4..7
   */
  void
  learn(bool bit, unsigned int slowest_shift)
  {
    constexpr std::array<std::uint8_t, 17> shifts = {
        1, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 7};
    const unsigned int shift = std::min<unsigned int>(shifts[count], slowest_shift);
    // The limits keep the coder's intervals from being empty.
    constexpr std::int32_t least = 48;
    const std::int32_t target = bit ? 0x10000 - least : least;
    probability = static_cast<std::uint16_t>(
        probability + ((target - static_cast<std::int32_t>(probability)) >> shift));
    count = static_cast<std::uint16_t>(count + (count < shifts.size() - 1 ? 1 : 0));
  }
};

} // namespace io
} // namespace pcl_ext
