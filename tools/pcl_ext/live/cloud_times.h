// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include <optional>

namespace pcl_ext::tools {

/** \brief The times of the clouds of a stream: their stamps or, if that of the first one is
 * 0, which is none, the times at which they were recorded. Those before 1970, which no
 * recording has, are recorded times, too. */
class CloudTimes {
public:
  /** \param[in] stamp of the next cloud */
  recording::Time
  timeOf(recording::Time stamp, recording::Time recorded)
  {
    constexpr recording::Time none(0);
    if (!are_stamped_)
      are_stamped_ = stamp > none;
    return *are_stamped_ && stamp >= none ? stamp : recorded;
  }

private:
  std::optional<bool> are_stamped_;
};

} // namespace pcl_ext::tools
