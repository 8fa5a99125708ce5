#pragma once

#include <iosfwd>

namespace pcl_ext {
namespace measuring {

/** \brief Prints the line that tells the machine, its system, the compiler, the versions,
 * the date and the load, without which no figure below it means anything. */
void
printMachine(std::ostream& output);

/** \brief The system's load average of the last minute: how many programs were running or
 * waiting for a processor or a disk. */
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

} // namespace measuring
} // namespace pcl_ext
