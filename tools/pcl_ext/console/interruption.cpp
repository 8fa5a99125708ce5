#include "console/interruption.h"

#include <csignal>
#include <ctime>
#include <initializer_list>

namespace pcl_ext {
namespace tools {

namespace {

volatile std::sig_atomic_t is_interrupted = 0;
volatile std::sig_atomic_t first_second = 0; // when the first signal came

/** \brief Seconds of a clock that never goes back. */
std::sig_atomic_t
secondNow()
{
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::sig_atomic_t>(now.tv_sec);
}

void
noteInterruption(int signal)
{
  constexpr std::sig_atomic_t patience_s = 2;
  if (is_interrupted == 0) {
    first_second = secondNow();
    is_interrupted = 1;
  }
  // The command timeout sends its signal twice at once, and the kernel SIGXCPU each
  // second.
  else if (signal != SIGXCPU && secondNow() - first_second >= patience_s) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

} // namespace

void
catchInterruptions()
{
  struct sigaction action {};
  action.sa_handler = noteInterruption;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  // SIGXCPU: a soft limit on the time of the processor.
  for (const int signal : {SIGINT, SIGTERM, SIGXCPU})
    sigaction(signal, &action, nullptr);
  // After nohup it stays ignored.
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
    sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN); // a limit on file sizes, which writing then reports
}

bool
isInterrupted()
{
  return is_interrupted != 0;
}

} // namespace tools
} // namespace pcl_ext
