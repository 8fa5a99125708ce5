#pragma once

#include <iosfwd>

namespace pcl_ext {
namespace benchmarks {

/** \brief Prints the line that tells the machine, the compiler and the load, without
 * which no figure below it means anything. */
void
printMachine(std::ostream& output);

/** \brief Programs that wanted a processor in the last minute, this one among them. */
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

} // namespace benchmarks
} // namespace pcl_ext
