// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "console/console.h"

#include <chrono>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Tells why a receiver gets nothing, or not all streams that it names, by the
 * streams that the server has. */
class MissingStreams {
public:
  /** \param[in] settings those of the receiver; it and console must outlive this */
  MissingStreams(const link::SubscriberSettings& settings, Console& console)
  : settings_(settings), console_(console)
  {}

  /** \brief Prints once what may be wrong where nothing comes; listens for a second.
   * \param[in] time since the receiver began
   */
  void
  remark(const link::FrameSubscriber& receiver,
         std::chrono::steady_clock::duration time);

  /** \brief Prints what has not come by the end.
   * \param[in] may_listen to find out why, for a second
   * \return true if that is something
   */
  bool
  report(const link::SubscriberStatistics& statistics, bool may_listen);

private:
  /** \brief Names of streams that were asked for and have not come. */
  std::vector<std::string>
  missing(const link::SubscriberStatistics& statistics) const;

  /** \brief The streams that are asked for, in words. */
  std::string
  described(const std::vector<std::string>& names) const;

  /** \brief What the server has in their place, or that it does not permit them. */
  std::string
  reason(const link::SubscriberStatistics& statistics) const;

  const link::SubscriberSettings& settings_;
  Console& console_;
  bool has_remarked_ = false;
};

} // namespace pcl_ext::tools
