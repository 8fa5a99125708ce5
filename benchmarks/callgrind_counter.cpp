/** \file
 * The counters of valgrind's callgrind. Valgrind's header is optional.
 */
#include "event_counter.h"

#if defined(PCL_EXT_BENCHMARKS_VALGRIND)
#include <valgrind/callgrind.h>
#endif

#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

#if defined(PCL_EXT_BENCHMARKS_VALGRIND)

namespace {

/** \brief Callgrind's names of what one of event_names consists of; none for cycles. */
const std::array<std::vector<std::string>, event_names.size()> events_of_callgrind = {
    {{}, {"Ir"}, {"Bcm", "Bim"}, {"ILmr", "DLmr", "DLmw"}}};

/** \brief The sums that a file of callgrind ends with, by the event's name. */
std::map<std::string, double>
readTotals(const std::string& path)
{
  std::ifstream file(path);
  std::istringstream names;
  std::map<std::string, double> totals;
  std::string field;
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    fields >> field;
    if (field == "events:")
      names = std::move(fields);
    if (field != "totals:")
      continue;
    double total = 0.0;
    for (std::string name; names >> name && fields >> total;)
      totals[name] = total;
  }
  return totals;
}

class CallgrindCounter : public EventCounter {
public:
  explicit CallgrindCounter(std::string file) : file_(std::move(file)) {}

  EventCounts
  count(const std::function<void()>& action) override
  {
    // Once: with each start the simulated caches are empty.
    if (files_written_ == 0)
      CALLGRIND_START_INSTRUMENTATION;
    CALLGRIND_ZERO_STATS;
    action();
    CALLGRIND_DUMP_STATS;
    const std::string path = file_ + "." + std::to_string(++files_written_);
    const std::map<std::string, double> totals = readTotals(path);
    std::remove(path.c_str());
    if (totals.count("Ir") == 0)
      throw std::runtime_error("callgrind wrote no counts to '" + path +
                               "'; is it the file of --callgrind-out-file?");
    EventCounts counts;
    for (std::size_t i = 0; i < counts.size(); ++i)
      for (const std::string& event : events_of_callgrind[i])
        if (const auto total = totals.find(event); total != totals.end())
          counts[i] = counts[i].value_or(0.0) + total->second;
    return counts;
  }

  std::string
  description() const override
  {
    return "Counted by callgrind: instructions that run, and the misses of a simulated "
           "branch predictor and of simulated caches,\nthose of the last level.";
  }

  bool
  keepsTime() const override
  {
    return false;
  }

private:
  std::string file_;
  std::size_t files_written_ = 0;
};

} // namespace

std::unique_ptr<EventCounter>
makeCallgrindCounter(const std::string& file)
{
  if (RUNNING_ON_VALGRIND == 0)
    throw std::runtime_error(
        "--callgrind-file: the program does not run under valgrind");
  return std::make_unique<CallgrindCounter>(file);
}

#else

std::unique_ptr<EventCounter>
makeCallgrindCounter(const std::string& /*file*/)
{
  throw std::runtime_error(
      "--callgrind-file: the program was built without valgrind's headers");
}

#endif

} // namespace measuring
} // namespace pcl_ext
