#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <cstddef>
#include <deque>
#include <optional>

namespace pcl_ext {
namespace nodes {

/** \brief Notices clouds that were lost before they arrived, by gaps between the stamps of
 * those that arrived. For clouds in the order of their stamps, of one sensor with a steady
 * rate.
 *
 * The period is the fifth shortest of the last 30 intervals: one without a loss in it
 * while more than a quarter of the clouds arrive, and not the shortest, which jitter may
 * have shortened.
 * A sensor that becomes slower counts as losses until the intervals are those of its new
 * period; after a pause of more than 50 periods the period is found anew.
 */
class StampGaps {
public:
  /** \brief Takes the stamp of a cloud that arrived; 0: it has none.
   * \return clouds that are missing between the previous one and it; 0 for the first ones,
   * and behind a pause of more than 50 periods
   */
  std::size_t
  missingBefore(Time stamp);

private:
  Time
  period() const;

  std::optional<Time> last_stamp_;
  std::deque<Time> intervals_; // the latest one is the last
};

} // namespace nodes
} // namespace pcl_ext
