#include "simd/lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace {

using pcl_ext::NativeLanes;
using pcl_ext::ScalarLanes;

/** \brief What a computation leaves in memory, bit by bit, for either kind of lanes. */
struct Result {
  std::array<std::array<std::uint32_t, 4>, 17> lanes{};
  std::array<unsigned int, 3> masks{};
  std::array<std::uint64_t, 4> pairs{};

  bool
  operator==(const Result& other) const
  {
    return lanes == other.lanes && masks == other.masks && pairs == other.pairs;
  }
};

template <typename LanesT>
Result
compute(const std::array<float, 16>& points, const std::array<std::uint8_t, 16>& bytes)
{
  using L = LanesT;
  // What is no integer may become any.
  std::array<float, 16> small_points;
  std::transform(points.begin(), points.end(), small_points.begin(), [](float value) {
    return std::isnan(value) ? -1e6f : std::clamp(value, -1e6f, 1e6f);
  });
  Result result;
  std::size_t next = 0;
  const auto keepFloats = [&](const typename L::Floats& values) {
    std::array<float, 4> floats;
    L::store(values, floats.data());
    for (std::size_t i = 0; i < 4; ++i)
      // The sign and the payload of NaN may differ.
      if (std::isnan(floats[i]))
        result.lanes[next][i] = 0x7fc00000;
      else
        std::memcpy(&result.lanes[next][i], &floats[i], sizeof(float));
    ++next;
  };
  const auto keepInts = [&](const typename L::Ints& values) {
    L::store(values, result.lanes[next++].data());
  };
  typename L::Floats x;
  typename L::Floats y;
  typename L::Floats z;
  pcl_ext::loadPoints<L>(reinterpret_cast<const unsigned char*>(points.data()),
                         4 * sizeof(float),
                         x,
                         y,
                         z);
  keepFloats(L::add(x, y));
  keepFloats(L::subtract(x, y));
  keepFloats(L::multiply(x, y));
  keepFloats(L::absolute(x));
  typename L::Floats small[3];
  pcl_ext::loadPoints<L>(reinterpret_cast<const unsigned char*>(small_points.data()),
                         4 * sizeof(float),
                         small[0],
                         small[1],
                         small[2]);
  // Plus 0, as the smaller one of 0 and -0 is either.
  keepFloats(L::add(L::minimum(small[0], small[1]), L::all(0.0f)));
  keepFloats(L::add(L::maximum(small[0], small[1]), L::all(0.0f)));
  const typename L::Ints whole = L::round(small[0]);
  keepInts(whole);
  keepFloats(L::toFloats(whole));
  const typename L::Ints other = L::round(L::absolute(small[1]));
  keepInts(L::subtract(whole, other));
  keepInts(L::bitAnd(whole, other));
  keepInts(L::bitOr(whole, L::all(0x10)));
  keepInts(L::template shiftLeft<7>(whole));
  keepInts(L::template shiftRight<9>(whole));
  keepInts(L::isZero(L::bitAnd(whole, L::all(1))));
  L::storePairs(whole, other, result.pairs.data());
  typename L::Floats w = L::all(1.0f);
  L::transpose(x, y, z, w);
  keepFloats(x);
  keepFloats(w);
  result.masks = {L::bitsOf(L::less(x, y)),
                  L::bitsOf(L::lessOrEqual(w, z)),
                  L::nonZeroBytes(bytes.data())};
  return result;
}

TEST(Lanes, NativeLanesAgreeWithScalarLanesToTheLastBit)
{
  std::mt19937_64 random(1);
  const std::array<float, 8> special{0.0f,
                                     -0.0f,
                                     std::numeric_limits<float>::infinity(),
                                     -std::numeric_limits<float>::infinity(),
                                     std::numeric_limits<float>::quiet_NaN(),
                                     std::numeric_limits<float>::max(),
                                     std::numeric_limits<float>::denorm_min(),
                                     0.5f};
  for (int i = 0; i < 20000; ++i) {
    std::array<float, 16> points;
    for (float& value : points) {
      const auto bits = static_cast<std::uint32_t>(random());
      std::memcpy(&value, &bits, sizeof(value));
      if (random() % 3 == 0)
        value = special[random() % special.size()];
      else if (random() % 2 == 0)
        value = static_cast<float>(static_cast<std::int32_t>(bits)) * 0x1p-16f;
    }
    std::array<std::uint8_t, 16> bytes;
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random() % 3 == 0 ? random() : 0);
    ASSERT_TRUE(compute<NativeLanes>(points, bytes) ==
                compute<ScalarLanes>(points, bytes))
        << "of round " << i;
  }
}

} // namespace
