// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "simulator/random_numbers.h"

namespace pcl_ext {
namespace cell {

std::uint32_t
mixSeeds(std::uint32_t a, std::uint32_t b, std::uint32_t c)
{
  std::uint64_t mixed =
      (std::uint64_t{a} << 32 | b) + 0x9E3779B97F4A7C15ull * (c + 1ull);
  mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9ull;
  mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBull;
  return static_cast<std::uint32_t>((mixed ^ (mixed >> 31)) >> 16);
}

} // namespace cell
} // namespace pcl_ext
