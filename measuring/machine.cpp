// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "measuring/machine.h"

#include <pcl_ext/version.h>

#include "measuring/markdown_table.h"

#if __has_include(<pcl/pcl_config.h>)
#include <pcl/pcl_config.h>
#endif

#ifdef _WIN32
#include <windows.h>
#else
#include <sys/utsname.h>
#include <unistd.h>
#endif

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <ostream>
#include <string>
#include <thread>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief The processor's name; where the system does not tell, as on ARM, that of the
 * board, or else "unknown". */
std::string
processorName()
{
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0)
      return line.substr(line.find(':') + 2);
  std::ifstream board("/proc/device-tree/model");
  std::string name;
  std::getline(board, name, '\0'); // which ends it
  return name.empty() ? "unknown" : name;
}

#ifdef _WIN32

double
memoryGigabytes()
{
  MEMORYSTATUSEX memory{};
  memory.dwLength = sizeof(memory);
  ::GlobalMemoryStatusEx(&memory);
  return 1e-9 * static_cast<double>(memory.ullTotalPhys);
}

std::string
systemName()
{
  return "Windows";
}

/** \brief Of the system and the program, as GetProcessTimes() returns them. */
double
cpuSeconds(const FILETIME& kernel, const FILETIME& user)
{
  double seconds = 0.0;
  for (const FILETIME& time : {kernel, user})
    seconds += 1e-7 * (4294967296.0 * time.dwHighDateTime + time.dwLowDateTime);
  return seconds;
}

#else

/** \brief Memory of the machine. */
double
memoryGigabytes()
{
  return 1e-9 * static_cast<double>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<double>(sysconf(_SC_PAGESIZE));
}

/** \brief The distribution, if known, and the kernel. */
std::string
systemName()
{
  std::string name;
  std::ifstream file("/etc/os-release");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("PRETTY_NAME=", 0) == 0) {
      name = line.substr(line.find('=') + 1);
      name.erase(std::remove(name.begin(), name.end(), '"'), name.end());
      name += ", ";
    }
  utsname kernel{};
  uname(&kernel);
  return name + kernel.sysname + " " + kernel.release;
}

double
clockSeconds(clockid_t clock)
{
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

#endif

std::string
compilerName()
{
#if defined(__clang__)
  return std::string("Clang ") + __clang_version__;
#elif defined(__GNUC__)
  return std::string("GCC ") + __VERSION__;
#else
  return "unknown";
#endif
}

/** \brief Of today, UTC. */
std::string
date()
{
  const std::time_t now = std::time(nullptr);
  std::array<char, 11> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", std::gmtime(&now));
  return text.data();
}

} // namespace

#ifdef _WIN32

double
loadAverage()
{
  return 0.0;
}

double
processCpuSeconds()
{
  FILETIME begin{}, end{}, kernel{}, user{};
  ::GetProcessTimes(::GetCurrentProcess(), &begin, &end, &kernel, &user);
  return cpuSeconds(kernel, user);
}

double
threadCpuSeconds()
{
  FILETIME begin{}, end{}, kernel{}, user{};
  ::GetThreadTimes(::GetCurrentThread(), &begin, &end, &kernel, &user);
  return cpuSeconds(kernel, user);
}

double
residentMegabytes()
{
  return 0.0; // not measured there
}

#else

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

#endif

double
peakResidentMegabytes()
{
  std::ifstream file("/proc/self/status");
  for (std::string field; file >> field;)
    if (double kibibytes = 0.0; field == "VmHWM:" && file >> kibibytes)
      return kibibytes * 1024.0 / 1e6;
  return 0.0;
}

Machine
thisMachine()
{
  return {processorName(),
          std::thread::hardware_concurrency(),
          memoryGigabytes(),
          systemName(),
          compilerName(),
          loadAverage()};
}

void
printMachine(std::ostream& output)
{
  const Machine machine = thisMachine();
  output << "Processor: " << machine.processor << ", " << machine.cores
         << " cores; memory: " << formatted(machine.memory_gigabytes, 1)
         << " GB; system: " << machine.system << "; compiler: " << machine.compiler
#ifdef PCL_VERSION_PRETTY
         << "; PCL " << PCL_VERSION_PRETTY
#endif
         << "; pcl_ext " << PCL_EXT_VERSION_TEXT << "; " << date()
         << "; load average at the start: " << formatted(machine.load, 1) << ".\n\n";
}

} // namespace measuring
} // namespace pcl_ext
