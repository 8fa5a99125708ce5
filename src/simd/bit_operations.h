// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Operations on bits, byte order and the cache that compilers provide and C++17
 * does not. Compiler built-ins are used in this file only; each has a portable version
 * in plain C++, which the tests compare it with.
 */
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>

#if !defined(__GNUC__) && defined(_MSC_VER)
#include <intrin.h>
#endif

// For functions of a few instructions in loops whose state has to stay in registers.
#if defined(__GNUC__)
#define PCL_EXT_ALWAYS_INLINE [[gnu::always_inline]] inline
#else
#define PCL_EXT_ALWAYS_INLINE inline
#endif

// For what such a loop calls rarely.
#if defined(__GNUC__)
#define PCL_EXT_NEVER_INLINE [[gnu::noinline]]
#else
#define PCL_EXT_NEVER_INLINE
#endif

namespace pcl_ext {

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
constexpr bool is_big_endian = true;
#else
constexpr bool is_big_endian = false;
#endif

/** \brief Number of bits set, without the popcnt instruction, which x86-64 may lack. */
constexpr unsigned int
bitCount(std::uint64_t bits)
{
  bits -= bits >> 1 & 0x5555555555555555;
  bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return static_cast<unsigned int>(bits * 0x0101010101010101 >> 56);
}

/** \brief 1 if any bit is set, else 0. By arithmetic, as g++ compiles comparisons to
 * branches. */
constexpr std::size_t
isNotZero(std::uint64_t bits)
{
  return static_cast<std::size_t>((bits | (0 - bits)) >> 63);
}

/** \brief The functions below in plain C++. */
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

template <class Pointer>
inline void
replaceIfBelow(std::uint32_t limit,
               std::uint32_t& number,
               std::uint32_t other_number,
               Pointer& pointer,
               Pointer other_pointer)
{
  const bool is_below = number < limit;
  pointer = is_below ? other_pointer : pointer;
  number = is_below ? other_number : number;
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
  return 31u ^ static_cast<unsigned int>(__builtin_clz(bits)); // a single bsr
#elif defined(_MSC_VER)
  unsigned long index;
  _BitScanReverse(&index, bits);
  return index;
#else
  return portable::highestBit(bits);
#endif
}

/** \brief Replaces a number and a pointer by others if the number is below a limit,
 * without a branch (doc/implementation_notes.md, "Conditional moves"). */
template <class Pointer>
PCL_EXT_ALWAYS_INLINE void
replaceIfBelow(std::uint32_t limit,
               std::uint32_t& number,
               std::uint32_t other_number,
               Pointer& pointer,
               Pointer other_pointer)
{
#if defined(__GNUC__) && defined(__x86_64__)
  // Copies, as an object with members as operands would stay in memory.
  std::uint32_t local_number = number;
  Pointer local_pointer = pointer;
  asm("cmp %[limit], %[number]\n\t"
      "cmovb %[other_pointer], %[pointer]\n\t"
      "cmovb %[other_number], %[number]"
      : [number] "+&r"(local_number), [pointer] "+&r"(local_pointer)
      : [other_pointer] "r"(other_pointer),
        [other_number] "r"(other_number),
        [limit] "ri"(limit)
      : "cc");
  number = local_number;
  pointer = local_pointer;
#else
  portable::replaceIfBelow(limit, number, other_number, pointer, other_pointer);
#endif
}

/** \brief Prefetches memory into the cache; any address is valid. Always inline, as g++
 * removes calls of a function that only prefetches. */
PCL_EXT_ALWAYS_INLINE void
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
