#pragma once

#include <array>
#include <cstdint>

namespace pcl_ext {
namespace io {
namespace context {

/** \brief The probability that a bit is 1, learnt from the bits before it: fast at
 * first, then slower (doc/bitstream_context.md, "Adaptive bits"). */
struct AdaptiveBit {
  std::uint16_t probability = 0x8000; ///< of a 1, 2^16 is 1
  std::uint16_t count = 0;            ///< bits learnt, up to where the rate is constant

  /** \brief Learns a bit.
   * \param[in] bit the bit
   * \param[in] shifts the rate after each number of bits, as 2^-shift; see learningShifts
   */
  void
  learn(bool bit, const std::array<std::uint8_t, 17>& shifts)
  {
    // The limits keep the coder's intervals from being empty.
    constexpr std::int32_t least = 48;
    const std::int32_t target = bit ? 0x10000 - least : least;
    probability = static_cast<std::uint16_t>(
        probability +
        ((target - static_cast<std::int32_t>(probability)) >> shifts[count]));
    count = static_cast<std::uint16_t>(count + (count < shifts.size() - 1 ? 1 : 0));
  }
};

/** \brief Rates at which a bit is learnt: 1/2, 1/4, 1/8 for four bits, 1/16 for ten,
 * then for good.
 * \param[in] slowest_shift the rate of the long run, 2^-slowest_shift; 4..7
 */
constexpr std::array<std::uint8_t, 17>
learningShifts(std::uint8_t slowest_shift)
{
  return {1, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, slowest_shift};
}

} // namespace context
} // namespace io
} // namespace pcl_ext
