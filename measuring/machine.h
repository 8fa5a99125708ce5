#pragma once

#include <iosfwd>

namespace pcl_ext {
namespace measuring {

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

/** \brief Has peakResidentMegabytes() begin anew.
 * \throws std::runtime_error if the system does not offer it
 */
void
restartPeakResident();

/** \brief The most memory that was resident since restartPeakResident(), or since the
 * process began, megabytes. */
double
peakResidentMegabytes();

} // namespace measuring
} // namespace pcl_ext
