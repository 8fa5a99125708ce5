// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bytes/machine_memory.h"

#include <algorithm>
#include <cstdio>
#if defined(__linux__) || defined(__APPLE__)
#include <unistd.h>
#endif

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

#if defined(__linux__)
/** \brief Limit of the control group; 0 if there is none. */
std::uint64_t
groupMemory()
{
  unsigned long long bytes = 0;
  if (std::FILE* const file = std::fopen("/sys/fs/cgroup/memory.max", "r")) {
    if (std::fscanf(file, "%llu", &bytes) != 1) // "max"
      bytes = 0;
    std::fclose(file);
  }
  return bytes;
}
#else
std::uint64_t
groupMemory()
{
  return 0;
}
#endif

} // namespace

std::uint64_t
machineMemory()
{
  std::uint64_t bytes = std::uint64_t{4} << 30;
#if defined(__linux__) || defined(__APPLE__)
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  if (pages > 0 && page_bytes > 0)
    bytes = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
#endif
  const std::uint64_t of_group = groupMemory();
  return of_group > 0 ? std::min(bytes, of_group) : bytes;
}

} // namespace pcl_ext::PCL_EXT_ABI::io
