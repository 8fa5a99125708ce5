// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstdint>

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief Memory that the program can have, bytes: that of the machine, or of its control
 * group on Linux if that is less; 4 GiB where it is not known. */
std::uint64_t
machineMemory();

} // namespace pcl_ext::PCL_EXT_ABI::io
