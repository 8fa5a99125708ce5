/** \file
 * \brief What a part of a program takes from the processor besides time.
 */
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief Names of what is counted, for tables. */
constexpr std::array<const char*, 4> event_names = {
    "cycles", "instructions", "branch misses", "cache misses"};

/** \brief A number of each of event_names; none where it is not counted. */
using EventCounts = std::array<std::optional<double>, event_names.size()>;

/** \brief Counts events of the calling thread, without the kernel's. */
class EventCounter {
public:
  virtual ~EventCounter() = default;

  /** \brief Runs an action.
   * \throws std::runtime_error if the counts cannot be read
   */
  virtual EventCounts
  count(const std::function<void()>& action) = 0;

  /** \brief A sentence on what counts, and what is not counted and why. */
  virtual std::string
  description() const = 0;

  /** \brief False if the action runs so slowly that its time says nothing. */
  virtual bool
  keepsTime() const
  {
    return true;
  }
};

/** \brief The processor's counters, by perf_event_open; those that the kernel or a virtual
 * machine does not offer are left out. */
std::unique_ptr<EventCounter>
makeHardwareCounter();

/** \brief Valgrind's simulated processor, in a program that runs under
 *
 *     valgrind --tool=callgrind --instr-atstart=no --branch-sim=yes --cache-sim=yes
 *              --callgrind-out-file=FILE
 *
 * \param[in] file FILE; callgrind writes each action's counts to FILE.1, FILE.2, ..., which
 * are removed
 * \throws std::runtime_error if the program does not run under valgrind, or was built
 * without valgrind's headers
 */
std::unique_ptr<EventCounter>
makeCallgrindCounter(const std::string& file);

} // namespace measuring
} // namespace pcl_ext
