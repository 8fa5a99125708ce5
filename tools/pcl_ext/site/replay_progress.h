// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "console/console.h"

#include <algorithm>
#include <cstdint>

namespace pcl_ext::tools {

/** \brief Shows how far a replay is. */
class ReplayProgress {
public:
  /** \param[in] subscriber that is connected; must outlive this
   * \param[in] console must outlive this
   */
  ReplayProgress(const link::FrameSubscriber& subscriber, Console& console)
  : subscriber_(subscriber)
  , console_(console)
  , pending_(subscriber.statistics().replay_pending)
  {
    console.startProgress("kept frames", pending_);
  }

  void
  show()
  {
    const std::uint64_t pending = subscriber_.statistics().replay_pending;
    if (pending < pending_)
      console_.advance(pending_ - pending);
    pending_ = std::min(pending_, pending);
  }

private:
  const link::FrameSubscriber& subscriber_;
  Console& console_;
  std::uint64_t pending_; // when it was shown last
};

} // namespace pcl_ext::tools
