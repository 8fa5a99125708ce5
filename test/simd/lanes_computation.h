// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "simd/load_points.h"
#include "simd/vector_choice.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pcl_ext::test {

/** \brief Eight points x, y, z, w, and the same without infinities, NaN and large
 * numbers. */
struct LanesInput {
  std::array<float, 32> points;
  std::array<float, 32> small_points; // what is no integer may become any
};

/** \brief What a computation with eight points leaves in memory, bit by bit, for any
 * kind of lanes. */
struct LanesResult {
  std::array<std::array<std::uint32_t, 8>, 18> lanes{};
  std::array<unsigned int, 2> masks{};
  std::array<std::uint64_t, 8> pairs{};

  bool
  operator==(const LanesResult& other) const
  {
    return lanes == other.lanes && masks == other.masks && pairs == other.pairs;
  }
};

/** \brief Computes as many lanes of a result as there are at once. */
template <typename LanesT>
class LanesComputation {
public:
  /** \param[in] first the first of these lanes of the result */
  LanesComputation(std::size_t first, LanesResult& result)
  : first_(first), result_(result)
  {}

  PCL_EXT_LANES_TARGET void
  run(const LanesInput& input)
  {
    using L = LanesT;
    Floats x;
    Floats y;
    Floats z;
    load(input.points, x, y, z);
    keep(L::add(x, y));
    keep(L::subtract(x, y));
    keep(L::multiply(x, y));
    keep(L::absolute(x));
    Floats a;
    Floats b;
    Floats c;
    load(input.small_points, a, b, c);
    // Plus 0, as the smaller one of 0 and -0 is either.
    keep(L::add(L::minimum(a, b), L::all(0.0f)));
    keep(L::add(L::maximum(a, b), L::all(0.0f)));
    const Ints whole = L::round(a);
    keep(whole);
    keep(L::toFloats(whole));
    const Ints other = L::round(L::absolute(b));
    keep(L::subtract(whole, other));
    keep(L::bitAnd(whole, other));
    keep(L::bitOr(whole, L::all(0x10)));
    keep(L::template shiftLeft<7>(whole));
    keep(L::template shiftRight<9>(whole));
    keep(L::isZero(L::bitAnd(whole, L::all(1))));
    L::storePairs(whole, other, &result_.pairs[first_]);
    result_.masks[0] |= L::bitsOf(L::less(x, y)) << first_;
    result_.masks[1] |= L::bitsOf(L::lessOrEqual(y, z)) << first_;
    Floats w = L::all(1.0f);
    L::transpose(x, y, z, w);
    keep(x);
    keep(w);
    keepFours(y);
  }

private:
  using Floats = typename LanesT::Floats;
  using Ints = typename LanesT::Ints;

  PCL_EXT_LANES_TARGET void
  load(const std::array<float, 32>& points, Floats& x, Floats& y, Floats& z) const
  {
    loadPoints<LanesT>(reinterpret_cast<const unsigned char*>(&points[4 * first_]),
                       4 * sizeof(float),
                       x,
                       y,
                       z);
  }

  PCL_EXT_LANES_TARGET void
  keep(const Ints& values)
  {
    LanesT::store(values, &result_.lanes[next_++][first_]);
  }

  PCL_EXT_LANES_TARGET void
  keep(const Floats& values)
  {
    std::array<float, LanesT::width> floats;
    LanesT::store(values, floats.data());
    keepFloats(floats);
  }

  PCL_EXT_LANES_TARGET void
  keepFours(const Floats& values)
  {
    std::array<float, LanesT::width> floats;
    LanesT::template storeFour<0>(values, floats.data());
    if constexpr (LanesT::width == 8)
      LanesT::template storeFour<1>(values, &floats[4]);
    keepFloats(floats);
  }

  PCL_EXT_LANES_TARGET void
  keepFloats(const std::array<float, LanesT::width>& floats)
  {
    for (std::size_t i = 0; i < LanesT::width; ++i)
      // The sign and the payload of NaN may differ.
      if (std::isnan(floats[i]))
        result_.lanes[next_][first_ + i] = 0x7fc00000;
      else
        std::memcpy(&result_.lanes[next_][first_ + i], &floats[i], sizeof(float));
    ++next_;
  }

  std::size_t first_;
  std::size_t next_ = 0; // result
  LanesResult& result_;
};

template <typename LanesT>
PCL_EXT_LANES_TARGET LanesResult
computeWithLanes(const LanesInput& input)
{
  LanesResult result;
  for (std::size_t first = 0; first < 8; first += LanesT::width)
    LanesComputation<LanesT>(first, result).run(input);
  return result;
}

/** \brief The computation with Avx2Lanes, if hasAvx2(). */
LanesResult
computeWithAvx2(const LanesInput& input);

} // namespace pcl_ext::test
