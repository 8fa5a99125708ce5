// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/nodes/stream_health.h>

#include <atomic>
#include <memory>
#include <stdexcept>

namespace pcl_ext::PCL_EXT_ABI::nodes::test {

/** \brief A clock that is set by the test and read by any thread. */
class FakeClock {
public:
  /** \brief The clock as settings take it; may outlive this. */
  Clock
  clock() const
  {
    return [now = now_, is_broken = is_broken_] {
      if (*is_broken)
        throw std::runtime_error("the clock is broken");
      return Time(now->load());
    };
  }

  void
  set(Time now)
  {
    now_->store(now.count());
  }

  /** \brief Has the clock throw an exception, or not. */
  void
  setBroken(bool is_broken)
  {
    *is_broken_ = is_broken;
  }

private:
  std::shared_ptr<std::atomic<bool>> is_broken_ =
      std::make_shared<std::atomic<bool>>(false);
  std::shared_ptr<std::atomic<Time::rep>> now_ =
      std::make_shared<std::atomic<Time::rep>>(0);
};

} // namespace pcl_ext::PCL_EXT_ABI::nodes::test
