// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Which vectors the loops with several lanes types use in this process.
 */
#pragma once

#include <pcl_ext/version.h>

#include <atomic>

// Not for GCC on Windows, which does not align AVX2's vectors on the stack.
#if defined(__x86_64__) &&                                                             \
    (defined(__clang__) || (defined(__GNUC__) && !defined(_WIN32)))
#define PCL_EXT_HAS_AVX2 1
#else
#define PCL_EXT_HAS_AVX2 0
#endif

namespace pcl_ext {

struct Avx2Lanes;

/** \brief True if this processor and the operating system have AVX2. */
inline bool
hasAvx2()
{
#if PCL_EXT_HAS_AVX2
  static const bool has_avx2 = [] {
    __builtin_cpu_init(); // constructors of other libraries may run before
    return __builtin_cpu_supports("avx2") != 0;
  }();
  return has_avx2;
#else
  return false;
#endif
}

/** \brief False while tests or benchmarks want the NativeLanes of machines without
 * AVX2. */
inline std::atomic<bool> may_use_avx2{true};

/** \brief True if the loops that have them use Avx2Lanes. */
inline bool
usesAvx2()
{
  return hasAvx2() && may_use_avx2.load(std::memory_order_relaxed);
}

/** \brief The vectors of these loops, by the name of their instructions. */
inline const char*
vectorsInUse()
{
  if (usesAvx2())
    return "AVX2";
#if defined(__SSE2__)
  return "SSE2";
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
  return "NEON";
#else
  return "none";
#endif
}

} // namespace pcl_ext
