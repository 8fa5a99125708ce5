// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Movement along key poses, with pauses.
 */
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace cell {

/** \brief Values that run smoothly from key to key and repeat after the last one.
 *
 * Two neighbouring keys with equal values are a pause. Speeds are zero at the keys, as
 * they are for a robot that moves point to point.
 * \tparam ValueCount number of values (joints, coordinates) that move together
 */
template <std::size_t ValueCount>
class Track {
public:
  struct Key {
    double time;                          ///< seconds from the cycle's start
    std::array<double, ValueCount> value; ///< metres or radians
  };

  /** \brief Keys in the order of time; the first one is at 0. The last one's time is
   * the length of the cycle, and its values are those of the first. */
  explicit Track(std::vector<Key> keys) : keys_(std::move(keys)) {}

  std::array<double, ValueCount>
  at(double time) const
  {
    const double cycle = keys_.back().time;
    const double phase = time - cycle * std::floor(time / cycle);
    std::size_t next = 1;
    while (next + 1 < keys_.size() && keys_[next].time <= phase)
      ++next;
    const Key& from = keys_[next - 1];
    const Key& to = keys_[next];
    const double share = (phase - from.time) / (to.time - from.time);
    const double eased = share * share * (3.0 - 2.0 * share);
    std::array<double, ValueCount> values;
    for (std::size_t i = 0; i < ValueCount; ++i)
      values[i] = from.value[i] + eased * (to.value[i] - from.value[i]);
    return values;
  }

private:
  std::vector<Key> keys_;
};

} // namespace cell
} // namespace pcl_ext
