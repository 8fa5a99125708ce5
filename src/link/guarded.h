// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/link_settings.h>

#include <exception>
#include <new>

namespace pcl_ext::PCL_EXT_ABI::link {

/** \brief Calls a function; exceptions become a status. */
template <typename FunctionT>
LinkStatus
guarded(const FunctionT& function) noexcept
{
  try {
    return function();
  }
  catch (const std::bad_alloc&) {
    return outOfMemoryStatus<LinkStatus>();
  }
  catch (const std::exception&) {
    return {LinkCode::Closed, "thread failed"};
  }
}

} // namespace pcl_ext::PCL_EXT_ABI::link
