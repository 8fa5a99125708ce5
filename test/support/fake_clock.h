/** \file
 * \brief A clock that stands still, for tests of figures that depend on the time.
 */
#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <atomic>
#include <memory>

namespace pcl_ext {
namespace nodes {
namespace test {

/** \brief A clock that goes when it is told to; any number of threads may ask it. */
class FakeClock {
public:
  /** \brief The clock as settings take it; may outlive this. */
  Clock
  clock() const
  {
    return [now = now_] { return Time(now->load()); };
  }

  void
  set(Time now)
  {
    now_->store(now.count());
  }

private:
  std::shared_ptr<std::atomic<Time::rep>> now_ =
      std::make_shared<std::atomic<Time::rep>>(0);
};

} // namespace test
} // namespace nodes
} // namespace pcl_ext
