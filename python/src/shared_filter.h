// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>

namespace pcl_ext::python {

/** \brief A filter of one stream that any thread may use. Not to be called with the GIL
 * held, as a call may wait for another thread. */
template <typename FilterT, typename StatusT>
class SharedFilter {
public:
  template <typename SettingsT>
  explicit SharedFilter(const SettingsT& settings) : filter_(settings)
  {}

  void
  reset()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    filter_.reset();
  }

  /** \brief Outcome of the last frame or cloud. */
  StatusT
  status() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return status_;
  }

protected:
  mutable std::mutex mutex_;
  FilterT filter_;
  StatusT status_;
};

} // namespace pcl_ext::python
