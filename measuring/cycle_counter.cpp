// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "measuring/cycle_counter.h"

#ifdef __linux__
#include <linux/perf_event.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace pcl_ext {
namespace measuring {

#ifdef __linux__

CycleCounter::CycleCounter()
{
  perf_event_attr attributes{};
  attributes.type = PERF_TYPE_HARDWARE;
  attributes.size = sizeof(attributes);
  attributes.config = PERF_COUNT_HW_CPU_CYCLES;
  attributes.exclude_kernel = 1; // what users may count
  attributes.exclude_hv = 1;
  descriptor_ =
      static_cast<int>(syscall(SYS_perf_event_open, &attributes, 0, -1, -1, 0));
}

CycleCounter::~CycleCounter()
{
  if (isAvailable())
    ::close(descriptor_);
}

std::uint64_t
CycleCounter::count() const
{
  std::uint64_t cycles = 0;
  if (!isAvailable() || ::read(descriptor_, &cycles, sizeof(cycles)) != sizeof(cycles))
    return 0;
  return cycles;
}

#else

CycleCounter::CycleCounter() = default;
CycleCounter::~CycleCounter() = default;

std::uint64_t
CycleCounter::count() const
{
  return 0;
}

#endif

} // namespace measuring
} // namespace pcl_ext
