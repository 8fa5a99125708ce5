// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief Notices clouds that were lost before they arrived, by gaps between the stamps
 * of those that arrived. For clouds in the order of their stamps, of one sensor with a
 * steady rate: gaps of other sensors are no losses, and are not counted.
 *
 * The period is that of the last 30 intervals, while more than a quarter of the clouds
 * arrive. A gap is an interval of 1.5 to 50 periods. Gaps are losses if of the last 30,
 * at least 12, three quarters are whole numbers of periods within .15 of one, and if
 * most are not alike, unless they are of two periods: those between regular bursts are
 * alike. The missing clouds of a gap are counted with the next gap or later, less those
 * that came late, within half a period of the one before. A sensor that becomes half as
 * fast counts as losses until the intervals are those of its new period; after a pause
 * of more than 50 periods the period is found anew.
 */
class StampGaps {
public:
  /** \brief Takes the stamp of a cloud that arrived; 0: it has none.
   * \return clouds that were missing in gaps before this one and were not counted yet;
   * 0 unless the gaps are losses
   */
  std::size_t
  missingBefore(Time stamp);

private:
  using Period = std::chrono::duration<double, Time::period>;

  struct Gap {
    std::size_t missing;        ///< clouds, if it is a loss
    bool is_multiple_of_period; ///< about
  };

  /** \brief Takes a gap.
   * \return clouds that were missing in the gaps before it */
  std::size_t
  addGap(double periods);

  bool
  areLosses() const;

  /** \brief Nothing while too few intervals are known. */
  std::optional<Period>
  period() const;

  std::optional<Time> last_stamp_;
  std::deque<Time> intervals_; // the latest one is the last
  std::deque<Gap> gaps_;       // the latest one is the last
  std::size_t pending_ = 0;    // missing clouds that are not counted yet
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes
