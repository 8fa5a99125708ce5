// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "recording/bag_reader.h"

#include <cstddef>
#include <vector>

namespace pcl_ext::tools {

/** \brief How many messages of a channel, the last ones, a subscriber gets that comes
 * later: those of publishers that latch (ROS 1) or are transient local; 0: none. */
std::size_t
latchedMessages(const recording::McapChannel& channel);

/** \brief Which messages of other topics a part of a bag has: those from one time until
 * another one, and before them the latched ones of that time.
 * \param[in] others messages in bag.index(), ascending
 * \return some of these
 */
std::vector<std::size_t>
othersOfPart(const recording::BagReader& bag,
             const std::vector<std::size_t>& others,
             recording::Time from,
             recording::Time to);

} // namespace pcl_ext::tools
