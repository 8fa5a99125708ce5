/** \file
 * \brief Operations on bits and on the cache that C++17 has no name for and compilers do.
 */
#pragma once

#include <cstdint>

#if !defined(__GNUC__) && defined(_MSC_VER)
#include <intrin.h>
#endif

namespace pcl_ext {

/** \brief Number of bits set, without the instruction that x86-64 may lack. */
constexpr unsigned int
bitCount(std::uint64_t bits)
{
  bits -= bits >> 1 & 0x5555555555555555;
  bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return static_cast<unsigned int>(bits * 0x0101010101010101 >> 56);
}

/** \brief The functions below in plain C++: for compilers without an operation of their
 * own, and what those must agree with. */
namespace portable {

constexpr unsigned int
lowestBit(std::uint64_t bits)
{
  return bitCount((bits & (0 - bits)) - 1);
}

constexpr unsigned int
lowestBit(std::uint32_t bits)
{
  return bitCount((bits & (0 - bits)) - 1);
}

constexpr unsigned int
highestBit(std::uint32_t bits)
{
  for (unsigned int distance = 1; distance < 32; distance *= 2)
    bits |= bits >> distance;
  return bitCount(bits >> 1);
}

} // namespace portable

/** \brief Index of the lowest bit that is set; there must be one. */
inline unsigned int
lowestBit(std::uint64_t bits)
{
#if defined(__GNUC__)
  return static_cast<unsigned int>(__builtin_ctzll(bits));
#elif defined(_MSC_VER) && (defined(_M_X64) || defined(_M_ARM64))
  unsigned long index;
  _BitScanForward64(&index, bits);
  return index;
#else
  return portable::lowestBit(bits);
#endif
}

inline unsigned int
lowestBit(std::uint32_t bits)
{
#if defined(__GNUC__)
  return static_cast<unsigned int>(__builtin_ctz(bits));
#elif defined(_MSC_VER)
  unsigned long index;
  _BitScanForward(&index, bits);
  return index;
#else
  return portable::lowestBit(bits);
#endif
}

/** \brief Index of the highest bit that is set; there must be one. */
inline unsigned int
highestBit(std::uint32_t bits)
{
#if defined(__GNUC__)
  return 31u - static_cast<unsigned int>(__builtin_clz(bits));
#elif defined(_MSC_VER)
  unsigned long index;
  _BitScanReverse(&index, bits);
  return index;
#else
  return portable::highestBit(bits);
#endif
}

/** \brief Asks for memory that will be read soon; any address will do. */
#if defined(__GNUC__)
// Inlined before g++ looks at what functions do: it takes one that only prefetches for one
// that does nothing, and drops its calls.
[[gnu::always_inline]]
#endif
inline void
prefetch([[maybe_unused]] const void* address)
{
#if defined(__GNUC__)
  __builtin_prefetch(address);
#elif defined(_MSC_VER) && (defined(_M_X64) || defined(_M_IX86))
  _mm_prefetch(static_cast<const char*>(address), _MM_HINT_T0);
#elif defined(_MSC_VER) && defined(_M_ARM64)
  __prefetch(address);
#endif
}

} // namespace pcl_ext
