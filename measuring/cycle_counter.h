// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace pcl_ext {
namespace measuring {

/** \brief Cycles of the processor that the calling thread takes outside of the system,
 * where the system has a counter of them and permits it. */
class CycleCounter {
public:
  /** \brief Opens the counter of the calling thread, which is the only one to use it. */
  CycleCounter();
  ~CycleCounter();
  CycleCounter(const CycleCounter&) = delete;
  CycleCounter&
  operator=(const CycleCounter&) = delete;

  /** \brief False where there is no such counter: containers, virtual machines, or
   * kernel.perf_event_paranoid above 2. */
  bool
  isAvailable() const
  {
    return descriptor_ >= 0;
  }

  /** \brief Cycles since the beginning; 0 where there is no counter. */
  std::uint64_t
  count() const;

private:
  int descriptor_ = -1;
};

} // namespace measuring
} // namespace pcl_ext
