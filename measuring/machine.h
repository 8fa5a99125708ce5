// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief What figures of time depend on. */
struct Machine {
  std::string processor; ///< its name, that of the board, or "unknown"
  unsigned int cores = 0;
  double memory_gigabytes = 0.0;
  std::string system;   ///< distribution, kernel
  std::string compiler; ///< of this program
  double load = 0.0;    ///< see loadAverage()
};

/** \brief This machine, now. */
Machine
thisMachine();

/** \brief Prints a line with the machine, its system, the compiler, the versions, the
 * date and the load average. */
void
printMachine(std::ostream& output);

/** \brief The system's load average of the last minute. */
double
loadAverage();

/** \brief Processor seconds that all threads of this process took so far. */
double
processCpuSeconds();

/** \brief Processor seconds that the calling thread took so far. */
double
threadCpuSeconds();

/** \brief Memory of this process that is resident, megabytes. */
double
residentMegabytes();

/** \brief The most memory that was resident since the process began, megabytes. */
double
peakResidentMegabytes();

} // namespace measuring
} // namespace pcl_ext
