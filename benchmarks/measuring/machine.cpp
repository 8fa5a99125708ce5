#include "machine.h"

#include "markdown_table.h"

#include <pcl/pcl_config.h>

#include <time.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <ostream>
#include <string>
#include <thread>

namespace pcl_ext {
namespace benchmarks {

namespace {

/** \brief The processor's name where the system tells it. */
std::string
processorName()
{
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0)
      return line.substr(line.find(':') + 2);
  return "unknown";
}

double
clockSeconds(clockid_t clock)
{
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

} // namespace

double
loadAverage()
{
  double load = 0.0;
  return getloadavg(&load, 1) == 1 ? load : 0.0;
}

double
processCpuSeconds()
{
  return clockSeconds(CLOCK_PROCESS_CPUTIME_ID);
}

double
threadCpuSeconds()
{
  return clockSeconds(CLOCK_THREAD_CPUTIME_ID);
}

double
residentMegabytes()
{
  std::ifstream file("/proc/self/statm");
  double total_pages = 0.0;
  double resident_pages = 0.0;
  file >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void
printMachine(std::ostream& output)
{
  output << "Processor: " << processorName() << ", "
         << std::thread::hardware_concurrency() << " cores; compiler: " << __VERSION__
         << "; PCL " << PCL_VERSION_PRETTY << "; " << formatted(loadAverage(), 1)
         << " programs were running at the start.\n\n";
}

} // namespace benchmarks
} // namespace pcl_ext
