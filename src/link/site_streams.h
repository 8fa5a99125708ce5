// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Which streams a server has, by the subjects of their frames.
 */
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include <optional>
#include <string_view>
#include <tuple>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief The stream of a subject of frames, of any site; nothing if it is none. */
std::optional<SiteStream>
siteStreamOf(std::string_view subject);

inline bool
operator<(const SiteStream& a, const SiteStream& b)
{
  return std::tie(a.site, a.name, a.partition) < std::tie(b.site, b.name, b.partition);
}

} // namespace pcl_ext::PCL_EXT_ABI::link
