// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/version.h>

namespace pcl_ext::PCL_EXT_ABI {

const char*
version() noexcept
{
  return PCL_EXT_VERSION_TEXT;
}

} // namespace pcl_ext::PCL_EXT_ABI
