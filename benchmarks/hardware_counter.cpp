/** \file
 * The counters of the processor.
 */
#include "event_counter.h"

#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief The kernel's numbers of event_names. */
constexpr std::array<std::uint64_t, event_names.size()> event_configs = {
    PERF_COUNT_HW_CPU_CYCLES,
    PERF_COUNT_HW_INSTRUCTIONS,
    PERF_COUNT_HW_BRANCH_MISSES,
    PERF_COUNT_HW_CACHE_MISSES};

/** \brief A counter's value; see perf_event_open(2). */
struct Reading {
  std::uint64_t value = 0;
  std::uint64_t enabled_ns = 0;
  std::uint64_t running_ns = 0; ///< less if it shares the processor's registers
};

/** \return a file descriptor, or -1 with errno */
int
openEvent(std::uint64_t config)
{
  perf_event_attr attributes{};
  attributes.type = PERF_TYPE_HARDWARE;
  attributes.size = sizeof(attributes);
  attributes.config = config;
  attributes.disabled = 1;
  attributes.exclude_kernel = 1;
  attributes.exclude_hv = 1;
  attributes.read_format =
      PERF_FORMAT_TOTAL_TIME_ENABLED | PERF_FORMAT_TOTAL_TIME_RUNNING;
  constexpr int this_thread = 0;
  constexpr int any_processor = -1;
  constexpr int no_group = -1;
  return static_cast<int>(syscall(
      SYS_perf_event_open, &attributes, this_thread, any_processor, no_group, 0ul));
}

class HardwareCounter : public EventCounter {
public:
  HardwareCounter()
  {
    for (std::size_t i = 0; i < event_names.size(); ++i) {
      files_[i] = openEvent(event_configs[i]);
      if (files_[i] < 0) {
        reason_ = std::generic_category().message(errno);
        not_counted_ += std::string(not_counted_.empty() ? "" : ", ") + event_names[i];
      }
    }
  }

  ~HardwareCounter() override
  {
    for (const int file : files_)
      if (file >= 0)
        close(file);
  }

  HardwareCounter(const HardwareCounter&) = delete;
  HardwareCounter&
  operator=(const HardwareCounter&) = delete;

  EventCounts
  count(const std::function<void()>& action) override
  {
    forEachFile([](int file) { return ioctl(file, PERF_EVENT_IOC_RESET, 0) == 0; });
    // Its times are not reset.
    std::array<Reading, event_names.size()> before;
    readAll(before);
    forEachFile([](int file) { return ioctl(file, PERF_EVENT_IOC_ENABLE, 0) == 0; });
    action();
    forEachFile([](int file) { return ioctl(file, PERF_EVENT_IOC_DISABLE, 0) == 0; });
    std::array<Reading, event_names.size()> after;
    readAll(after);
    EventCounts counts;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const auto enabled =
          static_cast<double>(after[i].enabled_ns - before[i].enabled_ns);
      const auto running =
          static_cast<double>(after[i].running_ns - before[i].running_ns);
      if (files_[i] >= 0 && running > 0.0)
        counts[i] = static_cast<double>(after[i].value) * enabled / running;
    }
    return counts;
  }

  std::string
  description() const override
  {
    if (not_counted_.empty())
      return "Counted by the processor, without the kernel's part.";
    return "Not counted, as perf_event_open says \"" + reason_ + "\": " + not_counted_ +
           ".";
  }

private:
  template <typename CallT>
  void
  forEachFile(CallT&& call)
  {
    for (const int file : files_)
      if (file >= 0 && !call(file))
        throw std::system_error(errno, std::generic_category(), "performance counter");
  }

  void
  readAll(std::array<Reading, event_names.size()>& readings)
  {
    auto reading = readings.begin();
    for (const int file : files_) {
      if (file >= 0 && read(file, &*reading, sizeof(*reading)) != sizeof(*reading))
        throw std::system_error(errno, std::generic_category(), "performance counter");
      ++reading;
    }
  }

  std::array<int, event_names.size()> files_{};
  std::string not_counted_; // names
  std::string reason_;      // of the last of them
};

} // namespace

std::unique_ptr<EventCounter>
makeHardwareCounter()
{
  return std::make_unique<HardwareCounter>();
}

} // namespace measuring
} // namespace pcl_ext
