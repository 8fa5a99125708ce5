// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "codec/scan/number_symbols.h"
#include "codec/scan/scan_frame.h"
#include "simd/bit_operations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <type_traits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io {
namespace scan {

/** \brief Edges along x, y and z. */
using Steps = std::array<std::int32_t, 3>;

/** \brief Contexts of the coordinates of a point, in the order in which they are coded:
 * half octaves of the errors of points before; for the second and the third one octaves
 * of these and pairs of octaves of the errors of this point's coordinates before. */
constexpr std::size_t first_coordinate_contexts = 28;
constexpr std::size_t earlier_contexts = 14;
constexpr std::size_t own_contexts = 8;
constexpr std::size_t sequence_contexts =
    first_coordinate_contexts + 2 * earlier_contexts * own_contexts;

/** \brief Leads are compared at one of so many points. */
constexpr std::size_t learnt_points = 4;

/** \brief Codes the positions of points without rays, for either direction. Each is
 * expected where the points before it and those above it lead, in steps or along a ray
 * from the origin. */
template <class CodingT>
class SequencePass {
public:
  /** \param[in] width of a row
   * \param[in] pixels of the points, ascending
   * \param[in,out] positions of the points from the origin, each coordinate with fewer
   * than most_steps; of its size
   */
  SequencePass(std::uint32_t width,
               const std::vector<std::uint32_t>& pixels,
               std::vector<Steps>& positions)
  : width_(width)
  , pixels_(pixels)
  , positions_(positions)
  , errors_(pixels.size())
  , distances_(pixels.size())
  {}

  /** \brief Codes all points.
   * \return false if what was decoded are no positions
   */
  bool
  code(CodingT& coding)
  {
    const bool has_rows = !pixels_.empty() && pixels_.back() >= width_;
    return has_rows ? codeAll<4>(coding) : codeAll<2>(coding);
  }

private:
  static constexpr std::size_t none = ~std::size_t{0};
  static constexpr std::int32_t most = most_steps - 1;
  static constexpr std::size_t most_leads = 4;

  /** \brief Where a point may be: where the last one is, where the last two lead to, and
   * with four of them the same of those in the rows above. */
  template <std::size_t count>
  using Leads = std::array<Steps, count>;

  template <std::size_t count>
  bool
  codeAll(CodingT& coding_now)
  {
    constexpr std::size_t numbers_of_point = 3;
    constexpr std::size_t points_at_once = 4096;
    for (std::size_t begin = 0, end = 0; begin < pixels_.size(); begin = end) {
      end = std::min(begin + points_at_once, pixels_.size());
      coding_now.reserve(numbers_of_point * (end - begin));
      CodingT coding = coding_now; // in registers
      for (std::size_t point = begin; point < end; ++point)
        if (!codePoint<count>(coding, point))
          return false;
      coding_now = coding;
    }
    return true;
  }

  /** \brief The point of a pixel this many rows above; none: there is none. */
  std::size_t
  above(std::size_t point, std::uint32_t rows)
  {
    const std::uint64_t distance = std::uint64_t{rows} * width_;
    if (pixels_[point] < distance)
      return none;
    const auto pixel = static_cast<std::uint32_t>(pixels_[point] - distance);
    std::size_t& candidate = above_[rows - 1];
    while (pixels_[candidate] < pixel)
      ++candidate;
    return pixels_[candidate] == pixel ? candidate : none;
  }

  static Steps
  continued(const Steps& last, const Steps& before)
  {
    Steps next;
    for (std::size_t axis = 0; axis < 3; ++axis)
      next[axis] = std::clamp(2 * last[axis] - before[axis], -most, most);
    return next;
  }

  template <std::size_t count>
  Leads<count>
  leadsTo(std::size_t point, std::size_t up)
  {
    Leads<count> leads{};
    if (point == 0)
      return leads;
    const Steps& last = positions_[point - 1];
    leads[0] = last;
    leads[1] = point > 1 ? continued(last, positions_[point - 2]) : last;
    if constexpr (count > 2) {
      leads[2] = up != none ? positions_[up] : last;
      const std::size_t further = above(point, 2);
      leads[3] = up != none && further != none
                     ? continued(positions_[up], positions_[further])
                     : leads[2];
    }
    return leads;
  }

  /** \brief floor(coordinate * to / from + 1 / 2), clamped to the range of coordinates;
   * the coordinate itself if `from` is 0. Exact whatever rounding of the quotient. */
  static std::int32_t
  scaled(std::int32_t coordinate, std::int64_t to, std::int64_t from)
  {
    if (from == 0)
      return coordinate;
    const std::int64_t unit = 2 * std::abs(from);
    const std::int64_t sum = 2 * (from < 0 ? -to : to) * coordinate + unit / 2;
    if (sum >= most * unit)
      return most;
    if (sum < -most * unit)
      return -most;
    auto quotient =
        static_cast<std::int64_t>(static_cast<double>(sum) / static_cast<double>(unit));
    quotient -= quotient * unit > sum ? 1 : 0;
    quotient += (quotient + 1) * unit <= sum ? 1 : 0;
    return static_cast<std::int32_t>(quotient);
  }

  /** \brief Distance from the z axis, in eighths of an edge, rounded down. */
  static std::int64_t
  distanceFromAxis(const Steps& position)
  {
    const auto x = static_cast<std::uint64_t>(std::abs(position[0]));
    const auto y = static_cast<std::uint64_t>(std::abs(position[1]));
    const std::uint64_t square = 64 * (x * x + y * y);
    auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(square)));
    root -= root * root > square ? 1 : 0;
    root += (root + 1) * (root + 1) <= square ? 1 : 0;
    return static_cast<std::int64_t>(root);
  }

  /** \brief distanceFromAxis() of a lead; those of points are known. */
  template <std::size_t count>
  std::int64_t
  distanceOfLead(std::size_t lead,
                 const Leads<count>& leads,
                 std::size_t point,
                 std::size_t up) const
  {
    if (lead % 2 == 1 || point == 0)
      return distanceFromAxis(leads[lead]);
    return distances_[lead == 0 || up == none ? point - 1 : up];
  }

  template <std::size_t count>
  bool
  codePoint(CodingT& coding, std::size_t point)
  {
    const std::size_t up = count > 2 ? above(point, 1) : none;
    const Leads<count> leads = leadsTo<count>(point, up);
    const std::size_t first = std::abs(leads[0][1]) > std::abs(leads[0][0]) ? 1 : 0;
    Steps& position = positions_[point];
    std::uint32_t own_error = 0;
    // From `count` on leads are the rays to them, along which coordinates are in
    // proportion to a distance.
    const auto code = [&](auto place,
                          std::size_t axis,
                          std::int64_t distance,
                          const auto& distance_of_lead) {
      const auto expect = [&](std::size_t lead) {
        return lead < count ? leads[lead][axis]
                            : scaled(leads[lead - count][axis],
                                     distance,
                                     distance_of_lead(lead - count));
      };
      const std::size_t context =
          contextOf(place, earlierError(place, point, up), own_error);
      const std::uint32_t error =
          codeCoordinate(coding, context, expect(best_[place]), position[axis]);
      errors_[point][place] = error;
      own_error += error;
      if (point % learnt_points == 0)
        learn(place, place > 0 ? 2 * count : count, expect, position[axis]);
      return error <= 2u * most;
    };
    using std::integral_constant;
    const auto along_first = [&](std::size_t lead) {
      return std::int64_t{leads[lead][first]};
    };
    const auto from_axis = [&](std::size_t lead) {
      return distanceOfLead<count>(lead, leads, point, up);
    };
    if (!code(integral_constant<std::size_t, 0>(), first, 0, along_first) ||
        !code(integral_constant<std::size_t, 1>(),
              1 - first,
              position[first],
              along_first))
      return false;
    distances_[point] = distanceFromAxis(position);
    return code(integral_constant<std::size_t, 2>(), 2, distances_[point], from_axis);
  }

  std::uint32_t
  earlierError(std::size_t place, std::size_t point, std::size_t up) const
  {
    return (point > 0 ? errors_[point - 1][place] : 0) +
           (point > 1 ? errors_[point - 2][place] : 0) +
           (up != none ? errors_[up][place] : 0);
  }

  static std::size_t
  contextOf(std::size_t place, std::uint32_t earlier, std::uint32_t own)
  {
    const std::uint32_t odd = 2 * earlier + 1;
    const std::size_t octave = highestBit(odd);
    if (place == 0)
      return std::min(2 * octave + (2 * odd >> octave & 1),
                      first_coordinate_contexts - 1);
    const std::size_t own_octaves =
        std::min<std::size_t>(highestBit(2 * own + 1) / 2, own_contexts - 1);
    return first_coordinate_contexts +
           ((place - 1) * earlier_contexts + std::min(octave, earlier_contexts - 1)) *
               own_contexts +
           own_octaves;
  }

  /** \brief Learns what a coordinate would have cost with each lead, and which costs
   * least, the first of equals. */
  template <class ExpectT>
  void
  learn(std::size_t place,
        std::size_t lead_count,
        const ExpectT& expect,
        std::int32_t coordinate)
  {
    auto& costs = costs_[place];
    std::size_t& best = best_[place];
    for (std::size_t lead = 0; lead < lead_count; ++lead) {
      const auto error =
          static_cast<std::uint32_t>(std::abs(expect(lead) - coordinate));
      costs[lead] += 64 * highestBit(2 * error + 1) - costs[lead] / 16;
    }
    best = 0;
    for (std::size_t lead = 1; lead < lead_count; ++lead)
      if (costs[lead] < costs[best])
        best = lead;
  }

  /** \brief Codes a coordinate.
   * \return how far it is from what was expected; more than 2 * most: none was decoded
   */
  static std::uint32_t
  codeCoordinate(CodingT& coding,
                 std::size_t context,
                 std::int32_t expected,
                 std::int32_t& coordinate)
  {
    std::uint64_t value = 0;
    if constexpr (!CodingT::is_decoder)
      value = zigzag(coordinate - expected);
    value = coding.code(context, value);
    if constexpr (CodingT::is_decoder)
      if (value >= first_word || coding.isOverrun())
        return ~std::uint32_t{0};
    const std::int64_t difference = unzigzag(static_cast<std::uint32_t>(value));
    const std::int64_t decoded = expected + difference;
    if constexpr (CodingT::is_decoder) {
      if (decoded < -most || decoded > most)
        return ~std::uint32_t{0};
      coordinate = static_cast<std::int32_t>(decoded);
    }
    return static_cast<std::uint32_t>(std::abs(difference));
  }

  const std::uint32_t width_;
  const std::vector<std::uint32_t>& pixels_;
  std::vector<Steps>& positions_;
  std::vector<std::array<std::uint32_t, 3>> errors_;
  std::vector<std::int64_t> distances_; // of the points before, from the axis
  std::array<std::size_t, 2> above_{};  // points that were looked for last
  std::array<std::array<std::uint32_t, 2 * most_leads>, 3> costs_{};
  std::array<std::size_t, 3> best_{}; // lead of each coordinate
};

} // namespace scan
} // namespace pcl_ext::PCL_EXT_ABI::io
